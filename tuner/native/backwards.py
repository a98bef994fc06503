"""A problem's value and gradient by a pass over the record and one back, both in C."""

import ctypes
from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import AnyFilter
from objectives import Data, Objective, is_fold
from tuner.compiler import library
from tuner.native.filled import MEMORY, address
from tuner.native.kept_texts import UNKEPT, KeptTexts
from tuner.native.loop_score import Judge, LoopScore
from tuner.native.passes_choice import shortest
from tuner.native.passes_frame import Code
from tuner.native.reversal import Before
from tuner.native.row_function import RowFunction
from tuner.native.runner import Runner, columns, runner_of
from tuner.processors import side_by_side

STORED = 64 << 20
"""Bytes that are stored of a whole record; above it those of parts, which are run again."""
PART = 128 << 10
"""Bytes stored of a part."""


class Backwards:
    """Value and gradient of an objective, over any record of the same kind.

    Args:
        filter: the filter.
        objective: of the filter.
        build: the map from a point to the filter's parameters.
        size: of a point, n.
        data: a record, or its shapes and types.
        folder: for compiled code.
        texts: its C, kept between runs: what has been written is not traced again.

    Attributes:
        operations: number of them for a sample.
        work: the same, where memory counts by its time.
        returns: that it goes back.
        settles: that it takes every sample.

    Raises:
        NoCounterpartError: names the operation that has no counterpart among scalars.
        TooLargeError: for an iteration of too many operations.
    """

    returns: Literal[True] = True
    settles: Literal[False] = False

    def __init__(
        self,
        filter: AnyFilter,
        objective: Objective,
        build: Callable[[Array], Any],
        size: int,
        data: Data,
        folder: Path,
        texts: KeptTexts = UNKEPT,
    ) -> None:
        self._filter, self._objective, self._build, self._data = filter, objective, build, data
        self._folder, self._size = folder, size
        self._count, sums, *code = texts.of("passes", self._written)
        self._code = Code(*code)
        self.operations = self._code.operations
        self.work = self.operations + MEMORY * (self._code.stored + self._code.kept)
        self._numbers = RowFunction(self._number, size, folder, texts("numbers of passes"))
        self._pull = RowFunction(self._pulled, size + self._count, folder, texts("pulled back"))
        given = self._code.total, sums, folder, texts("of their ends")
        self._judge = Judge(lambda: self._score, *given)
        self._spare: list[np.ndarray] = []

    def _written(self) -> tuple[Any, ...]:
        """Number of the numbers that vary with a point, whether all is summed up, and the C."""
        before, code = self._traced
        return before.count, self._score.sums, *code

    @cached_property
    def _runner(self) -> Runner:
        given = self._filter, self._objective, self._build
        return runner_of(*given, jax.device_put(np.zeros(self._size)), self._data)

    @cached_property
    def _traced(self) -> tuple[Before, Code]:
        return shortest(self._runner, self._build, self._size)

    @cached_property
    def _score(self) -> LoopScore:
        params = jax.eval_shape(self._build, np.zeros(self._size))
        return LoopScore(self._filter, self._objective, params, self._data, self._runner.keeps)

    def _number(self, z: Array) -> Array:
        return self._traced[0].numbers(z)

    def _pulled(self, both: Array) -> Array:
        z, by = jnp.split(both, [self._size])
        (slope,) = jax.vjp(self._number, z)[1](by)
        return jnp.asarray(slope)

    def rows(self, data: Data) -> np.ndarray:
        """A record in the loop's layout, ``(N, k)``."""
        return columns(data if is_fold(self._objective) else data.inputs)

    def value_and_gradient(
        self, z: np.ndarray, rows: np.ndarray, data: Data, at: Sequence[int] = ()
    ) -> tuple[float, np.ndarray]:
        """The objective and its gradient at z ``(n,)``: see :class:`tuner.native.compiled.Native`.

        Raises:
            NoCodeError: where there is no compiler that works.
        """
        runs, spare = self._runs(z, rows, at), self._spare
        for run in runs:
            run.store = _memory(run.part * max(1, self._code.stored), spare)
        value, by_end, by_kept = self._judge.weights(*self._over(runs), data)
        weights = by_end, by_kept
        by_numbers = sum(side_by_side(lambda run: run.backwards(*weights, self._count), runs))
        spare += [run.store for run in runs if run.store is not None]
        (gradient,) = self._pull(np.hstack([z, by_numbers])[None])
        return value, gradient

    def value(self, z: np.ndarray, rows: np.ndarray, data: Data, at: Sequence[int] = ()) -> float:
        """The objective alone; arguments as of :meth:`value_and_gradient`."""
        end, kept = self._over(self._runs(z, rows, at))
        return self._judge.value(end, kept, data)

    def _runs(self, z: np.ndarray, rows: np.ndarray, at: Sequence[int]) -> "list[_Run]":
        (numbers,), edges = self._numbers(z[None]), pairwise((0, *at, len(rows)))
        return [_Run(self._library, self._code, numbers, rows[a:b]) for a, b in edges]

    def _over(self, runs: "list[_Run]") -> tuple[np.ndarray, np.ndarray]:
        """The numbers at the end, and the kept values."""
        side_by_side(_Run.forwards, runs)
        return np.sum([run.end for run in runs], axis=0), runs[0].kept

    @cached_property
    def _library(self) -> ctypes.CDLL:
        found = library(self._code.text, self._folder, self._code.options)
        for function, count in ((found.forwards, 6), (found.backwards, 7)):
            function.argtypes = [*[ctypes.c_size_t] * 3, *[ctypes.c_void_p] * count]
            function.restype = None
        return found


class _Run:
    """A run over a record, or over one of those that lie end to end.

    Attributes:
        part: number of samples of a part.
        store: memory for what is stored of a part; None: nothing is, for a value alone.
        end: the numbers needed at the end.
        kept: the values kept of each sample.
    """

    def __init__(self, library: Any, code: Code, numbers: np.ndarray, rows: np.ndarray) -> None:
        self._library, self._numbers, self._rows = library, numbers, rows
        self.part = part_of(len(rows), 8 * max(1, code.stored))
        self.store: np.ndarray | None = None
        self._saved = np.empty(-(-len(rows) // self.part) * max(1, code.carried))
        self.end = np.empty(code.total)
        self.kept = np.empty((len(rows), code.kept))

    def forwards(self) -> None:
        """The pass over the record."""
        stored = (None, None) if self.store is None else map(address, (self._saved, self.store))
        self._library.forwards(*self._given(), *stored, address(self.kept), address(self.end))

    def backwards(self, by_end: np.ndarray, by_kept: np.ndarray, count: int) -> np.ndarray:
        """The pass back: the derivatives by the numbers that vary with a point."""
        out = np.zeros(count)
        assert self.store is not None
        memory = by_end, by_kept, self._saved, self.store, out
        self._library.backwards(*self._given(), *map(address, memory))
        return out

    def _given(self) -> tuple[int, ...]:
        """Samples, those of a part, columns, numbers and record."""
        shape = len(self._rows), self.part, self._rows.shape[1]
        return *shape, address(self._numbers), address(self._rows)


def part_of(samples: int, stored: int) -> int:
    """Number of samples of a part, of which each stores some bytes."""
    return samples if samples * stored <= STORED else max(1, PART // stored)


def _memory(size: int, spare: list[np.ndarray]) -> np.ndarray:
    """Spare memory of this size, whose pages are there already, or new one.

    Other threads may take some at the same time.
    """
    while spare:
        try:
            found = spare.pop()
        except IndexError:
            break
        if len(found) == size:
            return found
    return np.empty(size)
