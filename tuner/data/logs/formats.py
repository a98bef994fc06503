"""Which format a log has, told by its bytes and never by its name."""

from pathlib import Path

from tuner.data.logs.csv import open_csv
from tuner.data.logs.error import LogError
from tuner.data.logs.mat import open_mat5, open_mat73
from tuner.data.logs.npz import open_npz
from tuner.data.logs.table import Table

_HEAD = 64
_ZIP = (b"PK\x03\x04", b"PK\x05\x06")
_MAT5 = b"MATLAB 5.0 MAT-file"
_HDF5 = (b"MATLAB 7.3 MAT-file", b"\x89HDF\r\n\x1a\n")
_NPY = b"\x93NUMPY"
_PICKLE = (b"\x80\x02", b"\x80\x03", b"\x80\x04", b"\x80\x05")


def open_table(path: Path) -> Table:
    """Open a log of any known format.

    Raises:
        LogError: where there is no such file, or it is empty, damaged or of no known format.
    """
    head = _head(path)
    if head.startswith(_ZIP):
        return open_npz(path)
    if head.startswith(_MAT5):
        return open_mat5(path)
    if head.startswith(_HDF5):
        return open_mat73(path)
    if head.startswith(_NPY):
        raise LogError(f"{path.name}: this is one array without a name; save it with np.savez")
    if head.startswith(_PICKLE):
        raise LogError(
            f"{path.name}: this is a pickle, which is never run; save plain arrays with np.savez"
        )
    return open_csv(path)


def _head(path: Path) -> bytes:
    """The first bytes of the file."""
    try:
        if not path.exists():
            raise LogError(f"{path.name}: there is no such file; check the path")
        if not path.is_file():
            raise LogError(f"{path.name}: this is not a file; name the log inside it")
        with path.open("rb") as stream:
            head = stream.read(_HEAD)
    except OSError as error:
        raise LogError(
            f"{path.name}: the file cannot be opened ({error.strerror}); check path and permissions"
        ) from error
    if not head:
        raise LogError(f"{path.name}: the file is empty; record or export the log again")
    return head
