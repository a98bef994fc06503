"""Install into .venv from the locked versions, then run `tuner` or the tests. Needs Python alone.

python3 bootstrap.py run kownacki2010     any arguments of the `tuner` command
python3 bootstrap.py test                 any arguments of pytest may follow
"""

import os
import re
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent
HOME = ROOT / ".venv"
BIN = HOME / ("Scripts" if os.name == "nt" else "bin")
PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")


def main(arguments: list[str]) -> int:
    """Install what the arguments need, then do what they say."""
    if sys.version_info < (3, 11):  # noqa: UP036  # pip would say so less plainly
        print(f"filter-tuner needs Python 3.11 or later, this is {sys.version.split()[0]}")
        return 2
    testing = arguments[:1] == ["test"]
    install("constraints-dev.txt" if testing else "constraints.txt")
    if testing:
        # One process per file: what its tests share is computed once.
        pytest = (PYTHON, "-m", "pytest", "-n", "auto", "--dist", "loadfile")
        return call(*pytest, *arguments[1:], folder=ROOT)
    return call(BIN / "tuner", *(arguments or ["--help"]), folder=Path.cwd())


def install(locked: str) -> None:
    """Make .venv, if it is not there, and install the locked versions and this project."""
    new = not PYTHON.exists()
    if new:
        venv.create(HOME, with_pip=True)
    pip = (PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps")
    if new:  # Python compiles what is imported, less than half of it
        pip += ("--no-compile",)
    # Hashes cannot be checked for a folder, so the project itself comes in a second step.
    if failed(pip, locked) or call(*pip, "--no-build-isolation", ".", folder=ROOT):
        sys.exit("the installation failed; the lines above say why")
    if new and sys.dont_write_bytecode:  # some packages hold templates that are no Python: no fault
        call(PYTHON, "-m", "compileall", "-qq", "-j", "0", "-x", "/tests/", HOME, folder=ROOT)


def failed(pip: tuple[str | Path, ...], locked: str) -> bool:
    """Install the locked versions by two processes side by side: each needs no other package."""
    text = (ROOT / locked).read_text(encoding="utf-8")
    packages = re.split(r"\n(?=\w)", text)
    with tempfile.TemporaryDirectory() as folder:
        running = []
        for k in range(2):
            half = Path(folder) / f"{k}.txt"
            half.write_text("\n".join(packages[k::2]) + "\n", encoding="utf-8")
            command = [*map(str, pip), "--require-hashes", "-r", str(half)]
            running.append(subprocess.Popen(command, cwd=ROOT))
        return sum(abs(process.wait()) for process in running) > 0


def call(*command: str | Path, folder: Path) -> int:
    """Run a command in a folder and return its exit code; its output goes where ours goes."""
    return subprocess.run([str(part) for part in command], cwd=folder, check=False).returncode


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
