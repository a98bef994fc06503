"""The code in README and docs has no wrong name, argument or attribute: it is type-checked."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
WRONG = Path(__file__).with_name("must_fail.py")


FILE = re.compile(r"# (\w+)\.py\n")
"""How a block begins that is a file, which the page's other blocks import."""


def code_alone(text, *, file=""):
    """The Python blocks of a page one after another, every line at its own number.

    Args:
        text: of the page.
        file: a block that is this file, alone; without one all blocks that are none.
    """
    kept = [""] * (text.count("\n") + 1)
    for block in re.finditer(r"```python\n(.*?)```", text, re.DOTALL):
        name = FILE.match(block[1])
        if (name[1] if name else "") == file:
            first = text.count("\n", 0, block.start(1))
            lines = block[1].splitlines()
            kept[first : first + len(lines)] = lines
    return "\n".join(kept) + "\n"


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What mypy says in one run: sets of (line, code), and the lines of words, by file."""
    pytest.importorskip("mypy")
    folder = tmp_path_factory.mktemp("checked")
    pages = folder / "pages"  # a package: the project's settings for `pages.*` apply
    pages.mkdir()
    (pages / "__init__.py").touch()
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        files = re.findall(rf"```python\n{FILE.pattern}", text)
        imports = re.compile(rf"^from ({'|'.join(files)}) import", re.MULTILINE)
        for file in ("", *files):
            code = code_alone(text, file=file)
            code = imports.sub(r"from pages.\1 import", code) if files else code
            name = file or page.stem.lower()
            (pages / f"{name}.py").write_text(code, encoding="utf-8")
    (pages / WRONG.name).write_text(WRONG.read_text(encoding="utf-8"), encoding="utf-8")
    words = [sys.executable, "-m", "mypy", "--hide-error-context", "--no-pretty"]
    ran = subprocess.run(
        [*words, "--no-error-summary", "--config-file", ROOT / "pyproject.toml", pages],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
        env=os.environ | {"MYPYPATH": f"{ROOT}{os.pathsep}{folder}"},
    )
    assert ran.returncode in {0, 1}, ran.stdout + ran.stderr
    return ran.stdout.splitlines()


def refused(found, page):
    """Line and code of every error in a page."""
    told = re.compile(rf"(?:.*[/\\])?{re.escape(page)}:(\d+): error: .*\[([a-z-]+)\]$")
    return {(int(match[1]), match[2]) for match in map(told.match, found) if match}


def test_code_on_pages_is_typed(found):
    assert sum("import" in code_alone(page.read_text(encoding="utf-8")) for page in PAGES) > 3
    told = [line for line in found if WRONG.name not in line]
    assert not told, "\n".join(told)


def test_what_is_wrong_is_refused_line_by_line(found):
    lines = enumerate(WRONG.read_text(encoding="utf-8").splitlines(), start=1)
    marks = ((i, re.search(r"# refused: ([a-z-]+)$", line)) for i, line in lines)
    assert refused(found, WRONG.name) == {(i, mark[1]) for i, mark in marks if mark}


def test_code_keeps_its_place_on_the_page():
    text = "# A\n\n```python\na = 1\nb = 2\n```\nwords\n\n```python\nc = 3\n```\n```sh\nno\n```\n"
    lines = code_alone(text).splitlines()
    assert {i + 1: line for i, line in enumerate(lines) if line} == {
        4: "a = 1",
        5: "b = 2",
        10: "c = 3",
    }
