"""The time loop of a filter whose gains settle: exact, and soon a few products a sample."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
from jax import Array

from filters.invariant import invariant
from filters.protocol import AnyFilter, over_time
from filters.settled import Parts, Rows, in_rows, parts_of, settled
from filters.small_linalg import matmul
from filters.without_missing import without_missing

Terms: TypeAlias = Callable[[Any, Any], Any]
"""From a sample's outputs and its truth to numbers that are summed up over time."""
SAME = 2.0**-44
"""Largest change of a covariance that is rounding, over the variances that it lies between."""
SHARE, LEAST, MOST = 128, 512, 16_384
"""A block is this share of a record, and no fewer and no more samples."""
ROW = 8
"""Samples that a settled filter takes at once."""
FEWEST = 4
"""A record of fewer blocks is taken one by one."""


@dataclass(frozen=True)
class Settling:
    """A filter whose gains may settle, and that takes the short way from there on.

    The gains of a Kalman filter of a constant model, with samples at one rate, become constant.
    Then it is a linear recursion, of which :func:`summed` takes many samples at once. Nothing is
    approximated: the gains count as constant where the covariance has repeated itself, up to
    rounding, for so long that an error of its start, and of the start of its derivatives, has
    shrunk below rounding too. A filter that forgets slowly, or never, or whose covariance depends
    on its samples, takes every sample by itself to the end; and from a missing number on each does
    so until it has settled again.

    As a filter it is the one inside.

    Attributes:
        filter: a Kalman filter: its covariance forgets as fast as its estimate.
        block: samples after which it is asked again whether the gains have settled, a power of 2
            and 8 or more; None: a 128th of the record.

    >>> from filters import LocalLevel
    >>> Settling(LocalLevel(dt=1.0), block=100)
    Traceback (most recent call last):
    ValueError: a block of 100 samples: take a power of 2 from 8 on, such as 128
    """

    filter: AnyFilter
    block: int | None = None
    same_params = True

    def __post_init__(self) -> None:
        size = self.block
        if size is not None and (size < ROW or size & (size - 1)):
            near = 1 << max(size - 1, ROW - 1).bit_length()
            raise ValueError(
                f"a block of {size} samples: take a power of 2 from {ROW} on, such as {near}"
            )

    def init(self, params: Any) -> Any:
        """The state before the first sample."""
        return self.filter.init(params)

    def step(self, params: Any, state: Any, inputs: Any) -> tuple[Any, Any]:
        """Take one sample."""
        return self.filter.step(params, state, inputs)


def summed(
    filter: Settling, params: Any, data: tuple[Any, Any], terms: Terms, *, again: bool = False
) -> tuple[Any, Array] | None:
    """Sums over time of what follows from a filter's outputs.

    Args:
        filter: the filter.
        params: its parameters.
        data: its inputs, and a truth that is NaN where nothing counts; time first, ``(N, ...)``.
        terms: from a sample's outputs and truth to numbers, any pytree.
        again: whether it will be differentiated backwards, for which each block is run again.

    Returns:
        The pytree, with one sum for each of its leaves, and the number of samples that were taken
        the short way. None where there is no short way: the record has fewer than four
        blocks, the filter is not linear, or nothing in it runs by itself.

    >>> from filters import LevelSample, LocalLevel, LocalLevelNoise, run
    >>> noise = LocalLevelNoise(jnp.array(1.0), jnp.array(1.0))
    >>> record = LevelSample(jnp.sin(0.1 * jnp.arange(5000.0)))
    >>> square = lambda output, truth: jnp.where(jnp.isnan(truth), 0.0, output.innovation**2)
    >>> sums, short = summed(Settling(LocalLevel(1.0)), noise, (record, jnp.zeros(5000)), square)
    >>> full = (run(LocalLevel(1.0), noise, record)[1].innovation ** 2).sum()
    >>> bool(abs(sums - full) < 1e-12 * full), int(short)
    (True, 3584)
    """
    inner, length = filter.filter, len(jax.tree.leaves(data)[0])
    size = filter.block or _size(length)
    if length < FEWEST * size:
        return None
    state, (sample, truth) = inner.init(params), jax.tree.map(lambda leaf: leaf[0], data)
    output = jax.eval_shape(inner.step, params, state, sample)[1]
    whole = without_missing(lambda _, output, truth: terms(output, truth), (), output, truth)
    parts = parts_of(inner, params, sample, lambda output: whole((), output, truth))
    if parts is None:
        return None

    def adding(params: Any, both: Any, at: Any) -> tuple[Any, None]:
        after, output = inner.step(params, both[0], at[0])
        return (after, jax.tree.map(_plus, both[1], terms(output, at[1]))), None

    found = jax.eval_shape(terms, output, truth)
    sums = jax.tree.map(lambda _: jnp.zeros(()), found)
    step = invariant(adding, params, (state, sums), (sample, truth))
    nothing = jax.tree.map(lambda one: jnp.zeros((ROW, *one.shape)), found)
    blocks = _Blocks(step, params, partial(whole, ()), parts, size, nothing)
    cut, count = _cut(data, size)

    def taken(progress: _Progress, number: Array) -> tuple[_Progress, None]:
        return blocks.taken(progress, cut(number))

    each = jax.checkpoint(taken, prevent_cse=False) if again else taken
    end, _ = over_time(each, blocks.begin(state, sums), jnp.arange(count))
    return end.sums, end.short


class _Progress(NamedTuple):
    """What is carried from block to block.

    Attributes:
        state: of the filter.
        sums: over time so far.
        since: what runs by itself in the state, where it began to repeat itself.
        left: what is left of an error since then, ``(n, n)``.
        settled: whether that is nothing.
        short: number of samples that were taken the short way.
    """

    state: Any
    sums: Any
    since: list[Any]
    left: Array
    settled: Array
    short: Array


