"""One window of samples for the regression: checked, and scaled so that no size matters."""

from copy import copy
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from math import isfinite, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import lapack

TINY = 1e-290
"""Smaller sizes cost neighbouring numbers most of their digits."""
_RANK = 1e-11
"""Singular values below this share of the largest count as zero."""


@dataclass(frozen=True, eq=False)
class Regressors:
    """Quantities that depend on t alone: m samples of k regressors, n = k + 1 columns.

    The program's unknowns z are the center's coordinates, as many as the rank of t, and (1 - h)
    times the spreads of the columns that are not zero throughout.

    Attributes:
        columns: rows (1, t_j1, .., t_jk), each column scaled to a largest entry of 1, ``(m, n)``.
        scale: of the columns, ``(n,)``; 1 for one of zeros.
        used: which columns are not zero throughout, ``(n,)`` of bool.
        basis: coordinates of the centers that the samples can tell apart, ``(n, rank)``: their
            values at the samples are orthogonal, with a root mean square of 1.
        restore: from z to the shortest center and the spread in the user's scale,
            ``(2n, rank + used)``.
        level: the shortest center of a constant 1, ``(n,)``.
        rows: coefficients of the constraints rows z >= sides, ``(2m + used, rank + used)``.
        cost: coefficients of z in the cost.
    """

    columns: np.ndarray
    scale: np.ndarray
    used: np.ndarray
    basis: np.ndarray
    restore: np.ndarray
    level: np.ndarray
    rows: np.ndarray
    cost: np.ndarray

    @cached_property
    def matrix(self) -> Any:
        """The negative rows as Clarabel takes them."""
        # SciPy's checks of a new matrix take as long as all else here.
        made = copy(_ones(self.rows.shape))
        made.data = -self.rows.ravel(order="F")
        return made

    @property
    def rank(self) -> int:
        """Number of coordinates of the center that the samples determine."""
        return int(self.basis.shape[1])


