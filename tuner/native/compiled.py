"""A problem's value and gradient with the time loop in C, and the rest in JAX."""

import ctypes
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import AnyFilter
from objectives import Data, Objective, is_fold
from tuner.code.graph import TooLargeError
from tuner.code.refused import NoCounterpartError
from tuner.native.compiler import library
from tuner.native.filled import MEMORY, address
from tuner.native.fused import fused
from tuner.native.iteration import iteration
from tuner.native.loop import Loop, loop
from tuner.native.loop_score import LoopScore
from tuner.native.pipelining import pipelined
from tuner.native.row_function import RowFunction
from tuner.native.runner import columns, runner_of
from tuner.native.scaled import scaled
from tuner.native.text import source, varying
from tuner.processors import side_by_side

LANES = 8
"""Directions or points at once: the width of today's widest vectors."""


class Native:
    """Value and gradient of an objective, over any record of the same kind.

    The time loop is C that is compiled for this machine, with derivatives by a point's coordinates
    as vector lanes, or with several points. It is called without the interpreter's lock.

    Args:
        filter: the filter.
        objective: of the filter.
        build: the map from a point to the filter's parameters.
        size: of a point, n.
        data: a record, or its shapes and types.
        folder: for compiled code.

    Attributes:
        returns: whether it goes back through the record, which it does not.

    Raises:
        NoCounterpartError: names the operation that has no counterpart among scalars.
        TooLargeError: for an iteration of too many operations.
    """

    returns: Literal[False] = False

    def __init__(
        self,
        filter: AnyFilter,
        objective: Objective,
        build: Callable[[Array], Any],
        size: int,
        data: Data,
        folder: Path,
    ) -> None:
        self.build, self.size, self.folder = build, size, folder
        runner = runner_of(filter, objective, build, jax.device_put(np.zeros(size)), data)
        self._iteration = scaled(iteration(runner))
        moving = [leaf.any(-1) for leaf in runner.moved]
        self._places = [np.flatnonzero(leaf) for leaf in moving]
        self._moves = np.vstack([x[m] for x, m in zip(runner.moved, moving, strict=True)])
        self._folds = is_fold(objective)
        params, ends = jax.eval_shape(build, np.zeros(size)), len(self._iteration.total)
        self._score = LoopScore(filter, objective, params, data, runner.keeps, ends, folder)
        self._numbers = RowFunction(self._number, size, folder)
        self._slopes = RowFunction(self._number_and_slopes, size, folder)

    def rows(self, data: Data) -> np.ndarray:
        """A record in the loop's layout, ``(N, k)``."""
        return columns(data if self._folds else data.inputs)

    def value_and_gradient(
        self, z: np.ndarray, rows: np.ndarray, data: Data, at: Sequence[int] = ()
    ) -> tuple[float, np.ndarray]:
        """The objective and its gradient at z ``(n,)``.

        Args:
            z: the point.
            rows: the record, of :meth:`rows`.
            data: the record.
            at: rows where the loop begins anew, and another thread takes over; for an objective
                that keeps nothing but sums, which begin at 0.

        Raises:
            NoCodeError: where there is no compiler that works.
        """
        run, blocks, wide = self._directions, self._blocks, self._vectors * self._lanes
        (numbers,), (slopes,) = self._with_slopes(z[None])
        padded = np.zeros((blocks, len(numbers), wide))
        for block, part in enumerate(padded):
            own = slopes[:, block * wide : (block + 1) * wide]
            part[:, : own.shape[1]] = own
        ends = np.empty((1 + len(at), blocks, len(self._iteration.total), 1 + wide))
        count = len(self._iteration.kept)
        kept = np.empty((blocks, len(rows) if count else 0, count, 1 + wide))
        records = np.split(rows, at)

        def go(part: tuple[int, int]) -> None:
            record, block = part
            given = padded[block], records[record], ends[record, block], kept[block]
            run(*records[record].shape, address(numbers), *map(address, given))

        side_by_side(go, list(np.ndindex(*ends.shape[:2])))
        end, width = ends.sum(axis=0), blocks * wide
        slopes = end[..., 1:].transpose(1, 0, 2).reshape(end.shape[1], width)
        weights = self._score.weights(end[0, :, 0], kept[0, ..., 0], data)
        gradient = weights.by_end @ slopes
        if count:
            real = kept if self._score.real.all() else kept[:, :, self._score.real]
            by_lane = np.einsum("ij,bijk->bk", weights.by_kept, real[..., 1:])
            gradient += by_lane.reshape(width)
        return weights.value, gradient[: self.size]

    def value(self, z: np.ndarray, rows: np.ndarray, data: Data, at: Sequence[int] = ()) -> float:
        """The objective alone; arguments as of :meth:`value_and_gradient`."""
        (numbers,) = self._numbers(z[None])
        ends = np.empty((1 + len(at), len(self._iteration.total)))
        kept = np.empty((len(rows), len(self._iteration.kept)))

        def go(part: tuple[np.ndarray, np.ndarray]) -> None:
            rows, end = part
            self._plain(*rows.shape, *map(address, (numbers, numbers, rows, end, kept)))

        side_by_side(go, list(zip(np.split(rows, at), ends, strict=True)))
        return self._score.value(ends.sum(axis=0), kept, data)

    def values_and_gradients(
        self, Z: np.ndarray, rows: np.ndarray, data: Data
    ) -> tuple[np.ndarray, np.ndarray]:
        """Objectives and gradients at points Z ``(B, n)``, with a thread for each processor.

        Raises:
            NoCodeError: where there is no compiler that works.
            NoCounterpartError: where points cannot go side by side.
        """
        if not self._score.sums:
            raise NoCounterpartError("what is kept for after the loop, of points side by side,")
        run = self._points
        padded = np.vstack([Z, np.repeat(Z[-1:], -len(Z) % LANES, axis=0)])
        numbers, slopes = self._with_slopes(padded)
        count = len(padded) // LANES
        p = numbers.reshape(count, LANES, -1).transpose(0, 2, 1)
        dp = slopes.reshape(count, LANES, -1, self.size).transpose(0, 2, 3, 1)
        ends = np.empty((count, len(self._iteration.total), 1 + self.size, LANES))
        none = np.empty(0)

        def group(k: int) -> None:
            given = np.ascontiguousarray(p[k]), np.ascontiguousarray(dp[k])
            run(*rows.shape, *map(address, (*given, rows, ends[k], none)))

        side_by_side(group, range(count))
        by_point = ends.transpose(0, 3, 1, 2).reshape(len(padded), *ends.shape[1:3])[: len(Z)]
        values, by_end = self._score.of_ends(by_point[..., 0])
        return values, np.einsum("bt,btn->bn", by_end, by_point[..., 1:])

    @property
    def _lanes(self) -> int:
        return min(LANES, max(2, 1 << (self.size - 1).bit_length()))

    @property
    def operations(self) -> int:
        """Number of operations per sample; one on all lanes counts once."""
        return self._blocks * self._loop.operations

    @cached_property
    def work(self) -> float:
        """The same, where one on lanes counts by its vectors of 256 bits; memory by its time."""
        loop = self._loop
        wide = len(varying(loop, {"dp"}).intersection(loop.needed))
        once = loop.operations + wide * (max(1.0, self._lanes / 4) - 1)
        kept = len(loop.kept) * (1 + self._vectors * self._lanes)
        return self._blocks * (once + MEMORY * kept)

    @property
    def _vectors(self) -> int:
        """Number of vectors of directions in the loop."""
        return self._loop.directions

    @property
    def _blocks(self) -> int:
        """Number of passes over the record, for as many directions as there are."""
        return -(-self.size // (self._vectors * self._lanes))

    @cached_property
    def _loop(self) -> Loop:
        """The loop with all directions, which share its values, or else with one vector of them."""
        every = [np.ones(len(self._moves), bool)]
        try:
            whole = loop(self._iteration, every * -(-self.size // self._lanes))
        except TooLargeError:
            whole = loop(self._iteration, every)
        return pipelined(fused(whole))

    @cached_property
    def _directions(self) -> Any:
        return self._loaded(source(self._loop, self._lanes, points=False))

    @cached_property
    def _plain(self) -> Any:
        values = pipelined(fused(loop(self._iteration, [])))
        return self._loaded(source(values, LANES, points=False))

    @cached_property
    def _points(self) -> Any:
        by_point = pipelined(fused(loop(self._iteration, list(self._moves.T))))
        return self._loaded(source(by_point, LANES, points=True))

    def _loaded(self, text: str) -> Any:
        function = library(text, self.folder).run
        function.argtypes = [ctypes.c_size_t, ctypes.c_size_t, *[ctypes.c_void_p] * 5]
        function.restype = None
        return function

    def _number(self, z: Array) -> Array:
        """The numbers of the parameters that depend on a point."""
        pairs = zip(jax.tree.leaves(self.build(z)), self._places, strict=True)
        return jnp.concatenate([jnp.ravel(leaf)[at].astype(float) for leaf, at in pairs])

    def _number_and_slopes(self, z: Array) -> Array:
        return jnp.hstack([self._number(z)[:, None], jax.jacfwd(self._number)(z)]).ravel()

    def _with_slopes(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """These numbers of each point, ``(B, p)``, and their derivatives, ``(B, p, n)``."""
        both = self._slopes(points)
        both = both.reshape(len(points), both.shape[1] // (1 + self.size), 1 + self.size)
        return np.ascontiguousarray(both[..., 0]), both[..., 1:]
