"""One cell of a text log: a number in any usual notation, or a word that says there is none."""

import math
import re
from collections.abc import Iterable

_WORDS = ("nan", "na", "n/a", "nat", "null", "nil", "none", "missing", "-", "--", "---", "?", ".")
_CODES = ("#n/a", "#na", "#value!", "#div/0!", "#num!", "#ref!", "nan(ind)", "-nan", "-nan(ind)")
MISSING = frozenset((*_WORDS, *_CODES))
"""Words of loggers and spreadsheets for a missing number, in lower case."""

_GROUPS = re.compile(
    r"[-+]?[1-9]\d{0,2}(?P<mark>[., '\xa0\u2009\u202f])\d{3}(?:(?P=mark)\d{3})*"
    r"(?:(?P<point>[.,])\d*)?"
)
_HEX = re.compile(r"0[xX][0-9a-fA-F]{1,12}")
_TRUTHS = {"true": 1.0, "false": 0.0}


def is_number(cell: str) -> bool:
    """Whether a cell is a number as programs write it.

    >>> [is_number(cell) for cell in ("-1.5e3", "1_000", "1,5", "")]
    [True, False, False, False]
    """
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def is_missing(cell: str) -> bool:
    """Whether a cell marks a missing number.

    >>> [is_missing(cell) for cell in ("", " NaN", "#N/A", "--", "0")]
    [True, True, True, True, False]
    """
    return not cell.strip() or cell.strip().lower() in MISSING


def read_cell(cell: str, point: str) -> tuple[float, str] | None:
    """The number in a cell, and the notation where it is unusual; None where there is none.

    Args:
        cell: as it is written.
        point: the decimal mark.

    >>> read_cell("1.234,5", ","), read_cell("1,234.5", ".")
    ((1234.5, "'.' between thousands"), (1234.5, "',' between thousands"))
    >>> read_cell("0x1F", "."), read_cell("NA", "."), read_cell("1,5", ".")
    ((31.0, 'hexadecimal'), (nan, "'NA' taken as missing"), None)
    """
    text = cell.strip()
    if not text:
        return math.nan, ""
    plain = text if point == "." else text.replace(point, ".") if "." not in text else ""
    if is_number(plain):
        return float(plain), ""
    if text.lower() in MISSING:
        return math.nan, f"{text!r} taken as missing"
    if text.lower() in _TRUTHS:
        return _TRUTHS[text.lower()], "true and false taken as 1 and 0"
    if _HEX.fullmatch(text):
        return float(int(text, 16)), "hexadecimal"
    return _grouped(text, point)


def _grouped(text: str, point: str) -> tuple[float, str] | None:
    """A number with marks between its thousands."""
    match = _GROUPS.fullmatch(text)
    if match is None or match["mark"] == point or match["point"] not in (None, point):
        return None
    number = text.replace(match["mark"], "").replace(point, ".")
    return float(number), f"{match['mark']!r} between thousands"


def decimal_mark(cells: Iterable[str]) -> tuple[str, str]:
    """The decimal mark of numbers, and a note where there are two readings.

    >>> decimal_mark(["21,60", "44,2"]), decimal_mark(["1.234,5"]), decimal_mark(["1.5", "2,5"])
    ((',', ''), (',', ''), ('.', ''))
    >>> decimal_mark(["1,234", "2,345"])
    (',', "'1,234' read as 1.234; where it is 1234, map it as COLUMN*1000")
    """
    marks, either = set(), ""
    for cell in cells:
        text = cell.strip()
        grouped = _GROUPS.fullmatch(text)
        if grouped and grouped["point"]:
            marks.add(grouped["point"])
        elif grouped and text.count(grouped["mark"]) > 1 and grouped["mark"] in ".,":
            marks.add(".,".replace(grouped["mark"], ""))
        elif grouped and grouped["mark"] == ",":
            either = either or text
        elif not grouped and "." in text and is_number(text):
            marks.add(".")
        elif "," in text and "." not in text and is_number(text.replace(",", ".", 1)):
            marks.add(",")
    if "." in marks or not (marks or either):
        return ".", ""
    if marks:
        return ",", ""
    note = f"{either!r} read as {either.replace(',', '.')}; where it is {either.replace(',', '')}"
    return ",", f"{note}, map it as COLUMN*1000"
