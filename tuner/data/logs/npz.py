"""NPZ logs: numpy's archives of plain arrays, never pickles."""

import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw, Table

_MAX_BYTES = 1 << 32
_DAMAGE = (
    OSError, EOFError, ValueError, KeyError, SyntaxError, MemoryError, NotImplementedError,
    RuntimeError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


def open_npz(path: Path) -> Table:
    """Open an NPZ file; its arrays are the columns, its 0-d arrays the scalars.

    Raises:
        LogError: where the archive is damaged or holds no arrays; loading raises it for
            pickles and for arrays that would unpack to more than 4 GiB.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
    except _DAMAGE as error:
        raise _damaged(path, error) from error
    sizes = {
        member.filename.removesuffix(".npy"): member.file_size
        for member in members
        if member.filename.endswith(".npy")
    }
    if not sizes:
        raise LogError(
            f"{path.name}: the archive holds no numpy arrays; unpack it, or save them with np.savez"
        )

    def load(names: Sequence[str]) -> dict[str, Raw]:
        return {name: _load(path, name, sizes[name]) for name in names}

    return Table(path.name, tuple(sizes), load, format="archive of numpy arrays")


def _load(path: Path, name: str, size: int) -> Raw:
    """One array of the archive."""
    if size > _MAX_BYTES:
        raise LogError(
            f"{path.name}: {name!r} would unpack to {size / 2**30:.1f} GiB; "
            "cut the log into parts below 4 GiB"
        )
    try:
        with np.load(path, allow_pickle=False) as archive:
            array = archive[name]
    except _DAMAGE as error:
        if "allow_pickle" in str(error):
            raise LogError(
                f"{path.name}: {name!r} holds a pickle, which is never run; "
                "save plain arrays (np.asarray(x, float))"
            ) from error
        raise _damaged(path, error) from error
    if not isinstance(array, np.ndarray):
        raise LogError(f"{path.name}: {name!r} is no numpy array; save the log with np.savez")
    return array


def _damaged(path: Path, error: BaseException) -> LogError:
    reason = " ".join(str(error).split()) or type(error).__name__
    return LogError(f"{path.name}: the NPZ file is damaged ({reason}); copy or save it again")
