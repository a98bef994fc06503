"""Python's syntax trees, also in threads."""

import ast
from threading import Lock
from typing import Any, Literal

_PARSING = Lock()


def parsed(text: str, mode: Literal["exec", "eval"] = "exec") -> Any:
    """The syntax tree of a source.

    Python 3.11 counts the depth of the trees of all threads together, and raises a SystemError
    where two are made at once (python/cpython issue 106905): here one is made at a time.

    Raises:
        SyntaxError: where it is none.
        ValueError: for a source with null bytes.
    """
    with _PARSING:
        return ast.parse(text, mode=mode)