@dataclass(frozen=True, eq=False)
class _Blocks:
    """Blocks of samples, taken one by one or, where the gains have settled, at once.

    Attributes:
        step: of the filter with the sums.
        params: its parameters.
        terms: what is summed up of a sample in which nothing is missing.
        parts: of the filter.
        size: samples of a block.
        nothing: the terms of a row, all 0.
    """

    step: Any
    params: Any
    terms: Terms
    parts: Parts
    size: int
    nothing: Any

    def begin(self, state: Any, sums: Any) -> _Progress:
        """Before the first sample."""
        moving, still = self.parts.split(state)
        n = sum(leaf.size for leaf in moving)
        return _Progress(state, sums, _held(still), jnp.eye(n), jnp.array(False), jnp.array(0))

    def taken(self, progress: _Progress, block: Any) -> tuple[_Progress, None]:
        """One block, either way."""
        system, fixed = settled(self.parts, self.params, self.parts.split(progress.state)[1])
        rows = in_rows(system, ROW)
        whole = ~jnp.stack([jnp.isnan(leaf).any() for leaf in jax.tree.leaves(block)]).any()
        after: _Progress = jax.lax.cond(
            progress.settled & whole,
            lambda: self.at_once(progress, block, rows, fixed),
            lambda: self.one_by_one(progress, block, rows, whole),
        )
        return after, None

    def one_by_one(self, progress: _Progress, block: Any, rows: Rows, whole: Array) -> _Progress:
        """A block of which every sample is a step; then, whether the gains have settled."""
        both, since, left = progress[:2], progress.since, progress.left
        (state, sums), _ = over_time(self.step, both, block)
        now = _held(self.parts.split(state)[1])
        squarings = jnp.arange((self.size // ROW).bit_length() - 1)
        A, _ = over_time(lambda A, _: (matmul(A, A), None), _held(rows.A), squarings)
        same = whole & _same(now, since)
        left = jnp.where(same, matmul(A, left), jnp.eye(len(A)))
        since = [jnp.where(same, old, new) for old, new in zip(since, now, strict=True)]
        forgot = (left**2).sum() <= jnp.finfo(left.dtype).eps
        return _Progress(state, sums, since, left, same & forgot, progress.short)

    def at_once(self, progress: _Progress, block: Any, rows: Rows, fixed: list[Any]) -> _Progress:
        """A block of a filter whose gains have settled."""
        moving, still = self.parts.split(progress.state)
        samples, truth = jax.tree.map(lambda leaf: leaf.reshape(-1, ROW, *leaf.shape[1:]), block)
        columns = [leaf.reshape(*leaf.shape[:2], -1) for leaf in jax.tree.leaves(samples)]
        taken = jnp.concatenate(columns, axis=2)

        def add(both: Any, at: Any) -> tuple[Any, None]:
            x, follows = rows.passed(both[0], jnp.ravel(at[0]))
            output, axes = self.parts.stacked(follows.reshape(ROW, -1), fixed)
            found = jax.vmap(self.terms, in_axes=(axes, 0))(output, at[1])
            return (x, jax.tree.map(jnp.add, both[1], found)), None

        x = jnp.concatenate([jnp.ravel(leaf) for leaf in moving])
        (x, found), _ = over_time(add, (x, self.nothing), (taken, truth))
        sums = jax.tree.map(_plus, progress.sums, found)
        short = progress.short + self.size
        return progress._replace(state=self.parts.joined(x, still), sums=sums, short=short)


def _plus(total: Array, more: Array) -> Array:
    return total + more.sum(dtype=total.dtype)


def _held(values: Any) -> Any:
    return jax.tree.map(jax.lax.stop_gradient, values)


def _same(now: list[Array], before: list[Array]) -> Array:
    """Whether leaves differ by rounding alone; of a covariance, over its variances."""
    found = [
        (jnp.abs(new - old) <= SAME * _extent(new)).all()
        for new, old in zip(now, before, strict=True)
    ]
    return jnp.stack(found).all()


def _extent(leaf: Array) -> Array:
    if leaf.ndim == 2 and leaf.shape[0] == leaf.shape[1]:
        deviation = jnp.sqrt(jnp.abs(jnp.diagonal(leaf)))
        return jnp.outer(deviation, deviation)
    return jnp.abs(leaf)


def _size(samples: int) -> int:
    """Samples of a block, a power of 2."""
    return 1 << (min(max(samples // SHARE, LEAST), MOST) - 1).bit_length()


def _cut(data: Any, size: int) -> tuple[Callable[[Array], Any], int]:
    """The blocks of a record by their number, and how many there are.

    What the last one lacks repeats the last sample, and does not count.
    """
    length = len(jax.tree.leaves(data)[0])
    whole, left = divmod(length, size)
    if not left:
        return lambda number: jax.tree.map(lambda leaf: _block(leaf, number, size), data), whole

    def filled(leaf: Array, *, counts: bool) -> Array:
        tail = jnp.broadcast_to(leaf[-1:] if counts else jnp.nan, (size - left, *leaf.shape[1:]))
        return jnp.concatenate([leaf[-left:], tail])

    last = (
        jax.tree.map(lambda leaf: filled(leaf, counts=True), data[0]),
        jax.tree.map(lambda leaf: filled(leaf, counts=False), data[1]),
    )

    def cut(number: Array) -> Any:
        def either(leaf: Array, end: Array) -> Array:
            return jnp.where(number == whole, end, _block(leaf, number, size))

        return jax.tree.map(either, tuple(data), last)

    return cut, whole + 1


def _block(leaf: Array, number: Array, size: int) -> Array:
    found: Array = jax.lax.dynamic_slice_in_dim(leaf, number * size, size)
    return found
