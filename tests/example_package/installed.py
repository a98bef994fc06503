"""The example package as pip would leave it: the module and its metadata in one folder."""

import shutil
import tomllib
from pathlib import Path

SOURCE = Path(__file__).parent


def install(folder: Path) -> Path:
    """Put the package into a folder, which then belongs on ``sys.path`` or ``PYTHONPATH``.

    It takes no network and no pip: ``importlib.metadata`` finds a distribution by its folder
    ``*.dist-info``, and its filters by ``entry_points.txt`` in there.

    In a test of one's own process: ``monkeypatch.syspath_prepend(install(tmp_path))``. For a
    command: ``{**os.environ, "PYTHONPATH": str(install(tmp_path))}``.
    """
    project = tomllib.loads((SOURCE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    name, version = project["name"], project["version"]
    shutil.copy(SOURCE / "gauss_markov.py", folder)
    info = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir()
    metadata = f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
    (info / "METADATA").write_text(metadata, encoding="utf-8")
    lines = []
    for group, entries in project["entry-points"].items():
        lines += [f"[{group}]", *(f"{key} = {value}" for key, value in entries.items())]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder
