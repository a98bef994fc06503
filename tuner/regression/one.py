"""The regression of one window."""

from dataclasses import dataclass
from enum import Enum
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from tuner.regression.interior import EXACT, Point, solve
from tuner.regression.window import Window, window


class Outcome(Enum):
    """The outcome of a regression."""

    UNIQUE = "unique"
    SEVERAL = "several optima"
    UNDETERMINED = "not determined by t"
    INEXACT = "inexact"


@dataclass(frozen=True, eq=False)
class Regression:
    """A possibilistic regression: center p'(1, t) and spread c'abs(1, t).

    Attributes:
        center: p, the intercept first, ``(k + 1,)``.
        spread: c, not negative, ``(k + 1,)``.
        objective: the sum of the spreads at all samples.
        unique: whether no other (p, c) has that objective.
        status: how it ended; only with the first is the center reliable.
        message: that, in a sentence.
        above, below: multipliers of p't + (1 - h) c'abs(t) >= x + (1 - h) e and of
            (1 - h) c'abs(t) - p't >= (1 - h) e - x, ``(m,)``: with them no spread that is smaller
            in sum holds all samples.
        least: multipliers of c >= 0, ``(k + 1,)``.
        violation: the largest violation of a constraint, in the unit of x.
        gap: objective less what the multipliers prove.
    """

    center: np.ndarray
    spread: np.ndarray
    objective: float
    unique: bool
    status: Outcome
    message: str
    above: np.ndarray
    below: np.ndarray
    least: np.ndarray
    violation: float
    gap: float


def tanaka(t: ArrayLike, x: ArrayLike, h: float = 0.0, e: ArrayLike | None = None) -> Regression:
    """The narrowest band about p0 + p1 t1 + .. that holds all samples to the degree h.

    Minimises sum_j sum_i c_i abs(t_ij) with abs(x_j - p't_j) <= (1 - h) (c'abs(t_j) - e_j) and
    c >= 0, i from 0, the intercept. Where several (p, c) are optimal it returns the one with the
    least sum_j (x_j - p't_j)^2 + sum_i ((1 - h) c_i)^2, whose center does not depend on h for
    crisp samples; where t leaves centers that fit alike, the shortest.

    Args:
        t: regressors without the intercept, ``(m,)`` or ``(m, k)``, any signs.
        x: centres of the samples, ``(m,)``.
        h: degree to which samples have to belong to the band, 0 to below 1.
        e: spreads of the samples, ``(m,)``; 0 (crisp) if left out.

    Raises:
        ValueError: for an empty window, shapes that do not fit, numbers that are not finite,
            spreads below 0, or an h outside 0 to below 1.

    Source: Tanaka, Uejima and Asai, IEEE Trans. SMC 12(6), 1982; Tanaka and Watada 1988 (h).

    >>> found = tanaka([1, 2, 3, 4, 5], [8.0, 6.4, 9.5, 13.5, 13.0])
    >>> found.center.round(9).tolist(), found.unique
    ([4.45, 1.833333333], True)
    """
    task = window(t, x, h, e)
    point = solve(task)
    center, spread = task.restored(point.z)
    of, m, factor = task.of, len(task.values), task.size / (1 - h)
    objective = point.cost * factor
    status, message = _ended(task, point)
    if not isfinite(sum(center.tolist(), objective) + sum(spread.tolist())):
        status = Outcome.INEXACT
        message = "a coefficient is larger than any number; give t, or x, in another unit"
    least = np.zeros(len(of.scale))
    least[of.used] = point.multipliers[2 * m :] * of.scale[of.used]
    return Regression(
        center=center,
        spread=spread,
        objective=objective,
        unique=status is Outcome.UNIQUE,
        status=status,
        message=message,
        above=point.multipliers[:m] / (1 - h),
        below=point.multipliers[m : 2 * m] / (1 - h),
        least=least,
        violation=max(point.violation, 0.0) * task.size,
        gap=point.gap * factor,
    )


def _ended(task: Window, point: Point) -> tuple[Outcome, str]:
    n = task.of.columns.shape[1]
    if not point.error <= EXACT:
        return Outcome.INEXACT, (
            f"the point found is right to {point.error:.1g} of the data's range only; check "
            "t for regressors, or samples, that hardly differ"
        )
    if point.unique is None:
        return Outcome.INEXACT, (
            "an optimum was found, but not whether there are others; check t for regressors, or "
            "samples, that hardly differ"
        )
    if task.of.rank < n:
        return Outcome.UNDETERMINED, (
            f"t has rank {task.of.rank} with the intercept and does not determine {n} "
            "coefficients; the shortest center that fits is given: take more, or other, samples"
        )
    if not point.unique:
        return Outcome.SEVERAL, (
            "several centers and spreads have this objective; the one nearest the samples is given"
        )
    return Outcome.UNIQUE, "no other center and spread have this objective"
