"""The dual simplex method, with corners that are kept for windows of the same t.

At a corner of the feasible set as many rows are tight as there are unknowns. Which rows those are
decides its multipliers, and what the tight sides make of every other row, whatever the samples: the
corners of a t are worked out once and kept. Those with multipliers that are not negative prove a
lower bound each; the highest bound is where the search starts, most often at the optimum itself.
For a t of which none is known it starts at the samples farthest from their least squares.
"""

from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import lapack

from tuner.regression.window import Regressors, Window, one

FEASIBLE = 1e-13
"""Tolerance of sides of size 1: a row violated by less is met, one with less slack is tight."""
CERTAIN = 1e-9
"""Multipliers below this share of the largest may be zero, and the optimum not unique."""
LARGEST = 1e9
"""Rows of size 1 whose inverse has larger entries are nearly dependent."""
FARTHER = 10.0
"""By so much residuals count more than places, in the choice of samples to start at."""
STEPS = 25
"""Corners in a row beyond which the interior-point method is faster."""
KEPT = 1 << 16
"""Entries of the shares that are kept for a t: 512 kB, 744 corners of ten samples on a line."""


class Corner(NamedTuple):
    """A vertex at which some rows are tight.

    Attributes:
        rows: which, ascending, as many as there are unknowns, ``(n,)``.
        inverse: of these rows, ``(n, n)``.
        shares: every row as a combination of these, ``(rows, n)``.
        multipliers: of these rows, that add up to the cost, none negative.
        bound: the same, 0 for the other rows, ``(rows,)``.
        certain: whether each is positive, so that there is no other optimum where this is one.
    """

    rows: np.ndarray
    inverse: np.ndarray
    shares: np.ndarray
    multipliers: list[float]
    bound: np.ndarray
    certain: bool

    def spare(self, sides: np.ndarray) -> np.ndarray:
        """The amount by which each row exceeds its side here, ``(rows,)``."""
        return np.asarray(self.shares @ sides.take(self.rows) - sides)


def _corner(of: Regressors, tight: tuple[int, ...]) -> Corner | None:
    rows = np.array(tight)
    # LAPACK itself, and lists of a few numbers: NumPy takes longer to call than to work.
    _, _, inverse, singular = lapack.dgesv(of.rows.take(rows, axis=0), one(len(rows)))
    if singular or not max(map(abs, inverse.ravel().tolist())) < LARGEST:
        return None
    multipliers = (of.cost @ inverse).tolist()
    least, tiny = min(multipliers), CERTAIN * max(map(abs, multipliers))
    if least < -tiny:
        return None
    multipliers = [max(multiplier, 0.0) for multiplier in multipliers]
    bound = np.zeros(len(of.rows))
    bound[rows] = multipliers
    return Corner(rows, inverse, of.rows @ inverse, multipliers, bound, least > tiny)


def _first(of: Regressors) -> Corner | None:
    """The corner that follows from t alone.

    Both rows of one sample j, with the largest multiplier w for which 2 w abs(t_j) stays below the
    cost. Rows of other samples, to determine the center, have the multiplier 0.
    """
    m = len(of.columns)
    # QR with pivots takes the longest, and then what is farthest from what is taken.
    _, order, *_ = lapack.dgeqp3(of.rows[:m, : of.rank].T)
    j, *others = (int(place) - 1 for place in order[: of.rank])
    return _tight(of, [j, m + j, *others], of.rows[j, of.rank :])


def _start(of: Regressors, values: np.ndarray) -> Corner | None:
    """A corner beside the samples farthest from their least squares; None where all are on it.

    As many samples as a center has coordinates, and one more, have weights that balance to 0 in
    every regressor: with these as multipliers, of rows above or below by sign, they prove a bound.
    """
    m, rank = len(values), of.rank
    basis = of.rows[:m, :rank]
    apart = values - basis @ (values @ basis) / m
    largest = max(map(abs, apart.tolist()))
    if not largest or m <= rank:
        return None
    both = np.empty((rank + 1, m))
    both[:rank], both[rank] = basis.T, apart * (FARTHER / largest)
    _, order, *_ = lapack.dgeqp3(both)
    samples = order[: rank + 1] - 1
    _, _, balanced, singular = lapack.dgesv(both.take(samples, axis=1), one(rank + 1)[:, rank])
    if singular:
        return None
    weights = balanced.tolist()
    rows = [j if w > 0 else m + j for j, w in zip(samples.tolist(), weights, strict=True)]
    return _tight(of, rows, np.abs(balanced) @ of.rows.take(samples, axis=0)[:, rank:])


def _tight(of: Regressors, rows: list[int], spread: np.ndarray) -> Corner | None:
    """The corner of samples' rows whose multipliers can grow until a spread costs nothing more.

    The bounds of the other spreads take what is left of their cost.
    """
    pairs = zip(of.cost[of.rank :].tolist(), spread.tolist(), strict=True)
    _, free = min((cost / size, i) for i, (cost, size) in enumerate(pairs) if size > 0)
    bounds = range(2 * len(of.columns), len(of.rows))
    return _corner(of, tuple(sorted([*rows, *bounds[:free], *bounds[free + 1 :]])))


class Corners:
    """The corners of one t that were visited."""

    def __init__(self, of: Regressors) -> None:
        self._of = of
        self._met: dict[tuple[int, ...], Corner | None] = {}
        self._found: list[Corner] = []
        # One value, replaced as a whole: a thread never sees half of it.
        self._starts: tuple[tuple[Corner, ...], np.ndarray] = ((), np.zeros((0, len(of.rows))))

    @cached_property
    def _first(self) -> Corner | None:
        """The corner that follows from t alone."""
        return _first(self._of)

    def at(self, rows: tuple[int, ...]) -> Corner | None:
        """The corner of these rows, ascending; None where they are dependent or prove nothing."""
        if rows in self._met:
            return self._met[rows]
        found = _corner(self._of, rows)
        if (len(self._found) + 1) * self._of.rows.size <= KEPT:
            self._met[rows] = found
            if found:
                self._found.append(found)
        return found

    def optimum(self, window: Window, steps: int = STEPS) -> Corner | None:
        """An optimal corner, whichever were visited before; None where it is not reached."""
        end, spare = self._end(self._best(window), window.sides, steps)
        if end and end.certain and np.count_nonzero(spare < FEASIBLE) == len(end.rows):
            return end
        # More rows are tight than needed, or other points as good: several corners are optimal.
        return self._end(self._first, window.sides, steps)[0]

    def _best(self, window: Window) -> Corner | None:
        """The visited corner with the highest bound; of a new t, one at the farthest samples."""
        if not self._found:
            return _start(self._of, window.values)
        corners, bounds = self._starts
        if len(corners) < len(self._found):
            new = self._found[len(corners) :]
            bounds = np.vstack([bounds, *(corner.bound for corner in new)])
            corners = (*corners, *new)
            self._starts = corners, bounds
        return corners[int((bounds @ window.sides).argmax())]

    def _end(
        self, at: Corner | None, sides: np.ndarray, steps: int
    ) -> tuple[Corner | None, np.ndarray]:
        """The end of the walk, and the slack of the rows there."""
        spare = sides
        for _ in range(steps):
            if at is None:
                break
            spare = at.spare(sides)
            worst = int(spare.argmin())
            if spare[worst] >= -FEASIBLE:
                return at, spare
            at = self._neighbour(at, worst)
        return None, spare

    def _neighbour(self, at: Corner, entering: int) -> Corner | None:
        """The neighbouring corner: one row enters, and the ratio test chooses which one leaves."""
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
    """The corners of a t."""
    return Corners(of)
