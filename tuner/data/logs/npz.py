"""NPZ logs: numpy's archives of plain arrays, never pickles, each read by its header."""

import math
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw, Table
from tuner.data.logs.zipped import DAMAGE, MOST, check_index, check_sizes

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

    def load(names: Sequence[str]) -> dict[str, Raw]:
        chosen = {name: arrays[name] for name in names}
        check_sizes(path, list(chosen.values()), f"{', '.join(map(repr, names))[:60]}")
        return {name: _load(path, name, member) for name, member in chosen.items()}

    return Table(path.name, tuple(arrays), load, format="archive of numpy arrays")


def _load(path: Path, name: str, member: zipfile.ZipInfo) -> Raw:
    """One array of the archive."""
    try:
        with zipfile.ZipFile(path) as archive, archive.open(member) as stream:
            shape, in_columns, dtype = _header(path, name, stream)
            return _numbers(stream, shape, in_columns, dtype, member.file_size)
    except LogError:
        raise
    except Exception as error:  # numpy reads headers as Python, which can raise anything
        raise _damaged(path, error) from error


def _header(path: Path, name: str, stream: IO[bytes]) -> tuple[tuple[int, ...], bool, Any]:
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
    return shape, in_columns, dtype


def _numbers(
    stream: IO[bytes], shape: tuple[int, ...], in_columns: bool, dtype: Any, most: int
) -> Raw:
    """The array itself, read in place without a copy."""
    size = math.prod(shape) * dtype.itemsize
    if size > most:
        raise ValueError("an array ends too early")
    array = np.empty(shape[::-1] if in_columns else shape, dtype)
    bytes_of: Any = array.reshape(-1).view(np.uint8) if size else b""
    room = memoryview(bytes_of)
    at = 0
    while at < size:
        block = stream.read(min(_BLOCK, size - at))
        if not block:
            raise ValueError("an array ends too early")
        room[at : at + len(block)] = block
        at += len(block)
    return array.T if in_columns else array


def _damaged(path: Path, error: BaseException) -> LogError:
    if isinstance(error, LogError):
        return error
    reason = " ".join(str(error).split())[:160] or type(error).__name__
    return LogError(f"{path.name}: the NPZ file is damaged ({reason}); copy or save it again")
