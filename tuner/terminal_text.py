"""Text for a terminal: control characters, which a terminal would obey, are written out."""

import re
from typing import Any, TextIO

_OBEYED = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"  # control characters, all but the tab and the line feed
    "\u061c\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069\ufeff"  # they turn or break lines
    "\ud800-\udfff]"  # halves of characters: bytes of a file's name that are not text
)


def printable(text: str) -> str:
    r"""The text without control characters: as JSON writes them, so that JSON stays what it is.

    >>> printable("gx\x1b[2J"), printable("rate\r\n")
    ('gx\\u001b[2J', 'rate\\u000d\n')
    """
    return _OBEYED.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def on_one_line(text: str) -> str:
    r"""The same on one line.

    >>> on_one_line("this cannot\nbe solved")
    'this cannot be solved'
    """
    return printable(" ".join(text.split()))


class PrintableStream:
    """A stream of text whose every character is safe for a terminal.

    Attributes:
        plain: the stream itself, for callers that clean their own text.
    """

    def __init__(self, plain: TextIO) -> None:
        self.plain = plain

    def write(self, text: str) -> int:
        """Write text, its control characters written out."""
        self.plain.write(printable(text))
        return len(text)

    def writelines(self, lines: "list[str]") -> None:
        """Write several texts."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.plain, name)


def plain(stream: TextIO) -> TextIO:
    """The stream behind :class:`PrintableStream`, or the stream itself."""
    return stream.plain if isinstance(stream, PrintableStream) else stream


def write_to_stream(data: bytes, stream: TextIO) -> None:
    """Write a file's bytes to a stream: unchanged, but to a terminal as safe text."""
    if stream.isatty():
        stream.write(printable(data.decode(errors="backslashreplace")))
    else:
        stream.buffer.write(data)
