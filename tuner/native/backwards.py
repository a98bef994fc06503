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
from objectives import Data, Objective, is_fold, weighed
from tuner.native.compiler import library
from tuner.native.filled import MEMORY, address, filled, kept_of, side_by_side
from tuner.native.passes_choice import shortest
from tuner.native.passes_frame import Code
from tuner.native.row_function import RowFunction
from tuner.native.runner import columns, is_real, runner_of

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

    Attributes:
        operations: number of them for a sample.
        work: the same, where memory counts by its time.
        returns: that it goes back.

    Raises:
        NoCounterpartError: names the operation that has no counterpart among scalars.
        TooLargeError: for an iteration of too many operations.
    """

    returns: Literal[True] = True

    def __init__(
        self,
        filter: AnyFilter,
        objective: Objective,
        build: Callable[[Array], Any],
        size: int,
        data: Data,
        folder: Path,
    ) -> None:
        self._objective, self._folder, self._folds = objective, folder, is_fold(objective)
        runner = runner_of(filter, objective, build, jax.device_put(np.zeros(size)), data)
        before, self._code = shortest(runner, build, size)
        self._count, self._keeps = before.count, runner.keeps
        self.operations = self._code.operations
        self.work = self.operations + MEMORY * (self._code.stored + self._code.kept)
        self._total = jax.eval_shape(objective.init) if is_fold(objective) else None
        self._kept = kept_of(filter, objective, jax.eval_shape(build, np.zeros(size)), data)
        self._numbers = RowFunction(before.numbers, size, folder)
        self._weighed = jax.jit(self._weights)
        self._valued = jax.jit(self._value)
        self._of_end = RowFunction(self._weights_of_end, self._code.total, folder)

        def pulled(both: Array) -> Array:
            z, by = jnp.split(both, [size])
            (slope,) = jax.vjp(before.numbers, z)[1](by)
            return jnp.asarray(slope)

        self._pull = RowFunction(pulled, size + self._count, folder)
        self._spare: list[np.ndarray] = []

    def rows(self, data: Data) -> np.ndarray:
        """A record in the loop's layout, ``(N, k)``."""
        return columns(data if self._folds else data.inputs)

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
        value, by_end, by_kept = self._judged(*self._over(runs, data))
        weights = np.asarray(by_end), np.asarray(by_kept)
        by_numbers = sum(side_by_side(lambda run: run.backwards(*weights, self._count), runs))
        spare += [run.store for run in runs if run.store is not None]
        (gradient,) = self._pull(np.hstack([z, by_numbers])[None])
        return float(value), gradient

    def value(self, z: np.ndarray, rows: np.ndarray, data: Data, at: Sequence[int] = ()) -> float:
        """The objective alone; arguments as of :meth:`value_and_gradient`."""
        over = self._over(self._runs(z, rows, at), data)
        return float(self._judged(*over)[0] if self._sums else self._valued(*over))

    def _runs(self, z: np.ndarray, rows: np.ndarray, at: Sequence[int]) -> "list[_Run]":
        (numbers,), edges = self._numbers(z[None]), pairwise((0, *at, len(rows)))
        return [_Run(self._library, self._code, numbers, rows[a:b]) for a, b in edges]

    @property
    def _sums(self) -> bool:
        """Whether the objective follows from the numbers at the end alone."""
        return self._folds and not self._code.kept

    def _judged(self, end: np.ndarray, kept: np.ndarray, truth: Any) -> tuple[Any, Any, Any]:
        """The objective, and its derivatives by the numbers at the end and the kept ones."""
        if not self._sums:
            value, by_end, by_kept = self._weighed(end, kept, truth)
            return value, by_end, by_kept
        (found,) = self._of_end(end[None])
        return found[0], found[1:], kept

    def _over(self, runs: "list[_Run]", data: Data) -> tuple[np.ndarray, np.ndarray, Any]:
        """The loop's results, and the truth."""
        side_by_side(_Run.forwards, runs)
        end = np.sum([run.end for run in runs], axis=0)
        return end, runs[0].kept, None if self._folds else data.truth

    @cached_property
    def _library(self) -> ctypes.CDLL:
        found = library(self._code.text, self._folder, self._code.options)
        for function, count in ((found.forwards, 6), (found.backwards, 7)):
            function.argtypes = [*[ctypes.c_size_t] * 3, *[ctypes.c_void_p] * count]
            function.restype = None
        return found

    def _value(self, end: Array, kept: Array, truth: Any) -> Array:
        return weighed(self._objective, Data(None, truth), self._collected(end, kept))[0]

    def _weights(self, end: Array, kept: Array, truth: Any) -> tuple[Array, Array, Array]:
        """The objective from the loop's results, and its derivatives by them."""
        both = self._collected(end, kept)
        value, (by_total, by_kept) = weighed(self._objective, Data(None, truth), both)
        ends = [jnp.ravel(_slope(x)) for x in jax.tree.leaves(by_total)]
        pairs = zip(jax.tree.leaves(self._kept), jax.tree.leaves(by_kept), self._keeps, strict=True)
        parts = [by.reshape(len(kept), -1) for leaf, by, k in pairs if k and is_real(leaf)]
        none = jnp.zeros(0)
        return value, jnp.concatenate([none, *ends]), jnp.hstack([kept[:, :0], *parts])

    def _weights_of_end(self, end: Array) -> Array:
        value, by_end, _ = self._weights(end, jnp.zeros((1, 0)), None)
        return jnp.hstack([value, by_end])

    def _collected(self, end: Array, kept: Array) -> tuple[Any, Any]:
        total = filled(self._total, end, ())
        return total, filled(self._kept, kept, (len(kept),), self._keeps)


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


def _slope(by: Any) -> Array:
    """A derivative; 0 by numbers that have none."""
    return jnp.zeros(by.shape) if by.dtype == jax.dtypes.float0 else by
