"""The unit of differences of values: nats, or shares of the value."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from objectives import Kind, kind_of
from tuner.problem.problem import Problem
from tuner.problem.samples import Added, added, numbers

NATS_95 = 1.920729
"""Half the 95 % quantile of chi-square with one degree of freedom: a likelihood ratio's limit."""
NATS_95_ONE_SIDED = 1.352772
"""Half the 90 % quantile: a one-sided limit that holds in 95 of 100 cases."""
SHARE = 0.01
"""The rise of a plain cost, as a share of it, up to which a value is as good as the best."""
OTHERS = 8
"""Number of points that are evaluated in search of a value that is not 0."""
FLOOR = 1e-6
"""Shares are of the value, but of no less than this share of the value where the search began."""


class Yardstick(NamedTuple):
    """The scale on which differences of an objective's values are judged.

    Attributes:
        kind: of the objective.
        unit: a difference of this size counts 1: one nat of the whole record, or all of the value.
        rise: up to so many units above the best a value is not distinguishable from it.
        negligible: a fall of fewer units does not justify a further step.
    """

    kind: Kind
    unit: float
    rise: float
    negligible: float

    def of(self, difference: float) -> float:
        """A difference of values in units; infinite where it is not a number."""
        return difference / self.unit if np.isfinite(difference) else np.inf


def yardstick(problem: Problem, z: np.ndarray) -> Yardstick:
    """How differences are measured at a point ``(n,)`` of a problem.

    A likelihood's are nats of all its numbers, and 1.92 of them bound a 95 % interval. Any other
    value's are shares of it; where it is next to nothing, as a perfect fit's, of a millionth of
    the value at the problem's own start.
    """
    kind = kind_of(problem.objective)
    if kind == "likelihood" and problem.filter is not None:
        return Yardstick(kind, 1 / max(numbers(problem, z), 1.0), NATS_95, 0.01)
    unit = max(abs(problem.value(z)), FLOOR * _usual(problem))
    return Yardstick(kind, unit if 0 < unit < np.inf else 1.0, SHARE, 1e-3)


def _usual(problem: Problem) -> float:
    """The usual size of values: at the search's start, or elsewhere if that is 0 or not finite."""
    for z in problem.starts(OTHERS, seed=0):
        size = abs(problem.value(z))
        if 0 < size < np.inf:
            return size
    return 0.0


PLAIN = 0.5
"""A mean square that is higher by more than this share differs from the best without a test."""


@dataclass(frozen=True, eq=False)
class Best:
    """The best point, with which others are compared.

    Attributes:
        problem: the problem.
        yard: how differences of its values are measured.
        z: the point, ``(n,)``.
        value: the objective there.
    """

    problem: Problem
    yard: Yardstick
    z: np.ndarray
    value: float

    @cached_property
    def _added(self) -> Added:
        return added(self.problem, self.z)

    def differs_from(self, other: np.ndarray) -> bool:
        """Whether the data distinguish another point ``(n,)`` from this one.

        Of a likelihood the ratio decides, of a plain cost a share. Two mean squares are compared
        sample by sample: they differ where it exceeds twice its standard error, which
        blocks of samples give that are longer than the errors are correlated.
        """
        rise = self.yard.of(self.problem.value(other) - self.value)
        if self.yard.kind in ("likelihood", "cost"):
            return abs(rise) > self.yard.rise
        if not rise < PLAIN:
            return True
        from tuner.certificate.sandwich import long_run

        difference = (added(self.problem, other).amounts - self._added.amounts)[..., None]
        spread = np.sqrt(long_run(difference - difference.mean()).covariance[0, 0])
        return bool(abs(difference.sum()) > 2 * spread)
