"""Test data of a filter for its target: samples, single steps, and JAX's results."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import numpy as np

from tuner.code.literal import Precision
from tuner.code.program import Program
from tuner.code.reference_filter import SAMPLES, ReferenceFilter
from tuner.code.states import Arrays
from tuner.code.steps import Steps, drawn_steps, searched_steps
from tuner.code.trace import in_precision

_SHARE = {"double": 1e-9, "float": 4e-6}
"""Tolerance of a number relative to its size, however the filter amplifies rounding errors."""
_ROUNDING = {"double": 1e-12, "float": 1e-6}
"""Values this far below the largest number of the state are due to rounding."""


@dataclass(frozen=True, eq=False)
class Reference:
    """Samples and expected results, flat; whole numbers and truth values as real ones.

    Attributes:
        samples: the inputs, ``(N, inputs)``.
        expected: the outputs, a field each, ``(N, ...)``.
        allowed: tolerance of the outputs in each sample, a field each, ``(N, ...)``.
        start, after: the state before the first sample and after the last, a field each.
        allowed_start, allowed_after: their tolerances.
        steps: single steps that show what the samples do not; None where no state gives numbers.
    """

    samples: Arrays
    expected: Arrays
    allowed: Arrays
    start: Arrays
    allowed_start: Arrays
    after: Arrays
    allowed_after: Arrays
    steps: Steps | None = None


def reference(
    filter: Any,
    params: Any,
    inputs: Any,
    kept: Sequence[bool],
    precision: Precision,
    program: Program | None = None,
    before: Reference | None = None,
) -> Reference:
    """Run a filter over some of its samples, in the target's precision.

    The first samples and some of all the others, with holes where the filter takes them; then
    single steps from states in which a wrong constant shows.

    Args:
        filter: the filter.
        params: its parameters.
        inputs: its inputs, time first.
        kept: which of its outputs, flat, are included.
        precision: double or float.
        program: its formulas; None: single steps are not searched for.
        before: the same in another precision, whose single steps are looked at first.
    """
    own = ReferenceFilter(filter, params, np.float32 if precision == "float" else np.float64)
    samples = _with_holes(own, selected_samples(inputs))
    states, outputs = own.run(samples)
    others = [own.run(near) for near in _beside(samples, own.dtype)]
    others.append(replace(own, dtype=np.float64).run(samples))
    rest = _ROUNDING[precision] * max(map(_size, (*own.start, *(x[-1] for x in states))), default=0)
    wanted = [k for k, put_out in enumerate(kept) if put_out]
    share = _SHARE[precision]
    double = replace(own, dtype=np.float64).start
    found = Reference(
        [np.asarray(leaf) for leaf in jax.tree.leaves(in_precision(samples, own.dtype))],
        [outputs[k] for k in wanted],
        [_allowed(outputs[k], [other[1][k] for other in others], share) for k in wanted],
        own.start,
        [_allowed(a[None], [b[None]], share)[0] for a, b in zip(own.start, double, strict=True)],
        [one[-1] for one in states],
        [
            _allowed(one[-1:], [other[0][k][-1:] for other in others], share)[0] + rest
            for k, one in enumerate(states)
        ],
    )
    met = own.met(states)
    if program is None:
        return replace(found, steps=drawn_steps(own, met, samples, wanted, share))
    known = before.steps.before() if before and before.steps else None
    return replace(found, steps=searched_steps(own, program, met, samples, wanted, known))


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


def selected_samples(inputs: Any) -> Any:
    """Samples of a recording: the first half consecutive, the others spread over the rest."""
    count = len(jax.tree.leaves(inputs)[0])
    near = np.arange(min(count, SAMPLES // 2))
    far = np.linspace(len(near), count - 1, min(SAMPLES, count) - len(near)).astype(int)
    which = np.concatenate([near, far])
    return jax.tree.map(lambda leaf: np.asarray(leaf)[which], inputs)


def _with_holes(own: ReferenceFilter, samples: Any) -> Any:
    """The samples with gaps in every channel that may be missing."""
    leaves, tree = jax.tree.flatten(samples)
    whole: Any = tree
    double = replace(own, dtype=np.float64)
    for k, leaf in enumerate(leaves):
        if leaf.dtype.kind != "f" or np.isnan(leaf).any() or len(leaf) < SAMPLES:
            continue
        holed = leaf.copy()
        holed[4 + k % 5 :: 13] = np.nan
        other = jax.tree.unflatten(whole, [*leaves[:k], holed, *leaves[k + 1 :]])
        if all(np.isfinite(part[-1]).all() for part in double.run(other)[0]):
            leaves[k] = holed
    return jax.tree.unflatten(whole, leaves)


def _allowed(found: np.ndarray, others: Sequence[np.ndarray], share: float) -> np.ndarray:
    """Tolerance for another machine: the accumulated effect of rounding so far.

    A filter may forget its exact start (a direction that is normalised has none at rest); its
    first samples still show a wrong constant.
    """
    with np.errstate(invalid="ignore"):
        apart = [np.abs(other.astype(float) - found) for other in others]
    strays = np.max([np.where(np.isfinite(one), one, 0) for one in apart], axis=0)
    size = np.where(np.isfinite(found), np.abs(found), 0).max(axis=0).astype(float)
    return np.asarray(4 * np.maximum.accumulate(strays, axis=0) + share * size)


def _size(array: np.ndarray) -> float:
    return float(np.abs(array[np.isfinite(array)]).max(initial=0.0))
