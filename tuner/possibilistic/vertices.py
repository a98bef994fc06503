"""The dual of the regression, whose vertices know the times alone.

With s = (1 - h) c the dual of Tanaka's program is

    maximise   sum_j (u_j - v_j) x_j + (1 - h) (u_j + v_j) e_j
    subject to sum_j (u_j - v_j) T_j = 0, sum_j (u_j + v_j) abs(T_j) + w = sum_j abs(T_j),

with u, v, w >= 0 and rows T_j = (1, t_j1, .., t_jk). Its vertices are found once for given times; a
window then takes a product with them, and its solution is linear in the window's values.
"""

from itertools import combinations
from math import comb
from typing import NamedTuple

import numpy as np

MOST = 300_000
"""Bases that are tried at most: 21 times for one regressor."""
_ZERO = 1e-9  # a multiplier below this, of columns whose largest entry is 1, is none


class Vertices(NamedTuple):
    """The vertices of the dual for given times, V of them; m times, n = k + 1 columns.

    Attributes:
        difference: u - v, ``(V, m)``.
        total: u + v, ``(V, m)``.
        by_x: (p, s) from the centres where the vertex is the best, ``(V, 2n, m)``.
        by_e: the same from (1 - h) times the spreads, ``(V, 2n, m)``.
        sharp: so many come first that have 2n positive multipliers: where one of these is the
            best, the solution is unique.
    """

    difference: np.ndarray
    total: np.ndarray
    by_x: np.ndarray
    by_e: np.ndarray
    sharp: int

    @property
    def decided(self) -> bool:
        """Whether all windows have one solution, but for ties among their own values."""
        return bool((np.abs(self.difference[self.sharp :]) < _ZERO).all())


def bases(samples: int, columns: int) -> int:
    """How many bases :func:`dual_vertices` would try."""
    return comb(2 * samples + columns, 2 * columns)


def dual_vertices(T: np.ndarray) -> Vertices:
    """All vertices of the dual, by trying every basis.

    Args:
        T: rows (1, t_j1, .., t_jk), ``(m, n)``, of rank n, without a column of zeros.

    Raises:
        ValueError: where there are more than :data:`MOST` bases.

    >>> vertices = dual_vertices(np.stack([np.ones(6), np.arange(6.0)], axis=1))
    >>> vertices.sharp, vertices.decided
    (121, True)
    """
    m, n = T.shape
    if bases(m, n) > MOST:
        raise ValueError(
            f"{m} times and {n} columns have {bases(m, n)} bases, more than {MOST}; solve such "
            "windows one by one"
        )
    scale = np.abs(T).max(axis=0)
    rows = np.vstack([constraint_rows(T / scale), np.eye(2 * n)[n:]])
    cost = np.concatenate([np.zeros(n), np.abs(T / scale).sum(axis=0)])
    chosen = np.array(list(combinations(range(len(rows)), 2 * n)))
    regular = np.abs(np.linalg.det(rows[chosen])) > _ZERO
    chosen = chosen[regular]
    inverse = np.linalg.inv(rows[chosen])
    y = cost @ inverse
    kept, sharp = _once(chosen, y, len(rows))
    chosen, y, inverse = chosen[kept], y[kept], inverse[kept]
    each = _spread_out(y, chosen, len(rows))
    by = _spread_out(inverse, chosen[:, None], len(rows)) / np.tile(scale, 2)[:, None]
    u, v, by_u, by_v = each[:, :m], each[:, m : 2 * m], by[..., :m], by[..., m : 2 * m]
    return Vertices(u - v, u + v, by_u - by_v, by_u + by_v, sharp)


def constraint_rows(T: np.ndarray) -> np.ndarray:
    """What has to be at least (x + e', e' - x), with e' = (1 - h) e, of (p, s): ``(2m, 2n)``."""
    return np.block([[T, np.abs(T)], [-T, np.abs(T)]])


def _spread_out(values: np.ndarray, chosen: np.ndarray, rows: int) -> np.ndarray:
    """Values of the chosen rows in the last axis, among zeros for all rows."""
    whole = np.zeros((*values.shape[:-1], rows))
    np.put_along_axis(whole, np.broadcast_to(chosen, values.shape), values, axis=-1)
    return whole


def _once(chosen: np.ndarray, y: np.ndarray, rows: int) -> tuple[np.ndarray, int]:
    """Indices of bases without negative multipliers, one for each vertex; how many are sharp."""
    found = np.flatnonzero((y > -_ZERO).all(axis=1))
    whole = _spread_out(y[found], chosen[found], rows)
    _, first = np.unique(whole.round(9), axis=0, return_index=True)
    kept = found[first]
    sharp = (y[kept] > _ZERO).all(axis=1)
    return np.concatenate([kept[sharp], kept[~sharp]]), int(sharp.sum())
