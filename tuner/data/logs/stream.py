"""The bytes of a text log: plain or gzip-compressed, in any usual encoding, as whole lines."""

import codecs
import csv
import gzip
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from tuner.data.logs.error import LogError
from tuner.limits import size_text, unpacked

_GZIP = b"\x1f\x8b"
_PROBE = 1 << 16
_HEAD = 1 << 18
_FEW = 30
_BLOCK = 1 << 20
_LONGEST_LINE = 1 << 24
_SHARE = 0.8
_ZEROS = 0.05  # a log on flash memory may have lost a page
_MARKS = {
    codecs.BOM_UTF8: "utf-8",
    codecs.BOM_UTF16_LE: "utf-16-le",
    codecs.BOM_UTF16_BE: "utf-16-be",
}


@dataclass(frozen=True)
class Encoding:
    """The character encoding of a text.

    Attributes:
        name: its name in Python.
        mark: its byte order mark before the first letter.
        old_lines: whether lines end with a carriage return alone.
    """

    name: str
    mark: int = 0
    old_lines: bool = False

    @property
    def note(self) -> str:
        """A note on an unusual encoding; "" for the usual one."""
        return "" if self.name == "utf-8" else f"letters read as {self.name}"

    @property
    def letters(self) -> str:
        """The encoding of the lines of :func:`blocks`."""
        return "cp1252" if self.name == "cp1252" else "utf-8"


def read_head(path: Path) -> tuple[bytes, Encoding]:
    """The first whole lines of a text log, as UTF-8 or cp1252, and its encoding.

    A text whose beginning is not UTF-8 is taken as cp1252, the usual alternative.

    Raises:
        LogError: where the file is no text.
    """
    encoding = _encoding(next(_chunks(path, _PROBE), b""))
    if _is_packed(path):
        for _ in _chunks(path, _BLOCK):
            pass  # to its end, so that too large a text is refused before anything is stored
    head = b""
    for block in lines(path, encoding, _HEAD):
        head += block
        if head.count(b"\n") > _FEW:
            break
    if head.count(0) > _ZEROS * len(head):
        raise LogError(
            f"{path.name}: the file is neither text nor of a known format; export it as CSV"
        )
    return head, encoding


def is_content(line: str) -> bool:
    """Whether a line is neither blank nor a comment; a tab alone may separate empty cells."""
    text = line.strip(" \r\n")
    return bool(text) and text[0] not in "#%"


def split(lines: Iterable[str], delimiter: str | None) -> Iterator[list[str]]:
    """The cells of each line."""
    if delimiter is None:
        return (line.split() for line in lines)
    readers = (csv.reader([line], delimiter=delimiter, skipinitialspace=True) for line in lines)
    return (cells for reader in readers for cells in reader)


def lines(path: Path, encoding: Encoding, size: int = _BLOCK) -> Iterator[bytes]:
    """Blocks of whole lines, each ended by a line feed; the last one may lack it.

    Raises:
        LogError: for a line of megabytes, and a compressed file that unpacks to too much.
    """
    decoder = None
    if encoding.name.startswith("utf-16"):
        decoder = codecs.getincrementaldecoder(encoding.name)("replace")
    rest, skipped = b"", encoding.mark
    for raw in _chunks(path, size):
        new = raw[skipped:] if skipped else raw
        skipped = 0
        text = rest + (new if decoder is None else decoder.decode(new).encode())
        text = text.replace(b"\r\n", b"\n") if b"\r" in text else text
        if encoding.old_lines:
            text = text.replace(b"\r", b"\n")
        cut = text.rfind(b"\n") + 1
        rest = text[cut:]
        if len(rest) > _LONGEST_LINE:
            raise LogError(
                f"{path.name}: a line is longer than {_LONGEST_LINE >> 20} MB; "
                "export the log as CSV with a line for each sample"
            )
        if cut:
            yield text[:cut]
    if rest := rest.rstrip(b"\r"):
        yield rest


def _is_packed(path: Path) -> bool:
    with path.open("rb") as stream:
        return stream.read(len(_GZIP)) == _GZIP


def _chunks(path: Path, size: int) -> Iterator[bytes]:
    """The bytes of the text, unpacked where compressed, up to the limit for a log."""
    held = path.stat().st_size
    packed = _is_packed(path)
    most = unpacked(held)
    read = 0
    with gzip.open(path, "rb") if packed else path.open("rb") as stream:
        while data := stream.read(size):
            read += len(data)
            if packed and read > most:
                raise LogError(
                    f"{path.name}: {held >> 10} kB unpack to more than {size_text(most)}; a log "
                    "does not shrink like that; unpack it yourself"
                )
            yield data


def _encoding(head: bytes) -> Encoding:
    """The encoding of the first bytes, by their mark or the places of their zeros."""
    for mark, name in _MARKS.items():
        if head.startswith(mark):
            return _with_lines(head, Encoding(name, len(mark)))
    pairs = len(head) // 2
    for name, zeros in (("utf-16-le", head[1::2]), ("utf-16-be", head[::2])):
        if pairs and zeros.count(0) > _SHARE * pairs and head.count(0) < 1.2 * zeros.count(0):
            return _with_lines(head, Encoding(name))
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)  # a letter may be cut at the end
    except UnicodeDecodeError:
        return _with_lines(head, Encoding("cp1252"))
    return _with_lines(head, Encoding("utf-8"))


def _with_lines(head: bytes, encoding: Encoding) -> Encoding:
    return replace(encoding, old_lines=b"\r" in head and b"\n" not in head)
