"""One window solved to full precision: by the simplex method, or from an interior point.

A corner with positive multipliers is the only optimum. Where there may be others, an interior-point
method ends in the middle of the set of optima, where every constraint is either tight on the whole
set, with a positive multiplier, or slack (Goldman and Tucker 1956). The tight ones, as equations,
are that set's affine hull: a point where it is unique. Where it is not, least squares choose one,
by a least-distance programme (Lawson and Hanson 1974, ch. 23).
"""

from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from tuner.regression.corners import Corner, corners
from tuner.regression.window import Window

TOLERANCES = (1e-8, 1e-12)
"""Clarabel's tolerances, the second where the first does not tell tight from slack."""
PATIENT = 2000
"""Number of corners that are tried where the interior-point method fails too."""
EXACT = 1e-10
"""Largest violation and gap of an accepted point; scaled data have size 1."""
ROUNDED = 1e-13
_RANK = 1e-9


@dataclass(frozen=True, eq=False)
class Point:
    """An optimum in a window's scaled coordinates.

    Attributes:
        z: (coordinates of the center, (1 - h) times the used spreads).
        multipliers: of the rows, not negative.
        unique: whether there is no other optimum with these coordinates; None if that is not known.
        cost: what is minimised, of z.
        violation: the largest violation of a row by z.
        gap: cost of z less what the multipliers prove.
    """

    z: np.ndarray
    multipliers: np.ndarray
    unique: bool | None
    cost: float
    violation: float
    gap: float

    @property
    def error(self) -> float:
        """The larger of violation and gap."""
        return max(self.violation, abs(self.gap))


def solve(window: Window) -> Point:
    """The optimum of a window, and of several the one nearest the data.

    Raises:
        ArithmeticError: where neither method converged.
    """
    corner = corners(window.of).optimum(window)
    point = _at(window, corner) if corner and corner.certain else None
    if point and point.error <= EXACT:
        return point
    with suppress(ArithmeticError):
        for tolerance in TOLERANCES:
            point = _refined(window, *interior_point(window, tolerance))
            if point.error <= EXACT:
                return point
    corner = corner or corners(window.of).optimum(window, PATIENT)
    if corner:
        return _at(window, corner)
    if point is None:
        raise ArithmeticError("neither corners nor an interior point lead to the optimum")
    return point


def _at(window: Window, corner: Corner) -> Point:
    z = corner.inverse @ window.sides.take(corner.rows)
    return _proved(window, z, corner.bound, True if corner.certain else None)


def _proved(window: Window, z: np.ndarray, multipliers: np.ndarray, unique: bool | None) -> Point:
    violation = float((window.sides - window.of.rows @ z).max())
    cost = float(window.of.cost @ z)
    gap = cost - float(window.sides @ multipliers)
    return Point(z, multipliers, unique, cost, violation, gap)


def interior_point(window: Window, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """The interior-point method's result, in the middle of the optima: z and the multipliers."""
    import clarabel

    of = window.of
    cones = [clarabel.NonnegativeConeT(len(of.rows))]
    found = clarabel.DefaultSolver(
        _zeros(len(of.cost)), of.cost, of.matrix, -window.sides, cones, _settings(tolerance)
    ).solve()
    if str(found.status) not in ("Solved", "AlmostSolved", "InsufficientProgress"):
        raise ArithmeticError(f"the interior-point method ended as {found.status}")
    return np.array(found.x), np.array(found.z)


@cache
def _settings(tolerance: float) -> Any:
    import clarabel

    settings = clarabel.DefaultSettings()
    settings.verbose = settings.presolve_enable = settings.equilibrate_enable = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
    return settings


@cache
def _zeros(size: int) -> Any:
    from scipy.sparse import csc_matrix

    return csc_matrix((size, size))


def _refined(window: Window, z: np.ndarray, y: np.ndarray) -> Point:
    """The exact optimum from a point nearby."""
    G, b, cost = window.of.rows, window.sides, window.of.cost
    tight = y > G @ z - b
    rows, sides = G[tight], b[tight]
    as_many = len(rows) == len(z)  # as is usual
    if as_many and (corner := corners(window.of).at(tuple(np.flatnonzero(tight).tolist()))):
        return _at(window, corner)
    # The least step to the tight rows' solutions keeps to the middle of the face.
    step, _, rank, _ = np.linalg.lstsq(rows, sides - rows @ z, rcond=_RANK)
    unique = bool(rank == len(z))
    z = z + step if unique else _nearest(window, z + step, tight)
    mend, *_ = np.linalg.lstsq(rows.T, cost - rows.T @ y[tight], rcond=_RANK)
    multipliers = np.zeros(len(b))
    multipliers[tight] = np.maximum(y[tight] + mend, 0.0)
    return _proved(window, z, multipliers, unique)


def _nearest(window: Window, z: np.ndarray, tight: np.ndarray) -> np.ndarray:
    """The optimum with the least sum of squared residuals and (1 - h) c, in the user's scale.

    Of z + N a on the face and above the slack rows it is the one whose E a is nearest f: in
    coordinates in which E is orthogonal, the point of a polyhedron nearest the origin.
    """
    of = window.of
    _, singular, right = np.linalg.svd(of.rows[tight])
    N = right[int((singular > _RANK * singular[0]).sum()) :].T
    # Weights are as large as the units are small: what rounding left of a zero would count.
    N[np.abs(N) < ROUNDED] = 0.0
    weights = np.diag(1 / of.scale[of.used])
    fits = of.columns @ of.basis
    none = np.zeros((len(fits), len(weights)))
    M = np.block([[fits, none], [np.zeros((len(weights), of.rank)), weights]])
    f = np.concatenate([window.values, np.zeros(len(weights))]) - M @ z
    Q, R = np.linalg.qr(M @ N)
    slack = of.rows[~tight]
    C = slack @ N @ np.linalg.inv(R)
    w = _least_distance(C, window.sides[~tight] - slack @ z - C @ (Q.T @ f))
    return np.asarray(z + N @ np.linalg.solve(R, w + Q.T @ f))


def _least_distance(C: np.ndarray, d: np.ndarray) -> np.ndarray:
    """The shortest w with C w >= d, which is unique."""
    from scipy.optimize import nnls

    if not len(C):
        return np.zeros(C.shape[1])
    goal = np.zeros(C.shape[1] + 1)
    goal[-1] = 1.0
    E = np.vstack([C.T, d])
    residual = E @ nnls(E, goal)[0] - goal
    if not residual[-1]:
        raise ArithmeticError("no point of the face is above the slack rows")
    return np.asarray(-residual[:-1] / residual[-1])
