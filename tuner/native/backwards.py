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
        self._spare: list[_Run] = []

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
        runs = self._begun(z, rows, at)
        end, kept = self._over(runs, storing=True)
        value, *weights = self._judge.weights(end, kept, data)
        by_numbers = side_by_side(lambda run: run.backwards(*weights), runs)
        both = np.empty((1, self._size + self._count))
        both[0, : self._size], both[0, self._size :] = z, _total(by_numbers)
        self._spare += runs
        (gradient,) = self._pull(both)
        return value, gradient

    def value(self, z: np.ndarray, rows: np.ndarray, data: Data, at: Sequence[int] = ()) -> float:
        """The objective alone; arguments as of :meth:`value_and_gradient`."""
        runs = self._begun(z, rows, at)
        value = self._judge.value(*self._over(runs, storing=False), data)
        self._spare += runs
        return value

    def _begun(self, z: np.ndarray, rows: np.ndarray, at: Sequence[int]) -> "list[_Run]":
        """Runs over the parts of a record, at a point."""
        (numbers,), edges = self._numbers(z[None]), pairwise((0, *at, len(rows)))
        return [self._taken(rows[a:b]).begun(numbers, rows[a:b]) for a, b in edges]

    def _taken(self, rows: np.ndarray) -> "_Run":
        """A spare run over as many samples, whose memory's pages are there already, or a new one.

        Other threads may take some at the same time.
        """
        while self._spare:
            try:
                found = self._spare.pop()
            except IndexError:
                break
            if found.samples == len(rows):
                return found
        return _Run(self._library, self._code, self._count, len(rows))

    def _over(self, runs: "list[_Run]", *, storing: bool) -> tuple[np.ndarray, np.ndarray]:
        """The numbers at the end, and the kept values."""
        side_by_side(lambda run: run.forwards(storing=storing), runs)
        return _total([run.end for run in runs]), runs[0].kept

    @cached_property
    def _library(self) -> ctypes.CDLL:
        found = library(self._code.text, self._folder, self._code.options)
        for function, count in ((found.forwards, 6), (found.backwards, 7)):
            function.argtypes = [*[ctypes.c_size_t] * 3, *[ctypes.c_void_p] * count]
            function.restype = None
        return found


class _Run:
    """A run over a record, or over one of those that lie end to end, with its memory.

    Args:
        library: with both passes.
        code: of both.
        count: of the numbers that vary with a point.
        samples: of the record.

    Attributes:
        end: the numbers needed at the end.
        kept: the values kept of each sample.
    """

    def __init__(self, library: Any, code: Code, count: int, samples: int) -> None:
        self._library, self.samples = library, samples
        self._part = part_of(samples, 8 * max(1, code.stored))
        self._numbers, self._by_numbers = np.zeros(count), np.zeros(count)
        self._saved = np.empty(-(-samples // self._part) * max(1, code.carried))
        self.end, self.kept = np.empty(code.total), np.empty((samples, code.kept))
        self._store, self._size = np.empty(0), self._part * max(1, code.stored)
        self._results = address(self.kept), address(self.end)

    def begun(self, numbers: np.ndarray, rows: np.ndarray) -> "_Run":
        """The run at a point, over a record."""
        self._numbers[:] = numbers
        shape = self.samples, self._part, rows.shape[1]
        self._rows, self._given = rows, (*shape, address(self._numbers), address(rows))
        return self

    def forwards(self, *, storing: bool) -> None:
        """The pass over the record, which stores what the way back needs, or does not."""
        if storing and not self._store.size:
            self._store = np.empty(self._size)
            self._stored = address(self._saved), address(self._store)
        stored = self._stored if storing else (None, None)
        self._library.forwards(*self._given, *stored, *self._results)

    def backwards(self, by_end: np.ndarray, by_kept: np.ndarray) -> np.ndarray:
        """The pass back: the derivatives by the numbers that vary with a point."""
        self._by_numbers[:] = 0.0
        weights = address(by_end), address(by_kept)
        self._library.backwards(*self._given, *weights, *self._stored, address(self._by_numbers))
        return self._by_numbers


def part_of(samples: int, stored: int) -> int:
    """Number of samples of a part, of which each stores some bytes."""
    return samples if samples * stored <= STORED else max(1, PART // stored)


def _total(parts: Sequence[np.ndarray]) -> np.ndarray:
    """The sum of some arrays, which is mostly one of them."""
    return parts[0] if len(parts) == 1 else np.sum(parts, axis=0)
