"""A report as one HTML file that fetches nothing."""

import base64
import hashlib
from importlib.resources import files

from tuner.report.blocks import Report


def page(report: Report) -> bytes:
    """The file. Whatever text the run met is escaped, and no other script than its own runs."""
    from jinja2 import BaseLoader, Environment, StrictUndefined

    source = files("tuner.report")
    parts = {
        name: (source / name).read_text(encoding="utf-8")
        for name in ("page.html.jinja", "page.css", "page.js")
    }
    made = Environment(
        loader=BaseLoader(),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    script = parts["page.js"]
    html = made.from_string(parts["page.html.jinja"]).render(
        report=report, style=parts["page.css"], script=script, digest=_digest(script)
    )
    return html.encode("utf-8", "replace")


def _digest(script: str) -> str:
    """What tells the browser that this script, and no other, is ours."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
