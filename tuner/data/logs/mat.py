"""MATLAB logs: MAT files of version 5 (by scipy) and of version 7.3 (HDF5, by h5py)."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw, Table


def open_mat5(path: Path) -> Table:
    """Open a MAT file of version 5; the fields of a struct are columns ``struct.field``.

    Row and column vectors come as 1-D arrays.

    Raises:
        LogError: where the file is damaged or holds no arrays.
    """
    from scipy.io import loadmat

    with _damage_told(path):
        arrays = dict(_flat(loadmat(path, simplify_cells=True)))
    _check_any(path, arrays)
    return Table(path.name, tuple(arrays), lambda names: {name: arrays[name] for name in names})


def open_mat73(path: Path) -> Table:
    """Open a MAT file of version 7.3, or any HDF5 file that is laid out like one.

    MATLAB stores the axes in reverse, so arrays are transposed; vectors come as 1-D arrays.

    Raises:
        LogError: where h5py is missing, or the file is damaged or holds no arrays.
    """
    try:
        import h5py
    except ImportError as error:
        raise LogError(
            f"{path.name}: MAT files of version 7.3 need h5py; pip install 'filter-tuner[mat73]'"
        ) from error
    with _damage_told(path), h5py.File(path, "r") as file:
        paths = dict(_datasets(file, h5py))
    _check_any(path, paths)

    def load(wanted: Sequence[str]) -> dict[str, Raw]:
        with _damage_told(path), h5py.File(path, "r") as file:
            return {name: _read(file[paths[name]]) for name in wanted}

    return Table(path.name, tuple(paths), load)


@contextmanager
def _damage_told(path: Path) -> Iterator[None]:
    """Turn what a damaged file raises into a sentence."""
    try:
        yield
    except Exception as error:  # both libraries raise nearly anything on a damaged file
        reason = " ".join(str(error).split()) or type(error).__name__
        raise LogError(
            f"{path.name}: the MAT file is damaged ({reason}); copy or save it again"
        ) from error


def _check_any(path: Path, names: object) -> None:
    if not names:
        raise LogError(f"{path.name}: the MAT file holds no arrays; save the log's columns in it")


def _flat(variables: dict[str, Any]) -> Iterator[tuple[str, Raw]]:
    """The arrays of a version 5 file, those in structs with their struct's name before them."""
    for name, value in variables.items():
        if name.startswith("__"):
            continue
        fields = value if isinstance(value, dict) else {"": value}
        for field, part in fields.items():
            if isinstance(part, (np.ndarray, np.generic, int, float, complex, str)):
                yield f"{name}.{field}".rstrip("."), np.asarray(part)


def _datasets(file: Any, h5py: ModuleType) -> Iterator[tuple[str, str]]:
    """The arrays of a version 7.3 file by name and path."""
    for name, item in file.items():
        if name.startswith("#"):  # where MATLAB keeps the contents of its cells
            continue
        fields = item.items() if isinstance(item, h5py.Group) else [("", item)]
        for field, part in fields:
            if isinstance(part, h5py.Dataset) and not _is_text(part):
                yield f"{name}.{field}".rstrip("."), part.name


def _is_text(dataset: Any) -> bool:
    return dataset.attrs.get("MATLAB_class") in (b"char", b"cell", "char", "cell")


def _read(dataset: Any) -> Raw:
    """One array as MATLAB shows it; of an empty one the file holds only its size."""
    if dataset.attrs.get("MATLAB_empty", 0):
        return np.empty(0)
    return np.squeeze(np.asarray(dataset[()]).T)
