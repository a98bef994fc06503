"""Reading and writing at places that are computed: gather and scatter."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from objectives.in_numpy.arrays import within


def _gather(
    x: np.ndarray,
    indices: np.ndarray,
    *,
    dimension_numbers: Any,
    slice_sizes: Sequence[int],
    mode: Any,
    fill_value: Any,
    **_: Any,
) -> Any:
    d = dimension_numbers
    gone = (*d.collapsed_slice_dims, *d.operand_batching_dims)
    window = [size for axis, size in enumerate(slice_sizes) if axis not in gone]
    found = np.empty((*indices.shape[:-1], *window), x.dtype)
    aligned = d.operand_batching_dims, d.start_indices_batching_dims
    for at, start in _starts(indices, d.start_index_map, aligned, x.ndim):
        if _drops(mode) and not _inside(start, slice_sizes, x.shape):
            found[at] = _filling(x.dtype) if fill_value is None else fill_value
        else:
            found[at] = x[within(start, slice_sizes, x.shape)].reshape(window)
    batch = indices.ndim - 1
    return np.moveaxis(found, range(batch, found.ndim), d.offset_dims)


def _scattered(write: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    def scatter(
        x: np.ndarray,
        indices: np.ndarray,
        updates: np.ndarray,
        *,
        dimension_numbers: Any,
        mode: Any,
        **_: Any,
    ) -> Any:
        d, batch = dimension_numbers, indices.ndim - 1
        gone = (*d.inserted_window_dims, *d.operand_batching_dims)
        parts = np.moveaxis(updates, d.update_window_dims, range(batch, updates.ndim))
        window = iter(parts.shape[batch:])
        sizes = [1 if axis in gone else next(window) for axis in range(x.ndim)]
        whole = np.array(x)
        aligned = d.operand_batching_dims, d.scatter_indices_batching_dims
        for at, start in _starts(indices, d.scatter_dims_to_operand_dims, aligned, x.ndim):
            if not _drops(mode) or _inside(start, sizes, x.shape):
                where = within(start, sizes, x.shape)
                whole[where] = write(whole[where], parts[at].reshape(sizes))
        return whole

    return scatter


def _starts(
    indices: np.ndarray, onto: Sequence[int], aligned: tuple[Any, Any], ndim: int
) -> Iterator[tuple[tuple[int, ...], list[int]]]:
    """Each place among the indices, and where it points to."""
    for at in np.ndindex(indices.shape[:-1]):
        start = [0] * ndim
        for axis, value in zip(onto, indices[at], strict=True):
            start[axis] = int(value)
        for axis, own in zip(*aligned, strict=True):
            start[axis] = at[own]
        yield at, start


def _drops(mode: Any) -> bool:
    return getattr(mode, "name", "") == "FILL_OR_DROP"


def _inside(start: Sequence[int], sizes: Sequence[int], shape: Sequence[int]) -> bool:
    return all(0 <= s <= n - size for s, size, n in zip(start, sizes, shape, strict=True))


def _filling(dtype: np.dtype[Any]) -> Any:
    """What XLA puts where nothing is read."""
    if dtype.kind in "fc":
        return np.nan
    if dtype.kind == "b":
        return True
    return np.iinfo(dtype).min if dtype.kind == "i" else np.iinfo(dtype).max


PLACES: dict[str, Callable[..., Any]] = {
    "gather": _gather,
    "scatter": _scattered(lambda old, new: new),
    "scatter-add": _scattered(np.add),
    "scatter_add": _scattered(np.add),
    "scatter-mul": _scattered(np.multiply),
    "scatter_mul": _scattered(np.multiply),
}
