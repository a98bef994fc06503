"""Docstrings end with an example that has no heading; the pages give it one, and show code."""

import re
from typing import Any

import griffe

HEADING = "Examples:"
_ROLE = re.compile(r":(?:func|class|meth|mod|data|attr):(?=`)")


class Examples(griffe.Extension):
    """Sets bare examples under a heading, as the parser of sections wants it."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite the docstring of a module, class, function or attribute."""
        if obj.docstring is not None:
            obj.docstring.value = with_heading(obj.docstring.value)


def with_heading(text: str) -> str:
    """The same text, its examples under the heading that the parser knows, indented.

    >>> with_heading("A sum.\\n\\n>>> 1 + 1\\n2")
    'A sum.\\n\\nExamples:\\n    >>> 1 + 1\\n    2'
    """
    parts = _ROLE.sub("", text).replace("\nExample:\n", f"\n{HEADING}\n").split("\n\n")
    for i, part in enumerate(parts):
        if part.startswith(">>> "):
            lines = [f"    {line}" for line in part.splitlines()]
            follows = i > 0 and parts[i - 1].startswith(HEADING)
            parts[i] = "\n".join(lines if follows else [HEADING, *lines])
    return "\n\n".join(parts)
