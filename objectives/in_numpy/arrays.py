"""Operations on arrays as a whole: their shapes, sums, products and places."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np


def _broadcast(x: np.ndarray, *, shape: Any, broadcast_dimensions: Any, **_: Any) -> Any:
    spread = [1] * len(shape)
    for own, axis in enumerate(broadcast_dimensions):
        spread[axis] = x.shape[own]
    placed = x.reshape(spread)
    return placed if placed.shape == tuple(shape) else np.broadcast_to(placed, shape)


def _iota(*, dtype: Any, shape: Sequence[int], dimension: int, **_: Any) -> Any:
    along = [1] * len(shape)
    along[dimension] = shape[dimension]
    return np.broadcast_to(np.arange(shape[dimension], dtype=dtype).reshape(along), shape)


def _slice(x: np.ndarray, *, start_indices: Any, limit_indices: Any, strides: Any) -> Any:
    steps = strides or [1] * x.ndim
    return x[tuple(map(slice, start_indices, limit_indices, steps))]


def within(starts: Sequence[Any], sizes: Sequence[int], shape: Sequence[int]) -> tuple[slice, ...]:
    """The places of a part that XLA keeps inside the whole."""
    begins = [
        min(max(int(s), 0), n - size) for s, size, n in zip(starts, sizes, shape, strict=True)
    ]
    return tuple(slice(b, b + size) for b, size in zip(begins, sizes, strict=True))


def _dynamic_slice(x: np.ndarray, *starts: Any, slice_sizes: Any) -> Any:
    return x[within(starts, slice_sizes, x.shape)]


def _dynamic_update(x: np.ndarray, part: np.ndarray, *starts: Any) -> Any:
    whole = np.array(x)
    whole[within(starts, part.shape, x.shape)] = part
    return whole


def _pad(x: np.ndarray, value: np.ndarray, *, padding_config: Any) -> Any:
    before = [max(low, 0) for low, _, _ in padding_config]
    spaced = [
        (n - 1) * (gap + 1) + 1 if n else 0
        for n, (*_, gap) in zip(x.shape, padding_config, strict=True)
    ]
    ends = [b + n for b, n in zip(before, spaced, strict=True)]
    shape = [n + max(high, 0) for n, (_, high, _) in zip(ends, padding_config, strict=True)]
    whole = np.full(shape, value, x.dtype)
    steps = [gap + 1 for *_, gap in padding_config]
    whole[tuple(map(slice, before, ends, steps))] = x
    cuts = [
        slice(max(-low, 0), n - max(-high, 0))
        for n, (low, high, _) in zip(shape, padding_config, strict=True)
    ]
    return whole[tuple(cuts)]


def _dot(a: np.ndarray, b: np.ndarray, *, dimension_numbers: Any, **_: Any) -> Any:
    (own, other), (batch, beside) = dimension_numbers
    names = iter(range(a.ndim + b.ndim))
    first: list[int] = [next(names) for _ in range(a.ndim)]
    second: list[int] = [-1] * b.ndim
    for mine, yours in (*zip(own, other, strict=True), *zip(batch, beside, strict=True)):
        second[yours] = first[mine]
    second = [next(names) if name < 0 else name for name in second]
    left = [first[k] for k in range(a.ndim) if k not in (*own, *batch)]
    right = [second[k] for k in range(b.ndim) if k not in (*other, *beside)]
    return np.einsum(a, first, b, second, [*(first[k] for k in batch), *left, *right])


def _reduced(function: Callable[..., Any]) -> Callable[..., Any]:
    return lambda x, *, axes, **_: function(x, axis=tuple(axes))


def _place(function: Callable[..., Any], x: np.ndarray, *, axes: Any, **_: Any) -> Any:
    return function(x, axis=axes[0])


def _running(
    function: Callable[..., Any], x: np.ndarray, *, axis: int, reverse: bool = False, **_: Any
) -> Any:
    turned = np.flip(x, axis) if reverse else x
    found = function(turned, axis=axis)
    return np.flip(found, axis) if reverse else found


def _split(x: np.ndarray, *, sizes: Any, axis: int) -> Any:
    return np.split(x, np.cumsum(sizes)[:-1], axis)


def _sort(*given: np.ndarray, dimension: int, num_keys: int, **_: Any) -> Any:
    order = np.lexsort(given[:num_keys][::-1], axis=dimension)
    return [np.take_along_axis(x, order, dimension) for x in given]


ARRAYS: dict[str, Callable[..., Any]] = {
    "broadcast_in_dim": _broadcast,
    "iota": _iota,
    "slice": _slice,
    "dynamic_slice": _dynamic_slice,
    "dynamic_update_slice": _dynamic_update,
    "pad": _pad,
    "reshape": lambda x, *, new_sizes, **_: x.reshape(new_sizes),
    "squeeze": lambda x, *, dimensions: np.squeeze(x, tuple(dimensions)),
    "expand_dims": lambda x, *, dimensions: np.expand_dims(x, tuple(dimensions)),
    "transpose": lambda x, *, permutation: np.transpose(x, permutation),
    "rev": lambda x, *, dimensions: np.flip(x, tuple(dimensions)),
    "concatenate": lambda *parts, dimension: np.concatenate(parts, dimension),
    "stack": lambda *parts, **how: np.stack(parts, how.get("axis", how.get("dimension", 0))),
    "unstack": lambda x, *, axis: list(np.moveaxis(x, axis, 0)),
    "empty2": lambda *, dtype, **_: np.zeros((), dtype),  # whose contents nothing depends on
    "split": _split,
    "dot_general": _dot,
    "reduce_sum": _reduced(np.sum),
    "reduce_prod": _reduced(np.prod),
    "reduce_max": _reduced(np.max),
    "reduce_min": _reduced(np.min),
    "reduce_and": _reduced(np.all),
    "reduce_or": _reduced(np.any),
    "argmax": partial(_place, np.argmax),
    "argmin": partial(_place, np.argmin),
    "cumsum": partial(_running, np.cumsum),
    "cumprod": partial(_running, np.cumprod),
    "cummax": partial(_running, np.maximum.accumulate),
    "cummin": partial(_running, np.minimum.accumulate),
    "sort": _sort,
}
