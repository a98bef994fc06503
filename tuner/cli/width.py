"""How wide tables are where they do not go to a terminal."""

import os
import sys
from contextlib import suppress
from shutil import get_terminal_size
from textwrap import fill

PLAIN = 150
"""Columns where nobody tells."""


def piped_width() -> int:
    """The width in COLUMNS; or that of the terminal of stderr, as with a pager; or 150.

    >>> import os
    >>> os.environ["COLUMNS"] = "72"
    >>> piped_width()
    72
    >>> del os.environ["COLUMNS"]
    """
    return _columns() or _of_terminal() or PLAIN


def width_is_known() -> bool:
    """Whether lines end somewhere: in a terminal, in a pager of one, or where COLUMNS says."""
    return sys.stdout.isatty() or bool(_columns() or _of_terminal())


def wrapped(line: str, indent: int) -> str:
    """A line in as many as it takes, the others indented; the same where nobody knows the width.

    >>> import os
    >>> os.environ["COLUMNS"] = "28"
    >>> print(wrapped("rmse  error of an output, in its unit", 6))
    rmse  error of an output, in
          its unit
    >>> del os.environ["COLUMNS"]
    """
    if not width_is_known():
        return line
    terminal = sys.stdout.isatty()
    width = get_terminal_size().columns if terminal else piped_width()
    gap = " " * indent
    return fill(line, max(width, indent + 20), subsequent_indent=gap, break_on_hyphens=False)


def _columns() -> int:
    text = os.environ.get("COLUMNS", "")
    return int(text) if text.isascii() and text.isdigit() else 0


def _of_terminal() -> int:
    """Columns of the terminal that messages go to; 0 for none."""
    for stream in (sys.__stderr__, sys.__stdin__):
        if stream is not None:
            with suppress(OSError, ValueError):
                return os.get_terminal_size(stream.fileno()).columns
    return 0
