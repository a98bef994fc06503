"""Test data of a filter for its target: a few samples, and JAX's results."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from filters import run
from objectives.in_numpy import in_numpy
from tuner.code.trace import in_precision

SAMPLES = 50
_SHARE = {"double": 1e-9, "float": 4e-6}
"""Tolerance of a number relative to its size, however the filter amplifies rounding errors."""
_ROUNDING = {"double": 1e-12, "float": 1e-6}
"""Values this far below the largest number of the state are due to rounding."""


_FAST_COMPILATION = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}
"""Compiler options for a few samples, whose run takes less time than compilation."""


@dataclass(frozen=True, eq=False)
class Tried:
    """Samples and expected results, flat; whole numbers and truth values as real ones.

    Attributes:
        samples: the inputs, ``(N, inputs)``.
        expected: the outputs, a field each, ``(N, ...)``.
        allowed: tolerance of the outputs in each sample, a field each, ``(N, ...)``.
        after: the state after the last sample, a field each.
        allowed_after: its tolerance.
    """

    samples: list[np.ndarray]
    expected: list[np.ndarray]
    allowed: list[np.ndarray]
    after: list[np.ndarray]
    allowed_after: list[np.ndarray]


def tried(filter: Any, params: Any, inputs: Any, kept: Sequence[bool], precision: str) -> Tried:
    """Run a filter over some of its samples, in the target's precision.

    The first samples and some of all the others, with holes where the filter takes them.

    Args:
        filter: the filter.
        params: its parameters.
        inputs: its inputs, time first.
        kept: which of its outputs, flat, are included.
        precision: double or float.
    """
    samples = _with_holes(filter, params, _selected_samples(inputs))
    dtype = np.float32 if precision == "float" else np.float64
    state, outputs = _ran(filter, params, samples, dtype)
    others = [_ran(filter, params, near, dtype) for near in _beside(samples, dtype)]
    others.append(_ran(filter, params, samples, np.float64))
    start = [np.asarray(leaf) for leaf in jax.tree.leaves(in_numpy(filter.init, params))]
    rest = _ROUNDING[precision] * max(map(_size, (*start, *state)), default=0.0)
    wanted = [k for k, put_out in enumerate(kept) if put_out]
    share = _SHARE[precision]
    return Tried(
        [np.asarray(leaf) for leaf in jax.tree.leaves(in_precision(samples, dtype))],
        [outputs[k] for k in wanted],
        [_allowed(outputs[k], [other[1][k] for other in others], share) for k in wanted],
        state,
        [
            _allowed(one[None], [other[0][k][None] for other in others], share)[0] + rest
            for k, one in enumerate(state)
        ],
    )


def _beside(samples: Any, dtype: type[np.floating]) -> Iterator[Any]:
    """The same samples with other rounding errors, whose effect another machine may show."""
    draw = np.random.default_rng(0)

    def near(leaf: np.ndarray) -> np.ndarray:
        if leaf.dtype.kind != "f":
            return leaf
        errors = 4 * np.finfo(dtype).eps * draw.uniform(-1, 1, leaf.shape)
        return np.asarray(leaf * (1 + errors))

    for _ in range(3):
        yield jax.tree.map(near, samples)


def _selected_samples(inputs: Any) -> Any:
    """The first half consecutive, the others spread over the rest."""
    count = len(jax.tree.leaves(inputs)[0])
    near = np.arange(min(count, SAMPLES // 2))
    far = np.linspace(len(near), count - 1, min(SAMPLES, count) - len(near)).astype(int)
    which = np.concatenate([near, far])
    return jax.tree.map(lambda leaf: np.asarray(leaf)[which], inputs)


def _with_holes(filter: Any, params: Any, samples: Any) -> Any:
    """The samples with gaps in every channel that may be missing."""
    leaves, tree = jax.tree.flatten(samples)
    whole: Any = tree
    for k, leaf in enumerate(leaves):
        if leaf.dtype.kind != "f" or np.isnan(leaf).any() or len(leaf) < SAMPLES:
            continue
        holed = leaf.copy()
        holed[4 + k % 5 :: 13] = np.nan
        other = whole.unflatten([*leaves[:k], holed, *leaves[k + 1 :]])
        if all(np.isfinite(part).all() for part in _ran(filter, params, other, np.float64)[0]):
            leaves[k] = holed
    return whole.unflatten(leaves)


def _ran(
    filter: Any, params: Any, samples: Any, dtype: type[np.floating]
) -> list[list[np.ndarray]]:
    """State and outputs, flat, as real numbers."""
    found = _run(filter, in_precision(params, dtype), in_precision(samples, dtype))
    return [[np.asarray(x, dtype) for x in jax.tree.leaves(part)] for part in found]


@jax.jit(static_argnums=0, compiler_options=_FAST_COMPILATION)
def _run(filter: Any, params: Any, samples: Any) -> Any:
    return run(filter, params, samples)


def _allowed(found: np.ndarray, others: Sequence[np.ndarray], share: float) -> np.ndarray:
    """Tolerance for another machine: the accumulated effect of rounding so far.

    A filter may forget where it was told exactly (a direction that is normalised has none at rest);
    its first samples still show a wrong constant.
    """
    with np.errstate(invalid="ignore"):
        apart = [np.abs(other.astype(float) - found) for other in others]
    strays = np.max([np.where(np.isfinite(one), one, 0) for one in apart], axis=0)
    size = np.where(np.isfinite(found), np.abs(found), 0).max(axis=0).astype(float)
    return np.asarray(4 * np.maximum.accumulate(strays, axis=0) + share * size)


def _size(array: np.ndarray) -> float:
    return float(np.abs(array[np.isfinite(array)]).max(initial=0.0))
