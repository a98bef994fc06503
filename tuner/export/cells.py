"""Cells of CSV that no spreadsheet takes for a formula."""

_BEGINNINGS = tuple("=+-@\t\r'＝＋－＠")  # noqa: RUF001  # the wide ones do as well
_MARK = "'"


def inert(text: str) -> str:
    """A text that is shown as it is, with the mark before it that spreadsheets have for this.

    Numbers, and a dash alone, stay what they are.

    >>> inert("=HYPERLINK(...)"), inert("-1.5"), inert("rad/s")
    ("'=HYPERLINK(...)", '-1.5', 'rad/s')
    """
    if len(text) < 2 or not text.startswith(_BEGINNINGS) or _is_number(text):
        return text
    return f"{_MARK}{text}"


def as_written(cell: str) -> str:
    """The text that :func:`inert` made a cell of.

    >>> as_written("'=HYPERLINK(...)"), as_written("rad/s")
    ('=HYPERLINK(...)', 'rad/s')
    """
    return cell[1:] if cell.startswith(_MARK) and cell[1:].startswith(_BEGINNINGS) else cell


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return text.isascii() and "_" not in text and text == text.strip()
