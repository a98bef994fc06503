"""The code in README and docs runs: Python blocks as they stand, `tuner` lines as dry runs."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from tuner.cli import invoke

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(language):
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for i, match in enumerate(re.finditer(rf"```{language}\n(.*?)```", text, re.DOTALL)):
            found.append(pytest.param(match[1], id=f"{page.name}-{i}"))
    return found


@pytest.mark.parametrize("code", blocks("python"))
def test_python_block_runs(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "block", "exec"), {"__name__": "block"})


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """A folder with the logs that the pages speak of."""
    monkeypatch.chdir(tmp_path)
    draw = np.random.default_rng(3)
    record = draw.standard_normal(600).round(4)
    Path("rest.csv").write_text("gyro_x\n" + "\n".join(map(str, record)) + "\n")
    np.savez("rest.npz", gyr=draw.standard_normal((600, 3)))
    return tmp_path


def commands(code):
    """The lines of a shell block that start with tuner, without their comments."""
    return [
        shlex.split(line, comments=True)[1:]
        for line in code.splitlines()
        if line.startswith("tuner ")
    ]


@pytest.mark.parametrize("text", blocks("toml"))
def test_designs_can_be_planned(text, tmp_path, capfd):
    (tmp_path / "design.toml").write_text(text)
    assert invoke(["run", str(tmp_path / "design.toml"), "--dry-run"]) == 0
    assert "would solve" in capfd.readouterr().out


QUICK = ["--set", "starts=1", "--set", "solvers=l-bfgs-b", "--set", "grid=2"]


def test_readme_commands_run_one_after_another(desk):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    lines = [
        c for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL) for c in commands(block)
    ]
    assert [line[0] for line in lines] == ["run", "export", "run", "compare"]
    for line in lines:
        # Some of the paper's own numbers do not come out, which compare reports as 1.
        expected = 1 if line[0] == "compare" else 0
        assert invoke([*line, *(QUICK if line[0] == "run" else [])]) == expected
    assert Path("gyro.h").read_text().count("gyro_step") >= 1


def test_study_page_command_runs(desk):
    text = (ROOT / "docs" / "kownacki2010.md").read_text(encoding="utf-8")
    (line,) = [
        c for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL) for c in commands(block)
    ]
    assert invoke([*line, "--dry-run"]) == 0


def test_links_between_pages_exist():
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"
