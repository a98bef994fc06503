"""A filter whose gains have settled: a few products take it over many samples at once."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters.protocol import AnyFilter, over_time
from filters.small_linalg import contracted, matmul
from filters.without_missing import (
    AFFINE,
    KNOWN,
    NONLINEAR,
    Step,
    dependence,
    needed,
    without_missing,
)

Wanted: TypeAlias = Callable[[Any], Any]
"""A function of a sample's outputs."""


class Parts(NamedTuple):
    """The two parts of a linear filter: what follows the samples, and what does not.

    Attributes:
        step: of the filter, for samples in which nothing is missing.
        moved: which leaves of the state follow the samples, by formulas that are linear in them;
            the others, covariances above all, follow from themselves.
        outputs: of each leaf of the outputs ``KNOWN`` or ``AFFINE``; ``NONLINEAR`` where it is not
            wanted.
        state: the shapes of a state.
        sample: of a sample's inputs.
        output: of its outputs.
    """

    step: Step
    moved: tuple[bool, ...]
    outputs: tuple[int, ...]
    state: Any
    sample: Any
    output: Any

    def split(self, state: Any) -> tuple[list[Any], list[Any]]:
        """The leaves of a state that follow the samples, and those that do not."""
        leaves = list(zip(jax.tree.leaves(state), self.moved, strict=True))
        return [leaf for leaf, own in leaves if own], [leaf for leaf, own in leaves if not own]

    def joined(self, x: Array, still: list[Any]) -> Any:
        """The state, of the numbers ``(n,)`` that follow the samples and the other leaves."""
        moving, rest = iter(_cut(x, self.split(self.state)[0])), iter(still)
        leaves = [next(moving) if own else next(rest) for own in self.moved]
        return jax.tree.unflatten(jax.tree.structure(self.state), leaves)

    def stacked(self, outputs: Array, fixed: list[Any]) -> tuple[Any, Any]:
        """The outputs, of the numbers ``(N, m)`` that follow the samples and the fixed leaves.

        Returns:
            Both in the form of one sample's: the outputs, and the axis of time or None.
        """
        shapes, tree = jax.tree.flatten(self.output)
        kinds = list(zip(shapes, self.outputs, strict=True))
        moving, rest = iter(_cut(outputs, [s for s, k in kinds if k == AFFINE])), iter(fixed)
        own = {AFFINE: lambda _: next(moving), KNOWN: lambda _: next(rest)}
        leaves = [own.get(kind, lambda s: jnp.zeros(s.shape, s.dtype))(s) for s, kind in kinds]
        axes = [0 if kind == AFFINE else None for kind in self.outputs]
        return jax.tree.unflatten(tree, leaves), jax.tree.unflatten(tree, axes)


def parts_of(filter: AnyFilter, params: Any, sample: Any, wanted: Wanted) -> Parts | None:
    """The two parts of a filter; None where it is not linear, or nothing of it runs by itself.

    Args:
        filter: the filter.
        params: its parameters, or their shapes.
        sample: one sample's inputs, or their shapes.
        wanted: a function of the outputs; what it does not read is left out.

    >>> from filters import LevelSample, LocalLevel, LocalLevelNoise
    >>> level, noise = LocalLevel(dt=1.0), LocalLevelNoise(1.0, 1.0)
    >>> found = parts_of(level, noise, LevelSample(jnp.ones(())), lambda out: out.innovation)
    >>> found.moved  # level; variance, whether it is known
    (True, False, False)
    """
    state = jax.eval_shape(filter.init, params)
    step = without_missing(filter.step, params, state, sample)
    closed, (after, output) = jax.make_jaxpr(step, return_shape=True)(params, state, sample)
    numbers = [_number(leaf) for leaf in jax.tree.leaves(sample)]
    begin = [KNOWN] * len(jax.tree.leaves(params))
    moved = [KNOWN] * len(jax.tree.leaves(after))
    while True:
        kinds = dependence(closed, [*begin, *moved, *numbers])
        more = [AFFINE if own or new else KNOWN for own, new in zip(moved, kinds, strict=False)]
        if more == moved:
            break
        moved = more
    used = needed(jax.make_jaxpr(wanted)(output))
    leaves = list(zip(used, kinds[len(moved) :], strict=True))
    if len(set(moved)) < 2 or NONLINEAR in kinds[: len(moved)] or (True, NONLINEAR) in leaves:
        return None
    outputs = tuple(kind if own else NONLINEAR for own, kind in leaves)
    return Parts(step, tuple(map(bool, moved)), outputs, state, sample, output)


