"""The search for the largest decay rate: bisection between a point and a proof.

One Lyapunov matrix proves both demands, for only then are they linear: Y with the noise inequality
for the variances, and 2 alpha Y more than nothing left of the drift for the rate. For a given rate
the least share t of all bounds is a semidefinite program; bisection on the rate ends where t = 1,
with a point below and a dual proof above.
"""

from dataclasses import dataclass

import numpy as np

from tuner.certificate.solution import Status
from tuner.observers.lmi.design import Design
from tuner.observers.lmi.rates import Point, Rates

ROOM = 0.01
"""Share of the rate that is given up where only infinite gains reach all of it."""

FASTEST = 1e4
"""A decay rate beyond this, in the own unit of time of a system, counts as any."""

EVERY = "every rate is admissible"


@dataclass(frozen=True)
class Ended:
    """The end of a search for the rate, for the design it was given.

    ``slower`` is a gain with room below the bounds, at a share ROOM less of the rate; the others
    are as in :class:`tuner.observers.lmi.FastestObserver`.
    """

    status: Status
    message: str
    alpha: float
    limit: float
    gain: np.ndarray
    slower: np.ndarray
    multipliers: np.ndarray
    needed: float
    solved: int


def search(design: Design, tolerance: float, bounds: np.ndarray) -> Ended:
    """Bisect for the largest rate at which t <= 1, and for the least one where t > 1 is proved.

    Args:
        design: with noise in every measurement, and errors in units of their bounds.
        tolerance: relative, of the rate.
        bounds: of the variances in the user's units, for error messages.

    Raises:
        ValueError: where no rate is admissible.
    """
    rates = Rates(design)
    low = _first(rates, bounds)
    rates.whiten(low)
    high = rates(2 * low.alpha)
    while high.admissible and high.alpha < _quickest(design):
        low, high = high, rates(2 * high.alpha)
    if high.admissible:
        return _ended(rates, high, None, tolerance)
    beyond = high
    while high.alpha - low.alpha > tolerance * high.alpha:
        middle = rates((low.alpha + high.alpha) / 2)
        if not middle.admissible and not middle.refused:
            rates.whiten(low)
            middle = rates(middle.alpha)
        low, high = (middle, high) if middle.admissible else (low, middle)
    return _ended(rates, low, _proof(rates, high, beyond, tolerance), tolerance)


def _proof(rates: Rates, high: Point, beyond: Point, tolerance: float) -> Point | None:
    """The least rate found, from one that is not admissible, where that is proved as well."""
    if high.refused:
        return high
    while not beyond.refused and beyond.alpha < _quickest(rates.design):
        beyond = rates(2 * beyond.alpha)
    if not beyond.refused:
        return None
    while beyond.alpha - high.alpha > tolerance * beyond.alpha:
        middle = rates((high.alpha + beyond.alpha) / 2)
        high, beyond = (high, middle) if middle.refused else (middle, beyond)
    return beyond


def _quickest(design: Design) -> float:
    """The rate that counts as infinite; in discrete time a sample leaves 1e-4 of an error."""
    return float(-np.log(1e-4)) if design.system.discrete else FASTEST


def _first(rates: Rates, bounds: np.ndarray) -> Point:
    """Some admissible rate, slowing down from one per unit of time.

    Raises:
        ValueError: where there is none, with the least variances.
    """
    alpha = 1.0
    for _ in range(12):
        point = rates(alpha)
        if point.admissible:
            return point
        alpha /= 4
    share = max(rates(0.0).needed, 0.0)
    there = f"{share:.6g} of that, {_listed(share * bounds)}" if share > 1 else "more"
    raise ValueError(
        f"no observer has the variances within {_listed(bounds)}: the least that can be reached "
        f"is {there}; allow more"
    )


def _listed(values: np.ndarray) -> str:
    return ", ".join(f"{value:.6g}" for value in values)


def _ended(rates: Rates, low: Point, high: Point | None, tolerance: float) -> Ended:
    limit = np.inf if high is None else high.alpha
    status, message = _verdict(rates, low.alpha, limit, tolerance)
    unit = rates.scaled.time
    return Ended(
        status=status,
        message=message,
        alpha=(np.inf if status is Status.UNBOUNDED else low.alpha) / unit,
        limit=limit / unit,
        gain=low.gain,
        slower=rates((1 - ROOM) * low.alpha).gain,
        multipliers=rates.multipliers(low),
        needed=np.nan if high is None else high.needed,
        solved=rates.solved,
    )


def _verdict(rates: Rates, alpha: float, limit: float, tolerance: float) -> tuple[Status, str]:
    share = (limit - alpha) / limit if np.isfinite(limit) else np.inf
    if alpha >= _quickest(rates.design):
        return Status.UNBOUNDED, EVERY
    if share <= 10 * tolerance:
        words = f"the rate is within {share:.1e} of one that the inequalities cannot reach"
        return Status.CONVERGED, words
    if np.isinf(limit):
        return Status.STALLED, "no rate is proved out of reach"
    words = f"between the rate and one proved out of reach lies {share:.1e} of it"
    return Status.STALLED, words
