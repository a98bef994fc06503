"""A problem's value and gradient with the time loop in C, and the rest in JAX."""

import ctypes
from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import AnyFilter
from objectives import Data, Objective, is_fold
from tuner.code.graph import TooLargeError
from tuner.code.refused import NoCounterpartError
from tuner.compiler import library
from tuner.native.filled import MEMORY, address
from tuner.native.iteration import Iteration, iteration
from tuner.native.kept_texts import UNKEPT, KeptTexts
from tuner.native.loop import loop
from tuner.native.loop_score import Judge, LoopScore
from tuner.native.loop_text import varying
from tuner.native.phases import Phases, phases
from tuner.native.row_function import RowFunction
from tuner.native.runner import Runner, columns, runner_of
from tuner.native.scaled import scaled
from tuner.native.text import source
from tuner.processors import side_by_side

LANES = 8
"""Directions or points at once: the width of today's widest vectors."""


class _Ends(NamedTuple):
    """How many numbers a loop leaves at its end and keeps of a sample; whether it only sums up."""

    total: int
    kept: int
    sums: bool


class _Costs(NamedTuple):
    """Vectors of directions in a loop, its operations, and its work, of one pass; if it settles."""

    vectors: int
    operations: int
    work: float
    settles: bool


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
        texts: its C, kept between runs: what has been written is not traced again.
        settle: whether it may go on with constant gains where they have settled.

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
        texts: KeptTexts = UNKEPT,
        *,
        settle: bool = True,
    ) -> None:
        self.build, self.size, self.folder, self._texts = build, size, folder, texts
        self._settle = settle
        self._filter, self._objective, self._data = filter, objective, data
        self._ends = _Ends(*texts.of("ends", self._counted))
        self._slopes = RowFunction(self._number_and_slopes, size, folder, texts("slopes"))
        self._numbers = RowFunction(self._number, size, folder, texts("numbers"))
        total, _, sums = self._ends
        self._judge = Judge(lambda: self._score, total, sums, folder, texts("of ends"))

    def _counted(self) -> "_Ends":
        own = self._iteration
        return _Ends(len(own.total), len(own.kept), self._score.sums)

    @cached_property
    def _runner(self) -> Runner:
        given = self._filter, self._objective, self.build
        return runner_of(*given, jax.device_put(np.zeros(self.size)), self._data)

    @cached_property
    def _iteration(self) -> Iteration:
        return scaled(iteration(self._runner))

    @cached_property
    def _score(self) -> LoopScore:
        params = jax.eval_shape(self.build, np.zeros(self.size))
        return LoopScore(self._filter, self._objective, params, self._data, self._runner.keeps)

    @cached_property
    def _places(self) -> list[np.ndarray]:
        """The numbers of each leaf of the parameters that depend on a point."""
        return [np.flatnonzero(leaf.any(-1)) for leaf in self._runner.moved]

    @cached_property
    def _moves(self) -> np.ndarray:
        """The coordinates of a point that each of these numbers depends on."""
        return np.vstack([leaf[leaf.any(-1)] for leaf in self._runner.moved])

    def rows(self, data: Data) -> np.ndarray:
        """A record in the loop's layout, ``(N, k)``."""
        return columns(data if is_fold(self._objective) else data.inputs)

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
        ends = np.empty((1 + len(at), blocks, self._ends.total, 1 + wide))
        count = self._ends.kept
        kept = np.empty((blocks, len(rows) if count else 0, count, 1 + wide))
        records = _parts(rows, at)

        def go(part: tuple[int, int]) -> None:
            record, block = part
            given = padded[block], records[record], ends[record, block], kept[block]
            run(*records[record].shape, address(numbers), *map(address, given))

        side_by_side(go, list(np.ndindex(*ends.shape[:2])))
        end, width = ends.sum(axis=0), blocks * wide
        slopes = end[..., 1:].transpose(1, 0, 2).reshape(end.shape[1], width)
        weights = self._judge.weights(end[0, :, 0], kept[0, ..., 0], data)
        gradient = weights.by_end @ slopes
        if count:
            real = kept if self._score.real.all() else kept[:, :, self._score.real]
            by_lane = np.einsum("ij,bijk->bk", weights.by_kept, real[..., 1:])
            gradient += by_lane.reshape(width)
        return weights.value, gradient[: self.size]

    def value(self, z: np.ndarray, rows: np.ndarray, data: Data, at: Sequence[int] = ()) -> float:
        """The objective alone; arguments as of :meth:`value_and_gradient`."""
        end, kept, _ = self._over(z, rows, at)
        return self._judge.value(end, kept, data)

    def settled(self, z: np.ndarray, rows: np.ndarray, at: Sequence[int] = ()) -> float:
        """Share of a record that it takes with constant gains; arguments as before."""
        return self._over(z, rows, at)[2] / len(rows)

    def _over(
        self, z: np.ndarray, rows: np.ndarray, at: Sequence[int]
    ) -> tuple[np.ndarray, np.ndarray, int]:
        """The numbers at the end, the kept values, and how many samples had constant gains."""
        (numbers,) = self._numbers(z[None])
        ends = np.empty((1 + len(at), self._ends.total))
        kept = np.empty((len(rows), self._ends.kept))

        def go(part: tuple[np.ndarray, np.ndarray]) -> int:
            rows, end = part
            given = map(address, (numbers, numbers, rows, end, kept))
            return int(self._plain(*rows.shape, *given))

        settled = side_by_side(go, list(zip(_parts(rows, at), ends, strict=True)))
        return ends.sum(axis=0), kept, sum(settled)

    def values_and_gradients(
        self, Z: np.ndarray, rows: np.ndarray, data: Data
    ) -> tuple[np.ndarray, np.ndarray]:
        """Objectives and gradients at points Z ``(B, n)``, with a thread for each processor.

        Raises:
            NoCodeError: where there is no compiler that works.
            NoCounterpartError: where points cannot go side by side.
        """
        if not self._ends.sums:
            raise NoCounterpartError("what is kept for after the loop, of points side by side,")
        run = self._points
        padded = np.vstack([Z, np.repeat(Z[-1:], -len(Z) % LANES, axis=0)])
        numbers, slopes = self._with_slopes(padded)
        count = len(padded) // LANES
        p = numbers.reshape(count, LANES, -1).transpose(0, 2, 1)
        dp = slopes.reshape(count, LANES, -1, self.size).transpose(0, 2, 3, 1)
        ends = np.empty((count, self._ends.total, 1 + self.size, LANES))
        none = np.empty(0)

        def group(k: int) -> None:
            given = np.ascontiguousarray(p[k]), np.ascontiguousarray(dp[k])
            run(*rows.shape, *map(address, (*given, rows, ends[k], none)))

        side_by_side(group, range(count))
        by_point = ends.transpose(0, 3, 1, 2).reshape(len(padded), *ends.shape[1:3])[: len(Z)]
        found = self._judge.of_ends(by_point[..., 0])
        values, by_end = found[:, 0], found[:, 1:]
        return values, np.einsum("bt,btn->bn", by_end, by_point[..., 1:])

    @property
    def _lanes(self) -> int:
        return min(LANES, max(2, 1 << (self.size - 1).bit_length()))

    @property
    def operations(self) -> int:
        """Number of operations per sample; one on all lanes counts once."""
        return self._blocks * self._costs.operations

    @property
    def work(self) -> float:
        """The same, where one on lanes counts by its vectors of 256 bits; memory by its time."""
        return self._blocks * self._costs.work

    @property
    def settles(self) -> bool:
        """Whether its loop goes on with constant gains where they have settled."""
        return self._costs.settles

    @property
    def _vectors(self) -> int:
        """Number of vectors of directions in the loop."""
        return self._costs.vectors

    @property
    def _blocks(self) -> int:
        """Number of passes over the record, for as many directions as there are."""
        return -(-self.size // (self._vectors * self._lanes))

    @cached_property
    def _costs(self) -> "_Costs":
        return _Costs(*self._texts.of("costs", self._estimated))

    def _estimated(self) -> "_Costs":
        loop = self._loop.main
        wide = len(varying(loop, {"dp"}).intersection(loop.needed))
        once = loop.operations + wide * (max(1.0, self._lanes / 4) - 1)
        kept = len(loop.kept) * (1 + loop.directions * self._lanes)
        settles = self._loop.settled is not None
        return _Costs(loop.directions, loop.operations, once + MEMORY * kept, settles)

    @cached_property
    def _loop(self) -> Phases:
        """The loop with all directions, which share its values, or else with one vector of them."""
        every = [np.ones(len(self._moves), bool)]
        try:
            whole = loop(self._iteration, every * -(-self.size // self._lanes))
        except TooLargeError:
            whole = loop(self._iteration, every)
        return phases(whole, settle=self._settle)

    @cached_property
    def _directions(self) -> Any:
        return self._loaded("directions", lambda: source(self._loop, self._lanes, points=False))

    @cached_property
    def _plain(self) -> Any:
        def written() -> str:
            values = phases(loop(self._iteration, []), settle=self._settle)
            return source(values, LANES, points=False)

        return self._loaded("values", written)

    @cached_property
    def _points(self) -> Any:
        def written() -> str:
            by_point = phases(loop(self._iteration, list(self._moves.T)), settle=self._settle)
            return source(by_point, LANES, points=True)

        return self._loaded("points", written)

    def _loaded(self, name: str, written: Callable[[], str]) -> Any:
        function = library(self._texts.of(name, written), self.folder).run
        function.argtypes = [ctypes.c_size_t, ctypes.c_size_t, *[ctypes.c_void_p] * 5]
        function.restype = ctypes.c_size_t
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


def _parts(rows: np.ndarray, at: Sequence[int]) -> list[np.ndarray]:
    """The rows between those where the loop begins anew."""
    return [rows[a:b] for a, b in pairwise((0, *at, len(rows)))]
