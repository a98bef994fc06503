"""Windows of a t met before: the dual simplex method from corner to corner.

At a corner of the feasible set as many rows are tight as there are unknowns. Which rows those are
decides its multipliers, and what the tight sides make of every other row, whatever the samples: the
corners of a t are worked out once and kept. Those with multipliers that are not negative prove a
lower bound each; the highest bound is where the search starts, most often at the optimum itself.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tuner.possibilistic.window import Regressors

FEASIBLE = 1e-13
"""Sides have the size 1: a row that is broken by less is held."""
CERTAIN = 1e-9
"""Less than this share of the largest may be zero: multipliers, and what a row has to spare."""
LARGEST = 1e9
"""Rows of the size 1 whose inverse has larger entries hardly differ."""
STEPS = 25
"""More corners than this one after the other, and the interior-point method is the faster one."""
KEPT = 1 << 16
"""Entries of the shares that are kept for a t: 512 kB, 744 corners of ten samples on a line."""


@dataclass(frozen=True, eq=False)
class Corner:
    """Where some rows are tight.

    Attributes:
        rows: which, ascending, as many as there are unknowns, ``(n,)``.
        inverse: of these rows, ``(n, n)``.
        shares: every row as a combination of these, ``(rows, n)``.
        multipliers: of these rows, that add up to the cost, none negative, ``(n,)``.
        bound: the same, 0 for the other rows, ``(rows,)``.
        certain: whether each is positive, so that there is no other optimum where this is one.
    """

    rows: np.ndarray
    inverse: np.ndarray
    shares: np.ndarray
    multipliers: list[float]
    bound: np.ndarray
    certain: bool


def _corner(of: Regressors, rows: np.ndarray) -> Corner | None:
    try:
        inverse = np.linalg.inv(of.rows[rows])
    except np.linalg.LinAlgError:
        return None
    multipliers = of.cost @ inverse
    tiny = CERTAIN * np.abs(multipliers).max()
    if not np.abs(inverse).max() < LARGEST or multipliers.min() < -tiny:
        return None
    certain = bool(multipliers.min() > tiny)
    multipliers = np.maximum(multipliers, 0.0)
    bound = np.zeros(len(of.rows))
    bound[rows] = multipliers
    return Corner(rows, inverse, of.rows @ inverse, multipliers.tolist(), bound, certain)


class Corners:
    """Those of one t that were met."""

    def __init__(self, of: Regressors) -> None:
        self._of = of
        self._met: dict[tuple[int, ...], Corner | None] = {}
        # One value, replaced as a whole: a thread never sees half of it.
        self._starts: tuple[tuple[Corner, ...], np.ndarray] = ((), np.zeros((0, len(of.rows))))

    def at(self, rows: tuple[int, ...]) -> Corner | None:
        """The corner of these rows, ascending; None where they hardly differ or prove nothing."""
        if rows in self._met:
            return self._met[rows]
        found = _corner(self._of, np.array(rows))
        corners, bounds = self._starts
        if (len(corners) + 1) * self._of.rows.size <= KEPT:
            self._met[rows] = found
            if found is not None:
                self._starts = (*corners, found), np.vstack([bounds, found.bound])
        return found

    def optimum(self, sides: np.ndarray) -> Corner | None:
        """The only optimum; None where none is found, or another or more tight rows may exist.

        So it has the only multipliers too: no answer depends on the windows met before.
        """
        corners, bounds = self._starts
        at = corners[int((bounds @ sides).argmax())] if corners else None
        for _ in range(STEPS):
            if at is None:
                return None
            broken = sides - at.shares @ sides[at.rows]
            worst = int(broken.argmax())
            if broken[worst] <= FEASIBLE:
                only = at.certain and np.count_nonzero(broken > -CERTAIN) == len(at.rows)
                return at if only else None
            at = self._beside(at, worst)
        return None

    def _beside(self, at: Corner, entering: int) -> Corner | None:
        """The corner with one more row tight, in place of that which keeps multipliers positive."""
        ratios = [
            (multiplier / share, place)
            for place, (multiplier, share) in enumerate(
                zip(at.multipliers, at.shares[entering].tolist(), strict=True)
            )
            if share > CERTAIN
        ]
        if not ratios:
            return None
        _, leaving = min(ratios)
        rows = at.rows.tolist()
        return self.at(tuple(sorted((*rows[:leaving], *rows[leaving + 1 :], entering))))


@lru_cache(maxsize=64)
def corners(of: Regressors) -> Corners:
    """Those of a t."""
    return Corners(of)
