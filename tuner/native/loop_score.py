"""The objective from the results of a loop in C: the numbers at its end and the kept values."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import AnyFilter
from objectives import Data, Objective, is_fold, weighed
from tuner.native.filled import filled, kept_of
from tuner.native.kept_texts import Kept
from tuner.native.row_function import RowFunction
from tuner.native.runner import is_real


class Weights(NamedTuple):
    """The objective, its derivatives by the numbers at the end ``(t,)``, and by the kept ones.

    The latter have a column for each kept number that has derivatives, ``(N, r)``.
    """

    value: float
    by_end: np.ndarray
    by_kept: np.ndarray


class LoopScore:
    """An objective of a loop's results.

    Args:
        filter: the filter.
        objective: of the filter.
        params: the filter's parameters, or their shapes.
        data: a record, or its shapes and types.
        keeps: which leaves of the kept values there are.

    Attributes:
        sums: whether the objective follows from the numbers at the end alone.
        real: which of the kept numbers have derivatives.
    """

    def __init__(
        self,
        filter: AnyFilter,
        objective: Objective,
        params: Any,
        data: Data,
        keeps: list[bool],
    ) -> None:
        self._objective, self._keeps, self._folds = objective, keeps, is_fold(objective)
        self._total = jax.eval_shape(objective.init) if is_fold(objective) else None
        self._kept = kept_of(filter, objective, params, data)
        pairs = zip(jax.tree.leaves(self._kept), keeps, strict=True)
        leaves = [leaf for leaf, kept in pairs if kept]
        self.real = np.array([is_real(leaf) for leaf in leaves for _ in range(leaf.size)], bool)
        self.sums = self._folds and not leaves
        self._weighed = jax.jit(self._weights)
        self._valued = jax.jit(lambda *given: self._weights(*given)[0])

    def value(self, end: np.ndarray, kept: np.ndarray, data: Data) -> float:
        """The objective alone; arguments as of :meth:`weights`."""
        return float(self._valued(end, kept, None if self._folds else data.truth))

    def weights(self, end: np.ndarray, kept: np.ndarray, data: Data) -> Weights:
        """The objective and its derivatives.

        Args:
            end: the numbers at the end ``(t,)``.
            kept: of each sample, ``(N, k)``.
            data: the record.
        """
        value, by_end, by_kept = self._weighed(end, kept, None if self._folds else data.truth)
        return Weights(float(value), np.asarray(by_end), np.asarray(by_kept))

    def weights_of_end(self, end: Array) -> Array:
        """An objective that follows from ``(t,)`` numbers alone, and its derivatives by them."""
        value, by_end, _ = self._weights(end, jnp.zeros((1, 0)), None)
        return jnp.hstack([value, by_end])

    def _weights(self, end: Array, kept: Array, truth: Any) -> tuple[Array, Array, Array]:
        steps = (len(kept),)
        both = filled(self._total, end, ()), filled(self._kept, kept, steps, self._keeps)
        value, (by_total, by_kept) = weighed(self._objective, Data(None, truth), both)
        ends = [jnp.ravel(_slope(x)) for x in jax.tree.leaves(by_total)]
        pairs = zip(jax.tree.leaves(self._kept), jax.tree.leaves(by_kept), self._keeps, strict=True)
        parts = [by.reshape(*steps, -1) for leaf, by, k in pairs if k and is_real(leaf)]
        return value, jnp.hstack([jnp.zeros(0), *ends]), jnp.hstack([kept[:, :0], *parts])


class Judge:
    """An objective of a loop's results; in C where it follows from the numbers at the end alone.

    Args:
        score: makes the objective; where C is kept between runs, it is not asked.
        total: number of the numbers at the end.
        sums: whether it follows from these alone.
        folder: for compiled code.
        kept: gives its C, made or kept.

    Attributes:
        sums: as given.
        of_ends: the objective and its derivatives of each row of numbers at the end, if it sums.
    """

    def __init__(
        self, score: Callable[[], LoopScore], total: int, sums: bool, folder: Path, kept: Kept
    ) -> None:
        self._score, self.sums = score, sums
        self.of_ends = RowFunction(self._of_end, total, folder, kept)

    @property
    def address(self) -> int:
        """The address of :attr:`of_ends` in C; 0 where there is none."""
        return self.of_ends.address if self.sums else 0

    def value(self, end: np.ndarray, kept: np.ndarray, data: Data) -> float:
        """The objective alone; arguments as of :meth:`LoopScore.weights`."""
        if self.sums:
            return self.weights(end, kept, data).value
        return self._score().value(end, kept, data)

    def weights(self, end: np.ndarray, kept: np.ndarray, data: Data) -> Weights:
        """The objective and its derivatives."""
        if not self.sums:
            return self._score().weights(end, kept, data)
        (found,) = self.of_ends(end[None])
        return Weights(float(found[0]), found[1:], kept)

    def _of_end(self, end: Array) -> Array:
        return self._score().weights_of_end(end)


def _slope(by: Any) -> Array:
    """A derivative; 0 by numbers that have none."""
    return jnp.zeros(by.shape) if by.dtype == jax.dtypes.float0 else by
