"""The time loop as a gradient that goes backwards wants it."""

import math
from typing import Any

import jax
from jax import Array

from filters.invariant import invariant
from filters.protocol import AnyFilter, over_time
from filters.small_linalg import unfolded
from filters.way_back import STEPS

KEPT = 4
"""About how many times a state's size a step keeps for the way back."""
LEAST = 4
"""A record of fewer samples is not parted."""
MOST_KEPT = 256 << 20
"""Bytes that a whole record may keep; above it, the steps of a part are done again."""


def run_kept(
    filter: AnyFilter, params: Any, inputs: Any, *, parts: bool = False, most: int = MOST_KEPT
) -> tuple[Any, Any]:
    """:func:`filters.run`, to be differentiated backwards: by ``jax.vjp`` or ``jax.grad``.

    What follows from the parameters alone is done once. In parts sqrt(N) states are kept, and on
    the way back each part is run again, so that all it keeps lies in the processor's cache.

    Args:
        filter: any filter.
        params: its parameters.
        inputs: its inputs, with time first, ``(N, ...)``.
        parts: whether in parts; it is done so in any case where N samples would keep more than
            ``most`` bytes.
        most: see there.

    >>> import jax.numpy as jnp
    >>> from filters import AngleSample, Complementary, ComplementaryGain
    >>> gain = ComplementaryGain(jnp.array(1.0), jnp.array(0.0))
    >>> still = AngleSample(jnp.zeros(9), jnp.ones(9))
    >>> def last(gain, parts):
    ...     return run_kept(Complementary(dt=0.1), gain, still, parts=parts)[1][-1]
    >>> slopes = [jax.grad(last)(gain, parts).tau for parts in (False, True)]
    >>> bool(abs(slopes[1] - slopes[0]) < 1e-12 * abs(slopes[0]))
    True
    """
    params = unfolded(params, inputs)
    start = filter.init(params)
    length = len(jax.tree.leaves(inputs)[0])
    sample = jax.eval_shape(lambda all: jax.tree.map(lambda leaf: leaf[0], all), inputs)
    step = invariant(filter.step, params, start, sample, STEPS)
    each = KEPT * sum(leaf.size * leaf.dtype.itemsize for leaf in jax.tree.leaves(start))
    if length < LEAST or (length * each <= most and not parts):
        return over_time(step, start, inputs)
    return _in_parts(step, start, inputs, length)


def _in_parts(step: Any, start: Any, inputs: Any, length: int) -> tuple[Any, Any]:
    """Parts of about sqrt(N) samples, and what is left over."""
    part = math.isqrt(length)
    whole = length // part * part

    def folded(leaf: Array) -> Array:
        return leaf[:whole].reshape(-1, part, *leaf.shape[1:])

    def flat(leaf: Array) -> Array:
        return leaf.reshape(whole, *leaf.shape[2:])

    again = jax.checkpoint(lambda state, part: over_time(step, state, part))
    state, outputs = over_time(again, start, jax.tree.map(folded, inputs))
    outputs = jax.tree.map(flat, outputs)
    if whole == length:
        return state, outputs
    state, rest = over_time(step, state, jax.tree.map(lambda leaf: leaf[whole:], inputs))
    return state, jax.tree.map(lambda a, b: jax.numpy.concatenate([a, b]), outputs, rest)
