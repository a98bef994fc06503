"""Cells of CSV that no spreadsheet takes for a formula."""

import re

_MARK = "'"
_BEGINNINGS = "[=+\\-@\t\r'\uff1d\uff0b\uff0d\uff20]"  # their full-width forms as well
_PARTS = "(^|[;|\t\r\n])"  # where a cell begins for a reader with another delimiter
_FORMULA = re.compile(f"{_PARTS}(?={_BEGINNINGS})")
_MARKED = re.compile(f"{_PARTS}{_MARK}(?={_BEGINNINGS})")


def inert(text: str) -> str:
    """A text that spreadsheets show unchanged, with their mark for text before it.

    Numbers, percentages and a lone dash are unchanged.

    >>> inert("=HYPERLINK(...)"), inert("-1.5"), inert("rad/s")
    ("'=HYPERLINK(...)", '-1.5', 'rad/s')
    """
    return text if len(text) < 2 or _is_number(text) else _FORMULA.sub(rf"\1{_MARK}", text)


def as_written(cell: str) -> str:
    """The text of a cell that :func:`inert` made.

    >>> as_written("'=HYPERLINK(...)"), as_written("rad/s")
    ('=HYPERLINK(...)', 'rad/s')
    """
    return cell if len(cell) < 2 else _MARKED.sub(r"\1", cell)


def _is_number(text: str) -> bool:
    text = text.removesuffix(" %")
    try:
        float(text)
    except ValueError:
        return False
    return text.isascii() and "_" not in text and text == text.strip()
