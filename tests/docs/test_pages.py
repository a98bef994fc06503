"""The site names every page and every public name."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SITE = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")


def test_every_page_is_in_the_navigation():
    pages = {str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.md")}
    assert set(re.findall(r"([\w/]+\.md)$", SITE, re.MULTILINE)) == pages


def test_every_public_name_is_in_the_reference():
    listed = (ROOT / "tuner" / "__init__.pyi").read_text(encoding="utf-8")
    public = set(re.findall(r"^from \S+ import (\w+) as \1$", listed, re.MULTILINE))
    page = (ROOT / "docs" / "reference" / "tuner.md").read_text(encoding="utf-8")
    described = re.findall(r"^::: [\w.]+\.(\w+)$", page, re.MULTILINE)
    elsewhere = re.findall(r"^\[`(\w+)`\]\(objectives\.md#objectives\.\1\)", page, re.MULTILINE)
    assert sorted([*described, *elsewhere]) == sorted(public)
