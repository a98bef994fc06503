"""Operations of JAX on constants: by NumPy where it gives the same, else compiled by JAX."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import jax
import numpy as np

from objectives.in_numpy.places import PLACES
from tuner.code.operations import BINARY
from tuner.code.refused import no_counterpart

Params: TypeAlias = Mapping[str, Any]
Move: TypeAlias = Callable[[np.ndarray, Params], np.ndarray]


def worked_out(
    equation: Any, given: Sequence[Any], params: Params | None = None
) -> list[np.ndarray]:
    """The results of an operation on numbers.

    Args:
        equation: the operation, as JAX traced it.
        given: its operands.
        params: its parameters, where they differ.
    """
    params = equation.params if params is None else params
    name = equation.primitive.name
    if name.startswith(("random_", "threefry")):
        raise no_counterpart(name)
    found = _in_numpy(name, given, params)
    if found is not None:
        return [np.asarray(found)]
    with jax.ensure_compile_time_eval():
        found = equation.primitive.bind(*given, **params)
    return [
        np.asarray(part) for part in (found if equation.primitive.multiple_results else [found])
    ]


def _in_numpy(name: str, given: Sequence[Any], params: Params) -> Any:
    """The result where NumPy equals JAX, else None."""
    kinds = {one.dtype.kind for one in given}
    if kinds == {"i"} and name in _WHOLE:
        with np.errstate(all="ignore"):
            return BINARY[name](*given)
    if kinds == {"b"} and name in _LOGIC:
        return _LOGIC[name](*given)
    if name in _SUMS and kinds == {_SUMS[name][1]}:
        return _SUMS[name][0].reduce(given[0], axis=tuple(params["axes"]), dtype=given[0].dtype)
    if name in MOVED:
        return MOVED[name](given[0], params)
    if name in PLACES:
        return PLACES[name](*given, **params)
    return _OTHERS[name](given, params) if name in _OTHERS else None


_WHOLE = frozenset({"add", "sub", "mul", "max", "min", "eq", "ne", "lt", "le", "gt", "ge"})
"""Of whole numbers; where one is divided by nothing JAX and NumPy differ."""
_LOGIC: Mapping[str, Callable[..., Any]] = {
    "and": np.logical_and,
    "or": np.logical_or,
    "xor": np.logical_xor,
    "not": np.logical_not,
}
_SUMS: Mapping[str, tuple[np.ufunc, str]] = {
    "reduce_sum": (np.add, "f"),
    "reduce_prod": (np.multiply, "f"),
    "reduce_max": (np.maximum, "f"),
    "reduce_min": (np.minimum, "f"),
    "reduce_and": (np.logical_and, "b"),
    "reduce_or": (np.logical_or, "b"),
}


def _broadcast(x: np.ndarray, params: Params) -> np.ndarray:
    axes = [1] * len(params["shape"])
    for axis, size in zip(params["broadcast_dimensions"], x.shape, strict=True):
        axes[axis] = size
    return np.broadcast_to(x.reshape(axes), params["shape"])


def _slice(x: np.ndarray, params: Params) -> np.ndarray:
    steps = params["strides"] or (1,) * x.ndim
    return x[tuple(map(slice, params["start_indices"], params["limit_indices"], steps))]


MOVED: Mapping[str, Move] = {
    "broadcast_in_dim": _broadcast,
    "slice": _slice,
    "reshape": lambda x, params: x.reshape(params["new_sizes"]),
    "squeeze": lambda x, params: np.squeeze(x, axis=params["dimensions"]),
    "expand_dims": lambda x, params: np.expand_dims(x, params["dimensions"]),
    "transpose": lambda x, params: x.transpose(params["permutation"]),
    "rev": lambda x, params: np.flip(x, params["dimensions"]),
    "copy": lambda x, _: x,
    "copy_p": lambda x, _: x,
    "stop_gradient": lambda x, _: x,
    "optimization_barrier": lambda x, _: x,
}
"""Moves of the entries of one array, whatever they are."""


def _counted(_: Sequence[np.ndarray], params: Params) -> np.ndarray:
    axis, shape = params["dimension"], params["shape"]
    line = np.arange(shape[axis], dtype=params["dtype"])
    return np.broadcast_to(line.reshape([-1 if k == axis else 1 for k in range(len(shape))]), shape)


def _converted(given: Sequence[np.ndarray], params: Params) -> np.ndarray | None:
    """A conversion, but not from real to whole numbers, where some are undefined."""
    dtype = np.dtype(params["new_dtype"])
    return None if given[0].dtype.kind == "f" and dtype.kind in "iu" else given[0].astype(dtype)


def _chosen(given: Sequence[np.ndarray], _: Params) -> np.ndarray | None:
    return np.where(given[0], *given[:0:-1]) if len(given) == 3 else None


def _power(given: Sequence[np.ndarray], params: Params) -> np.ndarray | None:
    square = given[0].dtype.kind == "f" and params["y"] == 2
    return given[0] * given[0] if square else None


def _padded(given: Sequence[np.ndarray], params: Params) -> np.ndarray | None:
    x, value = given
    sizes = [(low, high) for low, high, between in params["padding_config"] if between == 0]
    if len(sizes) < x.ndim or any(low < 0 or high < 0 for low, high in sizes):
        return None
    return np.pad(x, sizes, constant_values=value) if sizes else x


def _joined(given: Sequence[np.ndarray], params: Params) -> np.ndarray:
    return np.concatenate(given, axis=params["dimension"])


def _stacked(given: Sequence[np.ndarray], params: Params) -> np.ndarray:
    return np.stack(given, axis=params["axis"])


def _part(given: Sequence[np.ndarray], params: Params) -> np.ndarray:
    x, *starts = given
    sizes = params["slice_sizes"]
    first = [int(np.clip(s, 0, n - m)) for s, n, m in zip(starts, x.shape, sizes, strict=True)]
    return x[tuple(slice(at, at + size) for at, size in zip(first, sizes, strict=True))]


_OTHERS: Mapping[str, Callable[[Sequence[np.ndarray], Params], np.ndarray | None]] = {
    "iota": _counted,
    "convert_element_type": _converted,
    "select_n": _chosen,
    "integer_pow": _power,
    "pad": _padded,
    "concatenate": _joined,
    "stack": _stacked,
    "dynamic_slice": _part,
}
