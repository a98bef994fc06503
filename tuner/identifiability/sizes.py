"""Possible sizes of a record's noise, for the search's defaults and limits."""

from collections.abc import Mapping
from dataclasses import dataclass

from tuner.identifiability.least_squares import alone, estimate
from tuner.identifiability.linear_form import linear_problem
from tuner.identifiability.windows import differences
from tuner.problem.problem import Problem


@dataclass(frozen=True)
class NoiseSize:
    """The possible size of one noise parameter.

    Attributes:
        alone: its value if it caused the smallest differences that do not depend on the
            state by itself; by their median, which outliers do not move.
        most: the same by their mean.
        least: the smallest that a record of this length distinguishes from 0.
        estimate: its least-squares estimate beside the others.
        deviation: of the estimate.
    """

    alone: float
    most: float
    least: float
    estimate: float
    deviation: float


def noise_sizes(problem: Problem) -> Mapping[str, NoiseSize]:
    """The size of every scalar noise parameter that the record determines, by name.

    Raises:
        NoModelError: as :func:`tuner.determined`.
    """
    linear = linear_problem(problem)
    n, m = linear.recordings[0].F.shape[-1], len(linear.recordings[0].H)
    medians, means = alone(differences(linear.recordings, -(-(n + m) // m) * m))
    found = estimate(differences(linear.recordings), linear.entries)
    # White noise on the n-th derivative moves N samples by N^(2n - 1) of its effect on one.
    least = min(1e-10, float(linear.samples) ** (-2 * n // max(m, 1)))
    return {
        entry.parameter: NoiseSize(
            float(median), float(mean), least * float(median), float(value), float(deviation)
        )
        for entry, median, mean, value, deviation in zip(
            linear.entries, medians, means, found.values, found.deviations, strict=True
        )
        if not entry.place and entry.power == 1 and median > 0
    }
