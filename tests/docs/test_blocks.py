"""The code in README and docs runs: Python blocks as they stand, `tuner` lines as dry runs."""

import json
import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest

from tuner.cli import invoke
from tuner.model import model_filter, read_model

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(language):
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for i, match in enumerate(re.finditer(rf"```{language}\n(.*?)```", text, re.DOTALL)):
            found.append(pytest.param(match[1], id=f"{page.name}-{i}"))
    return found


_FILE = r"```(?:python|toml)\n# (\w+\.(?:py|toml))\n(.*?)```"
FILES = {  # blocks that begin with a file's name, which other blocks may import, or read
    match[1]: match[2]
    for page in PAGES
    for match in re.finditer(_FILE, page.read_text(encoding="utf-8"), re.DOTALL)
}


@pytest.fixture
def files(tmp_path, monkeypatch):
    """A folder with the files that the pages show, on the path."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    for name, text in FILES.items():
        Path(name).write_text(text, encoding="utf-8")
    yield
    for name in FILES:
        sys.modules.pop(Path(name).stem, None)


@pytest.mark.parametrize("code", blocks("python"))
@pytest.mark.usefixtures("files")
def test_python_block_runs(code):
    exec(compile(code, "block", "exec"), {"__name__": "block"})


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """A folder with the logs that the pages speak of."""
    monkeypatch.chdir(tmp_path)
    draw = np.random.default_rng(3)
    record = draw.standard_normal(1200).round(4)
    Path("rest.csv").write_text("gyro_x\n" + "\n".join(map(str, record)) + "\n")
    np.savez("rest.npz", gyr=draw.standard_normal((600, 3)))
    rows = np.arange(200)
    walk = np.cumsum(draw.standard_normal(200))
    pressure = 101325 + walk + draw.standard_normal(200)
    _csv("level.csv", millis=100 * rows, pressure=pressure, reference=101325 + 0.9 * walk)
    heights = [f"{z:.2f}" if k % 5 == 0 else "" for k, z in enumerate(walk)]
    _csv("vario.csv", t_ms=20 * rows, acc_up=draw.standard_normal(200).round(3), height=heights)
    _csv("track.csv", t=rows, lat=48 + 1e-5 * walk, lon=11 + 1e-5 * walk, accuracy=3 + rows % 4)
    upright = np.tile([1.0, 0.0, 0.0, 0.0], (200, 1))
    force = [0.0, 0.0, 1.0] + 0.01 * draw.standard_normal((200, 3))
    np.savez("imu.npz", gyr=draw.standard_normal((200, 3)), acc=force, quat=upright, fs=50.0)
    return tmp_path


def _csv(name, **columns):
    rows = zip(*(map(str, column) for column in columns.values()), strict=True)
    Path(name).write_text("\n".join([",".join(columns), *map(",".join, rows)]) + "\n")


def commands(code):
    """The lines of a shell block that start with tuner, without their comments."""
    return [
        shlex.split(line, comments=True)[1:]
        for line in code.splitlines()
        if line.startswith("tuner ")
    ]


def _lines(page):
    """All commands of a page's shell blocks."""
    return commands("".join(re.findall(r"```sh\n(.*?)```", page, re.DOTALL)))


DESIGNS = [block for block in blocks("toml") if "study =" in block.values[0]]
MODELS = [block for block in blocks("toml") if "[model]" in block.values[0]]


@pytest.mark.parametrize("text", MODELS)
def test_models_can_be_read(text, tmp_path):
    path = tmp_path / "model.toml"
    path.write_text(text)
    assert model_filter(read_model(path)).states


@pytest.mark.parametrize("text", DESIGNS)
def test_designs_can_be_planned(text, desk, capfd):
    (desk / "design.toml").write_text(text)
    assert invoke(["run", str(desk / "design.toml"), "--dry-run"]) == 0
    assert "would solve" in capfd.readouterr().out


def test_readme_commands_run_one_after_another(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = _lines(text)
    assert [line[0] for line in lines] == ["example", "fit", "export"]
    for line in lines:
        quick = ["--starts", "1", "--no-hold-out"] if line[0] == "fit" else []
        assert invoke([*line, *quick]) == 0
    assert "vertical_step" in Path("vertical.h").read_text()
    found = json.loads(Path("vario/result.json").read_text())["solutions"][0]["parameters"]
    use = next(line for line in text.splitlines() if line.startswith("use "))
    assert f"q_acc = {found['q_acc']['value']:.3g}"[:-1] in use
    assert use in (ROOT / "docs" / "start.md").read_text(encoding="utf-8")


def test_the_check_of_its_page_runs(desk, capfd):
    text = (ROOT / "docs" / "diagnostics.md").read_text(encoding="utf-8")
    (line,) = _lines(text)
    assert invoke(line) == 0
    assert "Diagnostics" in capfd.readouterr().out


@pytest.mark.parametrize("page", ["kownacki2010.md", "fit.md", "rest.md"])
def test_study_page_command_runs(desk, page):
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    lines = _lines(text)
    assert lines
    for line in lines:
        assert invoke([*line, "--dry-run"]) == 0


@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "how_to").glob("*.md")), ids=str)
def test_the_commands_of_how_tos_can_be_planned(page, tmp_path, monkeypatch):
    """Examples and lists are real, fits and studies are planned; what needs a run is left out."""
    monkeypatch.chdir(tmp_path)
    text = page.read_text(encoding="utf-8")
    for line in _lines(text):
        if line[0] in ("fit", "run"):
            assert invoke([*line, "--dry-run"]) == 0
        elif line[0] in ("example", "list", "check"):
            assert invoke(line) == 0
            if line[0] == "example":  # a short part of it is planned as the whole is
                log = Path(f"{line[1]}.csv")
                log.write_text("\n".join(log.read_text().splitlines()[:602]) + "\n")
        else:
            assert line[0] in ("export", "compare")


def test_the_five_minutes_run_what_the_readme_runs():
    start = _lines((ROOT / "docs" / "start.md").read_text(encoding="utf-8"))
    assert start[0] == ["doctor"]
    readme = _lines((ROOT / "README.md").read_text(encoding="utf-8"))
    assert start[1:-1] == readme[:-1]
    assert start[-1] == ["export", "vario", "--to", "c", "--precision", "float", "-o", "vertical.h"]


def test_the_commands_of_the_page_of_models_run(desk):
    text = (ROOT / "docs" / "models.md").read_text(encoding="utf-8")
    init, fit = commands(re.search(r"```sh\n(.*?)```", text, re.DOTALL)[1])
    assert invoke(init) == 0
    assert invoke([*fit, "--dry-run"]) == 0


def test_links_between_pages_exist():
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"
