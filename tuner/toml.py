"""TOML within bounds: its reader needs unlimited time and stack for deep nesting."""

import re
import tomllib
from pathlib import Path
from typing import Any

from tuner.files import whole

DEEPEST = 32
"""Deepest nesting of lists and tables, more than twice that of any document read here."""

_STRINGS = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""))*(?:"""|\Z)'
    r"|'''(?:[^']|'(?!''))*(?:'''|\Z)"
    r'|"(?:[^"\\\n]|\\.)*"?'
    r"|'[^'\n]*'?|\#[^\n]*",
    re.DOTALL,
)
_BRACKETS = re.compile(r"[\[\]{}]")
_BETWEEN = re.compile(r"[,{}\[\]=\n]")


def read_toml(path: Path, most: int, what: str) -> dict[str, Any]:
    """The document in a file.

    Args:
        path: the file.
        most: largest size in bytes.
        what: what it should be, such as "study.toml".

    Raises:
        OSError: where it is not there, or may not be read.
        ValueError: in one sentence, where it is not a file, too large, too deep or not TOML.
    """
    data = whole(path, most, what)
    try:
        text = data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise ValueError("it is no text in UTF-8; save it as such") from None
    return parsed(text)


def parsed(text: str) -> dict[str, Any]:
    """The document of a text.

    Raises:
        ValueError: in one sentence, where it is too deep or not TOML.

    >>> parsed("a = [1, 2]")
    {'a': [1, 2]}
    >>> parsed("a = " + 99 * "[" + 99 * "]")
    Traceback (most recent call last):
    ValueError: it has lists or tables more than 32 deep; write them flat
    """
    if _depth(text) > DEEPEST:
        raise ValueError(f"it has lists or tables more than {DEEPEST} deep; write them flat")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("it has lists or tables far too deep; write them flat") from None
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:  # of Python's own int
        raise ValueError("it holds a number of thousands of digits; shorten it") from None


def _depth(text: str) -> int:
    """Greatest depth of lists, tables and dotted names of tables, without strings."""
    bare = _STRINGS.sub("", text)
    depth = deepest = 0
    for bracket in _BRACKETS.findall(bare):
        depth = depth + 1 if bracket in "[{" else max(depth - 1, 0)
        deepest = max(deepest, depth)
    dots = max((part.count(".") for part in _BETWEEN.split(bare)), default=0)
    return max(deepest, dots)
