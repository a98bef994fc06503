"""Checks of zip files before they are read: number and unpacked size of their members."""

import struct
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

from tuner.data.logs.error import LogError
from tuner.files import opened
from tuner.limits import largest, size_text, unpacked

DAMAGE = (
    OSError, EOFError, ValueError, KeyError, IndexError, TypeError, OverflowError, SyntaxError,
    MemoryError, NotImplementedError, RuntimeError, struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""Exceptions of readers of a damaged zip file."""

MOST = 1000
"""Most files of an archive or a folder, and arrays of an NPZ file."""

_END, _TAIL = b"PK\x05\x06", 65_557
_INDEX = 1 << 24


def check_index(path: Path) -> None:
    """Refuse a zip file whose list of members is megabytes long, which are gigabytes in memory.

    Raises:
        LogError: in one sentence.
    """
    with opened(path) as stream:
        stream.seek(max(path.stat().st_size - _TAIL, 0))
        tail = stream.read(_TAIL)
    at = tail.rfind(_END)
    if at >= 0 and len(tail) >= at + 16 and struct.unpack_from("<I", tail, at + 12)[0] > _INDEX:
        raise LogError(f"{path.name}: the archive lists far too many files; pack the log's alone")


def check_sizes(path: Path, members: Sequence[zipfile.ZipInfo], what: str) -> None:
    """Refuse members that would unpack to more than a log does.

    Raises:
        LogError: in one sentence.
    """
    size, held = sum(member.file_size for member in members), path.stat().st_size
    if size > unpacked(held):
        raise LogError(
            f"{path.name}: {what} would unpack to {size_text(size)} from {size_text(held)}, which "
            "no log does; unpack it yourself, or save it uncompressed"
        )
    if size > largest():
        raise LogError(
            f"{path.name}: {what} would take {size_text(size)}, where {size_text(largest())} is "
            "the most; cut the log into parts, or set another limit by --memory"
        )
