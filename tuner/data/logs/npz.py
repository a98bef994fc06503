"""NPZ logs: numpy's archives of plain arrays, never pickles, each read by its header."""

import math
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.lib import format as npy

from tuner.data.logs.blocks import Blocks
from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw, Table
from tuner.data.logs.zipped import (
    DAMAGE,
    MOST,
    check_index,
    check_sizes,
    is_stored,
    read_stored,
)

_BLOCK = 1 << 20
_ENDING = ".npy"


def open_npz(path: Path) -> Table:
    """Open an NPZ file; its arrays are the columns, its 0-d arrays the scalars.

    Raises:
        LogError: where the archive is damaged or holds no arrays; loading raises it for
            pickles, and for arrays that would unpack to more than a log does.
    """
    try:
        check_index(path)
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
    except DAMAGE as error:
        raise _damaged(path, error) from error
    arrays = {
        member.filename.removesuffix(_ENDING): member
        for member in members
        if member.filename.endswith(_ENDING)
    }
    if not arrays:
        raise LogError(
            f"{path.name}: the archive holds no numpy arrays; unpack it, or save them with np.savez"
        )

    if len(arrays) > MOST:
        raise LogError(f"{path.name}: the archive holds more than {MOST} arrays; save fewer")

    blocks = Blocks()

    def load(names: Sequence[str]) -> dict[str, Raw]:
        chosen = {name: arrays[name] for name in names}
        check_sizes(path, list(chosen.values()), f"{', '.join(map(repr, names))[:60]}")
        in_order = sorted(chosen, key=lambda name: chosen[name].header_offset)
        found = {name: _load(path, name, chosen[name], blocks) for name in in_order}
        blocks.close()
        return {name: found[name] for name in chosen}

    return Table(path.name, tuple(arrays), load, format="archive of numpy arrays", blocks=blocks)


def _load(path: Path, name: str, member: zipfile.ZipInfo, blocks: Blocks) -> Raw:
    """One array of the archive."""
    try:
        with zipfile.ZipFile(path) as archive, archive.open(member) as stream:
            header = _header(path, name, stream)
            if is_stored(member) and _size(header) == member.file_size - stream.tell():
                return _copied(path, member, header, stream.tell(), blocks)
            return _numbers(stream, header, member.file_size)
    except LogError:
        raise
    except Exception as error:  # numpy reads headers as Python, which can raise anything
        raise _damaged(path, error) from error


class _Header(NamedTuple):
    """The beginning of an array's file."""

    shape: tuple[int, ...]
    in_columns: bool
    dtype: Any


def _header(path: Path, name: str, stream: IO[bytes]) -> _Header:
    try:
        version = npy.read_magic(stream)
    except ValueError:
        raise LogError(
            f"{path.name}: {name!r} is no numpy array; save the log with np.savez"
        ) from None
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, in_columns, dtype = read(stream)
    if dtype.hasobject:
        raise LogError(
            f"{path.name}: {name!r} holds a pickle, which is never run; save plain arrays "
            "(np.asarray(x, float))"
        )
    if any(isinstance(size, bool) or size < 0 for size in shape):
        raise ValueError(f"the array {name!r} has the shape {shape}")
    return _Header(shape, in_columns, dtype)


def _size(header: _Header) -> int:
    return int(math.prod(header.shape)) * int(header.dtype.itemsize)


def _numbers(stream: IO[bytes], header: _Header, most: int) -> Raw:
    """The array itself, read in place without a copy."""
    size = _size(header)
    if size > most:
        raise ValueError("an array ends too early")
    array, memory = _memory(header)
    at = 0
    while at < size:
        block = stream.read(min(_BLOCK, size - at))
        if not block:
            raise ValueError("an array ends too early")
        memory[at : at + len(block)] = block
        at += len(block)
    return array


def _copied(
    path: Path, member: zipfile.ZipInfo, header: _Header, begins: int, blocks: Blocks
) -> Raw:
    """An array that the archive holds as it is, straight from the file, by its checksum."""
    array, memory = _memory(header)
    read_stored(path, member, begins, memory, blocks)
    return array


def _memory(header: _Header) -> tuple[Raw, memoryview]:
    """An array to be filled, and its bytes in their order in the file."""
    array = np.empty(header.shape[::-1] if header.in_columns else header.shape, header.dtype)
    bytes_of: Any = array.reshape(-1).view(np.uint8) if array.nbytes else b""
    return array.T if header.in_columns else array, memoryview(bytes_of)


def _damaged(path: Path, error: BaseException) -> LogError:
    if isinstance(error, LogError):
        return error
    reason = " ".join(str(error).split())[:160] or type(error).__name__
    return LogError(f"{path.name}: the NPZ file is damaged ({reason}); copy or save it again")
