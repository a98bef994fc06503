"""How wide tables are where they do not go to a terminal."""

import os
import sys
from contextlib import suppress

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


def _columns() -> int:
    told = os.environ.get("COLUMNS", "")
    return int(told) if told.isascii() and told.isdigit() else 0


def _of_terminal() -> int:
    """Columns of the terminal that messages go to; 0 for none."""
    for stream in (sys.__stderr__, sys.__stdin__):
        if stream is not None:
            with suppress(OSError, ValueError):
                return os.get_terminal_size(stream.fileno()).columns
    return 0