@dataclass(frozen=True, eq=False)
class Window:
    """m samples; values are scaled to a half range of 1 about 0.

    Attributes:
        of: the regressors.
        values: scaled centres, ``(m,)``.
        spreads: (1 - h) times the scaled spreads, ``(m,)``.
        h: degree to which samples have to belong to the regression.
        middle, size: of the values.
        sides: lower bounds of the rows.
    """

    of: Regressors
    values: np.ndarray
    spreads: np.ndarray
    h: float
    middle: float
    size: float
    sides: np.ndarray

    def restored(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The shortest center that fits, and the spread, in the user's scale."""
        both, n = self.size * (self.of.restore @ z), len(self.of.scale)
        return both[:n] + self.middle * self.of.level, np.maximum(both[n:], 0.0) / (1 - self.h)


def window(t: ArrayLike, x: ArrayLike, h: float, e: ArrayLike | None) -> Window:
    """Check and scale.

    Raises:
        ValueError: for an empty window, shapes that do not fit, numbers that are not finite,
            spreads below 0, or an h outside 0 to below 1.
    """
    t, x = np.asarray(t, float), np.asarray(x, float)
    spreads = np.zeros(x.shape) if e is None else np.asarray(e, float)
    check_degree(h)
    if x.ndim != 1 or t.ndim not in (1, 2) or len(t) != len(x) or spreads.shape != x.shape:
        raise ValueError(
            f"t has the shape {t.shape}, x {x.shape} and e {spreads.shape}; m samples of k "
            "regressors are (m,) or (m, k), and (m,)"
        )
    if not len(x):
        raise ValueError("the window is empty; give at least one sample")
    low, high = _range(x, None if e is None else spreads)
    size, middle = high / 2 - low / 2 or 1.0, low / 2 + high / 2
    if size < TINY:
        raise ValueError(f"x and e span {high - low:g} only; give them in a smaller unit")
    of = _regressors(t.tobytes(), t.shape)
    values, spreads = (x - middle) / size, (1 - h) * (spreads / size)
    none = np.zeros(len(of.cost) - of.rank)
    sides = np.concatenate([spreads + values, spreads - values, none])
    return Window(of, values, spreads, float(h), middle, size, sides)


def _range(x: np.ndarray, e: np.ndarray | None) -> tuple[float, float]:
    """The least and the largest sample, with its spread."""
    low = high = x
    if e is not None:
        with np.errstate(over="ignore"):  # said below
            low, high = x - e, x + e
    ends = float(low.min()), float(high.max())
    if not (isfinite(ends[0]) and isfinite(ends[1])):
        _finite("x", x)
        _finite("e", x if e is None else e)
        raise ValueError("x and e together are larger than any number; give them in a larger unit")
    if e is not None and e.min() < 0:
        raise ValueError(f"a spread e is {e.min():g} at {e.argmin()}; none is below 0")
    return ends


def check_degree(h: float) -> None:
    """Refuse an h outside its range.

    Raises:
        ValueError: for an h outside 0 to below 1.
    """
    if not 0 <= h < 1:
        raise ValueError(f"h must be at least 0 and below 1, where spreads are infinite; got {h:g}")


@lru_cache(maxsize=64)
def _regressors(t: bytes, shape: tuple[int, ...]) -> Regressors:
    given = _finite("t", np.frombuffer(t).reshape(shape)).reshape(shape[0], -1)
    m, n = len(given), given.shape[1] + 1
    columns = np.ones((m, n))
    columns[:, 1:] = given
    size = np.abs(columns)
    scale = size.max(axis=0)
    used = scale > 0
    scale[~used] = 1.0
    least = min(scale.tolist())
    if least < TINY:
        raise ValueError(f"a regressor is {least:g} at most; give t in a smaller unit")
    columns /= scale
    size /= scale
    # LAPACK itself: NumPy takes longer to call than to work.
    _, singular, right, failed = lapack.dgesdd(columns, full_matrices=m < n)
    if failed:
        raise ArithmeticError("the singular values of t are not found")
    rank = sum(value > _RANK * singular[0] for value in singular.tolist())
    basis = right[:rank].T * (sqrt(m) / singular[:rank])
    spread, shortest = size[:, used], one(n)
    cost = np.zeros(rank + spread.shape[1])
    cost[rank:] = spread.sum(axis=0)
    if rank < n:
        # No sample shows changes of the center along these, so the shortest center has none.
        unseen = np.linalg.qr(right[rank:].T / scale[:, None])[0]
        shortest = one(n) - unseen @ unseen.T
    return Regressors(
        columns=columns,
        scale=scale,
        used=used,
        basis=basis,
        restore=_block_diagonal(shortest @ (basis / scale[:, None]), (one(n) / scale)[:, used]),
        level=shortest[:, 0].copy(),
        rows=_rows(columns @ basis, spread),
        cost=cost,
    )


@cache
def one(size: int) -> np.ndarray:
    """The identity, read-only."""
    made = np.eye(size)
    made.flags.writeable = False
    return made


def _rows(center: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Rows of (x + e', e' - x, 0), with e' = (1 - h) e, as linear functions of z."""
    (m, rank), used = center.shape, spread.shape[1]
    rows = np.zeros((2 * m + used, rank + used))
    rows[:m, :rank], rows[m : 2 * m, :rank] = center, -center
    rows[:m, rank:] = rows[m : 2 * m, rank:] = spread
    rows[2 * m :, rank:] = one(used)
    return rows


def _block_diagonal(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """The block diagonal matrix of two."""
    (m, n), (p, q) = A.shape, B.shape
    both = np.zeros((m + p, n + q))
    both[:m, :n], both[m:, n:] = A, B
    return both


@lru_cache(maxsize=64)
def _ones(shape: tuple[int, int]) -> Any:
    """All entries are kept, zeros too."""
    from scipy.sparse import csc_matrix

    return csc_matrix(np.ones(shape))


def _finite(name: str, values: ArrayLike) -> np.ndarray:
    array = np.asarray(values, float)
    if not np.isfinite(array).all():
        at = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        where = at[0] if len(at) == 1 else at
        raise ValueError(f"{name} is {array[at]} at {where}; leave the sample out")
    return array
