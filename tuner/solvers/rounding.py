"""The end of a descent whose values differ by rounding only."""

from typing import NamedTuple

import numpy as np

from objectives import kind_of
from tuner.problem.problem import Problem
from tuner.solvers.minimum import Minimum

_NOISE = 8 * float(np.finfo(float).eps)
"""Rounding of a sum over time, for the root of its samples, over the sum."""
_STILL = 6
"""Evaluations in a row that tell nothing: a descent that would go on has gone on by then."""


class OnlyRoundingError(Exception):
    """The values of a descent differ by rounding only.

    Attributes:
        end: the point of the smallest gradient among those that are equal.
    """

    def __init__(self, end: Minimum) -> None:
        super().__init__(end.message)
        self.end = end


class _Point(NamedTuple):
    """A point ``(n,)``, its value, and its gradient ``(n,)``."""

    z: np.ndarray
    value: float
    gradient: np.ndarray


class UntilRounding:
    """Value and gradient of a problem, until its values differ by rounding only.

    A sum over a long record is rounded by more than a step near the minimum lowers it. A line
    search then takes rounding for a rise: it rejects better points by the dozen, and ends as
    "abnormal". The gradient, which is not a small difference of large numbers, still tells there
    which point is better.

    Args:
        problem: what is minimised.
        box: lowest and highest z, ``(n,)`` each.
    """

    def __init__(self, problem: Problem, box: tuple[np.ndarray, np.ndarray]) -> None:
        self._problem, self._box = problem, box
        self._least = 1.0 if kind_of(problem.objective) == "likelihood" else 0.0
        self._noise = _NOISE * np.sqrt(problem.data.samples)
        self._best: _Point | None = None
        self._lowest = np.inf
        self._still = self._evaluations = 0

    def __call__(self, z: np.ndarray) -> tuple[float, np.ndarray]:
        """Both at z ``(n,)``.

        Raises:
            OnlyRoundingError: where the last values are equal but for rounding.
        """
        value, gradient = self._problem.value_and_gradient(z)
        self._evaluations += 1
        self._take(_Point(z.copy(), value, gradient))
        return value, gradient

    def _slope(self, point: _Point) -> float:
        """The largest component of the gradient at a point, within the box."""
        z, (low, high) = point.z, self._box
        return float(np.abs(np.clip(z - point.gradient, low, high) - z).max(initial=0.0))

    def _take(self, point: _Point) -> None:
        best, noise = self._best, self._noise * max(abs(point.value), self._least)
        apart = point.value - self._lowest
        self._lowest = min(self._lowest, point.value)
        if best is None or not abs(apart) <= noise:
            self._still = 0
            if best is None or apart < 0:
                self._best = point
            return
        self._still += 1
        if self._slope(point) < self._slope(best):
            self._best = best = point
        if self._still >= _STILL:
            message = "values that differ by rounding only"
            end = Minimum(best.z, best.value, self._evaluations, finished=True, message=message)
            raise OnlyRoundingError(end)
