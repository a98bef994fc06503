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
from tuner.native.filled import MEMORY
from tuner.native.kept_texts import UNKEPT, KeptTexts
from tuner.native.loop_score import Judge, LoopScore
from tuner.native.pass_run import PassRun, Steps, linked
from tuner.native.passes_choice import shortest
from tuner.native.passes_frame import Code
from tuner.native.reversal import Before
from tuner.native.row_function import RowFunction
from tuner.native.runner import Runner, columns, runner_of
from tuner.processors import side_by_side


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
        self._spare: list[PassRun] = []

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
        if not at and self._whole is not None:
            run = self._taken(len(rows))
            found = run.value_and_gradient(z, rows, self._whole)
            self._spare.append(run)
            return found
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
        if not at and self._valued is not None:
            run = self._taken(len(rows))
            found = run.value(z, rows, self._valued)
            self._spare.append(run)
            return found
        runs = self._begun(z, rows, at)
        value = self._judge.value(*self._over(runs, storing=False), data)
        self._spare += runs
        return value

    def _begun(self, z: np.ndarray, rows: np.ndarray, at: Sequence[int]) -> list[PassRun]:
        """Runs over the parts of a record, at a point."""
        (numbers,), edges = self._numbers(z[None]), pairwise((0, *at, len(rows)))
        return [self._taken(b - a).begun(numbers, rows[a:b]) for a, b in edges]

    def _taken(self, samples: int) -> PassRun:
        """A spare run over as many samples, whose memory's pages are there already, or a new one.

        Other threads may take some at the same time.
        """
        while self._spare:
            try:
                found = self._spare.pop()
            except IndexError:
                break
            if found.samples == samples:
                return found
        return PassRun(self._library, self._code, self._size, self._count, samples)

    def _over(self, runs: list[PassRun], *, storing: bool) -> tuple[np.ndarray, np.ndarray]:
        """The numbers at the end, and the kept values."""
        side_by_side(lambda run: run.forwards(storing=storing), runs)
        return _total([run.end for run in runs]), runs[0].kept

    @cached_property
    def _valued(self) -> Steps | None:
        """The steps of a value in one call; None where some are not in C."""
        found = self._numbers.address, self._judge.address
        return Steps(*found) if all(found) else None

    @cached_property
    def _whole(self) -> Steps | None:
        """The same of a gradient."""
        pull = self._pull.address
        return self._valued._replace(pull=pull) if self._valued and pull else None

    @cached_property
    def _library(self) -> ctypes.CDLL:
        return linked(library(self._code.text, self._folder, self._code.options))


def _total(parts: Sequence[np.ndarray]) -> np.ndarray:
    """The sum of some arrays, which is mostly one of them."""
    return parts[0] if len(parts) == 1 else np.sum(parts, axis=0)
