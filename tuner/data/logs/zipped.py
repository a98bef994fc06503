"""Zip files: checks of their members' number and size, and reading of members without packing."""

import struct
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

from tuner.data.logs.blocks import Blocks
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
_LOCAL, _LENGTHS, _ENCRYPTED = 30, 26, 1
_BLOCK = 1 << 21
"""Bytes that are read at a time; of fewer, threads would wait for Python more often."""


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


def is_stored(member: zipfile.ZipInfo) -> bool:
    """Whether a member lies in the archive as it is, neither packed nor encrypted."""
    plain = member.compress_type == zipfile.ZIP_STORED and not member.flag_bits & _ENCRYPTED
    return plain and member.compress_size == member.file_size


def read_stored(
    path: Path, member: zipfile.ZipInfo, begins: int, memory: memoryview, blocks: Blocks
) -> None:
    """Read a stored member from a place to its end, and compare the checksum of all of it.

    ``zipfile`` would copy each byte twice, which takes as long as the checksum.

    Args:
        path: the archive, in which ``zipfile`` has found and opened the member.
        member: a member for which :func:`is_stored` holds.
        begins: bytes of it that are passed over.
        memory: what follows them is written here.
        blocks: passes it on, too.

    Raises:
        zipfile.BadZipFile: where the bytes are others than the checksum's.
        EOFError: where the archive ends too early.
    """
    with opened(path) as stream:
        stream.seek(member.header_offset + _LENGTHS)
        name, extra = struct.unpack("<HH", stream.read(4))
        start = member.header_offset + _LOCAL + name + extra
        stream.seek(start)
        checksum = zlib.crc32(stream.read(begins))
        for at in range(0, len(memory), _BLOCK):
            block = memory[at : at + _BLOCK]
            if stream.readinto(block) != len(block):
                raise EOFError(f"{member.filename!r} ends too early")
            blocks.put(start + begins + at, block)
            checksum = zlib.crc32(block, checksum)
    if checksum != member.CRC:
        raise zipfile.BadZipFile(f"Bad CRC-32 for file {member.filename!r}")
