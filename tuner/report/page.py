"""A report as one HTML file that fetches nothing."""

import base64
import hashlib
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from tuner.report.blocks import Report

if TYPE_CHECKING:
    from jinja2 import Template


def page(report: Report) -> bytes:
    """The file. Whatever text the run met is escaped, and no other script than its own runs."""
    style, script = _text("page.css"), _text("page.js")
    html = _template().render(report=report, style=style, script=script, digest=_digest(script))
    return html.encode("utf-8", "replace")


@cache
def _template() -> "Template":
    from jinja2 import BaseLoader, Environment, StrictUndefined

    made = Environment(
        loader=BaseLoader(),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return made.from_string(_text("page.html.jinja"))


def _text(name: str) -> str:
    return (files("tuner.report") / name).read_text(encoding="utf-8")


def _digest(script: str) -> str:
    """The policy by which the browser runs this script and no other."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