class Settled(NamedTuple):
    """A linear filter of constant gains: x' = A x + B u + a and y = C x + D u + c.

    Attributes:
        A: ``(n, n)``.
        B: ``(n, p)`` for the p numbers of a sample.
        C: ``(m, n)`` for m numbers of its outputs.
        D: ``(m, p)``.
        a: ``(n,)``.
        c: ``(m,)``.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    a: Array
    c: Array


def settled(parts: Parts, params: Any, still: list[Any]) -> tuple[Settled, list[Any]]:
    """The filter once the leaves ``still`` of its state are constant, and its fixed outputs."""
    shapes = jax.tree.leaves(parts.sample)
    n, p = (_size(leaves) for leaves in (parts.split(parts.state)[0], shapes))
    tree = jax.tree.structure(parts.sample)

    def once(both: Array) -> tuple[Array, list[Any]]:
        sample = jax.tree.unflatten(tree, _cut(both[n:], shapes))
        after, output = parts.step(params, parts.joined(both[:n], still), sample)
        leaves = list(zip(jax.tree.leaves(output), parts.outputs, strict=True))
        follows = parts.split(after)[0] + [leaf for leaf, kind in leaves if kind == AFFINE]
        fixed = [leaf for leaf, kind in leaves if kind == KNOWN]
        return jnp.concatenate([jnp.ravel(leaf) for leaf in follows]), fixed

    nothing = jnp.zeros(n + p)
    offset, fixed = once(nothing)
    slopes = jax.jacfwd(lambda both: once(both)[0])(nothing)
    matrices = slopes[:n, :n], slopes[:n, n:], slopes[n:, :n], slopes[n:, n:]
    return Settled(*matrices, offset[:n], offset[n:]), fixed


class Rows(NamedTuple):
    """A settled filter that takes a row of samples at once.

    The outputs of a row are sums over its own samples and the state before it, so that only the
    states between rows come one after another. The matrices are transposed.

    Attributes:
        A: from state to state, ``(n, n)``.
        B: from samples to state, ``(row p, n)``.
        C: from state to outputs, ``(n, row m)``.
        D: from samples to outputs, ``(row p, row m)``.
        a: added to the state, ``(n,)``.
        c: added to the outputs, ``(row m,)``.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    a: Array
    c: Array

    def passed(self, x: Array, u: Array) -> tuple[Array, Array]:
        """State ``(n,)`` after a row ``(row p,)``, and its outputs ``(row m,)``."""
        after = contracted(self.A, x) + contracted(self.B, u) + self.a
        return after, contracted(self.C, x) + contracted(self.D, u) + self.c


def in_rows(system: Settled, row: int) -> Rows:
    """The same filter, for rows of so many samples.

    >>> one, none = jnp.ones((1, 1)), jnp.zeros(1)
    >>> mean = Settled(one / 2, one / 2, -one, one, none, none)
    >>> x, innovations = in_rows(mean, 4).passed(none, jnp.array([4.0, 4.0, 2.0, 6.0]))
    >>> x.tolist(), innovations.tolist()
    ([4.25], [4.0, 2.0, -1.0, 3.5])
    """
    A, B, C, D, a, c = system
    (n, p), m = B.shape, len(C)
    begin = jnp.concatenate([B, a[:, None], jnp.eye(n)], axis=1)
    after, powers = over_time(lambda X, _: (matmul(A, X), X), begin, jnp.arange(row))
    seen = C @ powers  # of each number of samples later
    delays = jnp.concatenate([D[None], seen[:-1, :, :p], jnp.zeros((1, m, p))])
    behind = jnp.arange(row) - jnp.arange(row)[:, None]
    own = delays[jnp.where(behind < 0, row, behind)]  # from a sample to outputs
    drift = jnp.concatenate([jnp.zeros((1, m)), jnp.cumsum(seen[:-1, :, p], axis=0)])
    return Rows(
        after[:, p + 1 :].T,
        powers[::-1, :, :p].transpose(0, 2, 1).reshape(row * p, n),
        seen[:, :, p + 1 :].transpose(2, 0, 1).reshape(n, row * m),
        own.transpose(0, 3, 1, 2).reshape(row * p, row * m),
        powers[:, :, p].sum(axis=0),
        (drift + c).reshape(-1),
    )


def _number(leaf: Any) -> int:
    return AFFINE if jnp.issubdtype(leaf.dtype, jnp.floating) else NONLINEAR


def _size(leaves: list[Any]) -> int:
    return sum(leaf.size for leaf in leaves)


def _cut(numbers: Array, shapes: list[Any]) -> list[Array]:
    """Arrays of some shapes from their numbers, the last axis of an array, one after another."""
    ends = np.cumsum([leaf.size for leaf in shapes])[:-1]
    parts = jnp.split(numbers, ends, axis=-1)
    return [
        part.reshape(*numbers.shape[:-1], *leaf.shape)
        for part, leaf in zip(parts, shapes, strict=True)
    ]
