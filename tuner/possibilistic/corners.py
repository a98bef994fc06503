"""The dual simplex method from corner to corner, which are kept for windows of the same t.

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
"""Sides have the size 1: a row that is broken by less is held, one with less to spare tight."""
CERTAIN = 1e-9
"""Multipliers below this share of the largest may be zero, where the optimum is not unique."""
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

    @property
    def n(self) -> int:
        """How many unknowns there are."""
        return len(self.rows)

    def spare(self, sides: np.ndarray) -> np.ndarray:
        """What every row is above its side here, ``(rows,)``."""
        return np.asarray(self.shares @ sides[self.rows] - sides)


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


def _first(of: Regressors) -> np.ndarray:
    """Rows whose multipliers are not negative, found from t alone.

    Both rows of one sample j, with the largest multiplier w for which 2 w abs(t_j) stays below the
    cost; then one spread costs nothing more, and the bounds of the others take what is left. Rows
    of other samples, to determine the center, have the multiplier 0.
    """
    rank, m = of.rank, len(of.columns)
    left = of.rows[:m, :rank].copy()
    samples = []
    for _ in range(rank):
        j = int((left**2).sum(axis=1).argmax())
        samples.append(j)
        direction = left[j] / np.linalg.norm(left[j])
        left -= np.outer(left @ direction, direction)
    size = of.rows[samples[0], rank:]
    free = int(
        np.argmin(np.divide(of.cost[rank:], size, np.full(len(size), np.inf), where=size > 0))
    )
    least = [2 * m + i for i in range(len(size)) if i != free]
    return np.array(sorted([*samples, m + samples[0], *least]))


class Corners:
    """Those of one t that were met."""

    def __init__(self, of: Regressors) -> None:
        self._of = of
        self._met: dict[tuple[int, ...], Corner | None] = {}
        # One value, replaced as a whole: a thread never sees half of it.
        self._starts: tuple[tuple[Corner, ...], np.ndarray] = ((), np.zeros((0, len(of.rows))))
        first = _corner(of, _first(of))
        if first:
            self._starts = (first,), first.bound[None]

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

    def optimum(self, sides: np.ndarray, steps: int = STEPS) -> Corner | None:
        """An optimal corner, the same whatever was met before; None where it is not reached."""
        corners, bounds = self._starts
        best = corners[int((bounds @ sides).argmax())] if corners else None
        end = self._end(best, sides, steps)
        if end is None or (end.certain and np.count_nonzero(end.spare(sides) < FEASIBLE) == end.n):
            return end
        # More rows are tight than needed, or other points as good: several corners are optimal.
        return self._end(corners[0], sides, steps)

    def _end(self, at: Corner | None, sides: np.ndarray, steps: int) -> Corner | None:
        for _ in range(steps):
            if at is None:
                return None
            spare = at.spare(sides)
            worst = int(spare.argmin())
            if spare[worst] >= -FEASIBLE:
                return at
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
