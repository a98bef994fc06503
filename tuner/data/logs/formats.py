"""The format of a log, found by its bytes and never by its name."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from tuner.data.logs import betaflight
from tuner.data.logs.archive import is_archive, open_archive, open_folder
from tuner.data.logs.csv import open_csv
from tuner.data.logs.dataflash import open_dataflash
from tuner.data.logs.dataflash_text import open_dataflash_text
from tuner.data.logs.error import LogError
from tuner.data.logs.mat import open_mat5
from tuner.data.logs.npz import open_npz
from tuner.data.logs.reader_process import Reader, open_in_process
from tuner.data.logs.table import Table
from tuner.files import opened

_HEAD = 64

_ULOG = Reader("tuner.data.logs.ulog", "PX4 ULog", "pyulog", "ulog")
_ROSBAG = Reader(
    "tuner.data.logs.rosbag", "ROS bag", "rosbags", "ros",
    mend="copy it again, or mend it by rosbag reindex, ros2 bag reindex or mcap recover",
)  # fmt: skip
_ARROW = Reader("tuner.data.logs.arrow", "Parquet or Feather", "pyarrow", "arrow")
_MAT73 = Reader("tuner.data.logs.mat73", "MATLAB 7.3", "h5py", "mat73")


def open_table(path: Path) -> Table:
    """Open a log of any known format, or a folder of them.

    Raises:
        LogError: where there is no such file, or it is empty, damaged or of no known format.
    """
    head = _head(path)
    if head is None:
        bag = (path / "metadata.yaml").is_file()
        return open_in_process(path, _ROSBAG) if bag else open_folder(path)
    for beginnings, open_one in _FORMATS:
        if head.startswith(beginnings):
            return open_one(path)
    return open_csv(path)


def _open_zip(path: Path) -> Table:
    return open_archive(path) if is_archive(path) else open_npz(path)


def _refused(why: str, path: Path) -> Table:
    raise LogError(f"{path.name}: this is {why}")


_FORMATS: tuple[tuple[tuple[bytes, ...], Callable[[Path], Table]], ...] = (
    ((b"PK\x03\x04", b"PK\x05\x06"), _open_zip),
    ((b"MATLAB 5.0 MAT-file",), open_mat5),
    ((b"MATLAB 7.3 MAT-file", b"\x89HDF\r\n\x1a\n"), partial(open_in_process, reader=_MAT73)),
    ((b"ULog\x01\x12\x35",), partial(open_in_process, reader=_ULOG)),
    (
        (b"#ROSBAG V", b"\x89MCAP0\r\n", b"SQLite format 3\0"),
        partial(open_in_process, reader=_ROSBAG),
    ),
    ((b"PAR1", b"ARROW1", b"FEA1"), partial(open_in_process, reader=_ARROW)),
    ((b"\xa3\x95",), open_dataflash),
    ((b"FMT,", b"FMT ,"), open_dataflash_text),
    (betaflight.MAGICS, betaflight.open_betaflight),
    (
        (b"\x93NUMPY",),
        partial(_refused, "one array without a name; save it with np.savez"),
    ),
    (
        (b"\x80\x02", b"\x80\x03", b"\x80\x04", b"\x80\x05"),
        partial(_refused, "a pickle, which is never run; save plain arrays with np.savez"),
    ),
    (
        (b"\x28\xb5\x2f\xfd",),
        partial(_refused, "compressed by zstd; unpack it, or name the folder of its ROS bag"),
    ),
)


def _head(path: Path) -> bytes | None:
    """The first bytes of the file; None for a folder."""
    try:
        if path.is_dir():
            return None
        with opened(path) as stream:
            head = stream.read(_HEAD)
    except FileNotFoundError as error:
        raise LogError(f"{path.name}: there is no such file; check the path") from error
    except OSError as error:
        raise LogError(
            f"{path.name}: the file cannot be opened ({error.strerror}); check path and permissions"
        ) from error
    except ValueError as error:
        raise LogError(str(error)) from None
    if not head:
        raise LogError(f"{path.name}: the file is empty; record or export the log again")
    return head
