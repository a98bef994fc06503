"""MAT files of version 7.3, and any HDF5 file that is laid out like one, by h5py."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tuner.data.logs.contents import Contents, Group
from tuner.data.logs.error import LogError
from tuner.data.logs.mat import not_read
from tuner.data.logs.table import Raw
from tuner.limits import check_amount, size_text, unpacked

_DEEPEST = 8
_MOST = 100_000


def contents(path: Path) -> Contents:
    """The arrays of a file by name: ``struct.field``, a slash of HDF5 as a dot.

    Raises:
        LogError: where it holds none.
    """
    import h5py

    with h5py.File(path, "r") as file:
        found = dict(_datasets(file, "", _DEEPEST))
        columns = {name: _width(part) for name, part in found.items() if not _is_object(part)}
        left = [not_read(name, _kind(part)) for name, part in found.items() if _is_object(part)]
    if not columns:
        why = f" but {left[0]}" if left else "; save the log's columns in it"
        raise LogError(f"the MAT file holds no arrays{why}")
    return Contents("MATLAB file of version 7.3", [Group("", columns)], left)


def load(path: Path, names: Sequence[str]) -> dict[str, Raw]:
    """Arrays as MATLAB shows them: it stores the axes in reverse; vectors are 1-D."""
    import h5py

    with h5py.File(path, "r") as file:
        found = dict(_datasets(file, "", _DEEPEST))
        size = sum(found[name].size * found[name].dtype.itemsize for name in names)
        if size > unpacked(path.stat().st_size):
            raise LogError(
                f"{names[0]!r} and others would unpack to {size_text(size)}, which no log does; "
                "save them without compression"
            )
        check_amount("what is mapped of it", size, "map less or cut it into parts")
        return {name: _read(found[name]) for name in names}


def _datasets(group: Any, prefix: str, deep: int) -> Iterator[tuple[str, Any]]:
    """The arrays in a group, by name."""
    import h5py

    for count, name in enumerate(group):
        if name.startswith("#"):  # where MATLAB keeps the contents of its cells and objects
            continue
        if count > _MOST:
            raise LogError(f"the MAT file holds more than {_MOST} arrays; save fewer")
        link = group.get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink):
            raise LogError(f"{name!r} is a link to another file; save the data in this one")
        if isinstance(link, h5py.SoftLink):
            continue  # it may lead in a circle
        part = group[name]
        if isinstance(part, h5py.Group) and deep:
            yield from _datasets(part, f"{prefix}{name}.", deep - 1)
        elif isinstance(part, h5py.Dataset) and _holds_numbers(part):
            yield prefix + name, part


def _holds_numbers(dataset: Any) -> bool:
    return _kind(dataset) not in ("char", "cell") and not dataset.dtype.hasobject


def _kind(dataset: Any) -> str:
    kind = dataset.attrs.get("MATLAB_class", b"")
    return kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)


def _is_object(dataset: Any) -> bool:
    return "MATLAB_object_decode" in dataset.attrs


def _width(dataset: Any) -> int:
    shape = [size for size in dataset.shape if size != 1]
    return int(shape[0]) if len(shape) == 2 else 0


def _read(dataset: Any) -> Raw:
    """One array; of an empty one the file holds only its size."""
    if dataset.attrs.get("MATLAB_empty", 0):
        return np.empty(0)
    if dataset.external or dataset.is_virtual:
        raise LogError(f"{dataset.name[1:]!r} is kept in another file; save it in this one")
    return np.squeeze(np.asarray(dataset[()]).T)
