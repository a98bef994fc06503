"""The local level's likelihood by plain NumPy, for many records at once; limits by its profile."""

from typing import NamedTuple

import numpy as np

QUANTILE = 3.841458820694124
"""95 % of chi-square with one degree of freedom."""
TINY = 1e-9


def contributions(z: np.ndarray, q: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Negative log-density of every sample but the first, ``(..., N - 1)``, nats.

    Args:
        z: records, ``(..., N)``.
        q, R: of each, ``(...)``.
    """
    x, P = np.broadcast_arrays(z[..., 0], q)[0].copy(), R + 0 * q
    found = np.empty((*x.shape, z.shape[-1] - 1))
    for k in range(1, z.shape[-1]):
        P = P + q
        s, y = P + R, z[..., k] - x
        found[..., k - 1] = (y**2 / s + np.log(s) + np.log(2 * np.pi)) / 2
        x, P = x + P / s * y, P * R / s
    return found


class Fitted(NamedTuple):
    """Maxima of likelihood of B records.

    Attributes:
        at: (ln q, ln R), ``(B, 2)``.
        nats: negative log-density there, ``(B,)``.
        hessian: of it, ``(B, 2, 2)``.
    """

    at: np.ndarray
    nats: np.ndarray
    hessian: np.ndarray


def fit(z: np.ndarray, start: np.ndarray, free: tuple[bool, bool] = (True, True)) -> Fitted:
    """Newton's method on B records ``(B, N)`` side by side, damped, from ``start`` ``(B, 2)``."""
    at, mask = np.array(start, float), np.array(free, float)
    nats, slope, hessian = _local(z, at)
    for _ in range(60):
        curved = hessian * np.outer(mask, mask) + np.diag(1 - mask)
        values, vectors = np.linalg.eigh(curved)
        values = np.maximum(np.abs(values), 1e-3)
        inner = np.einsum("bij,bi->bj", vectors, slope * mask)
        step = -np.einsum("bij,bj->bi", vectors, inner / values)
        step *= np.minimum(1, 1 / np.maximum(np.abs(step).max(axis=1), TINY))[:, None]
        for _ in range(6):
            worse = _nats(z, at + step) > nats + TINY
            step[worse] *= 0.3
        at = np.clip(at + step, -30, 30)
        nats, slope, hessian = _local(z, at)
        if np.abs(step).max() < 1e-7:
            break
    return Fitted(at, nats, hessian)


def covers(z: np.ndarray, fitted: Fitted, truth: np.ndarray) -> np.ndarray:
    """Whether the likelihood-ratio intervals of (ln q, ln R) contain the truth, ``(B, 2)``."""
    held = []
    for i in range(2):
        start = fitted.at.copy()
        start[:, i] = truth[i]
        free = (i != 0, i != 1)
        held.append(2 * (fit(z, start, free).nats - fitted.nats) <= QUANTILE)
    return np.stack(held, axis=1)


def sandwich(z: np.ndarray, fitted: Fitted, lags: int) -> np.ndarray:
    """Robust half-widths of (ln q, ln R), ``(B, 2)``, by Newey and West's estimate (1987)."""
    h = 1e-4
    each = []
    for i in range(2):
        step = h * np.eye(2)[i]
        each.append((_each(z, fitted.at + step) - _each(z, fitted.at - step)) / (2 * h))
    scores = np.stack(each, axis=-1)
    scores = scores - scores.mean(axis=1, keepdims=True)
    meat = np.einsum("bti,btj->bij", scores, scores)
    for lag in range(1, lags + 1):
        cross = np.einsum("bti,btj->bij", scores[:, lag:], scores[:, :-lag])
        meat += (1 - lag / (lags + 1)) * (cross + cross.transpose(0, 2, 1))
    inverse = np.linalg.inv(fitted.hessian)
    spread = inverse @ meat @ inverse
    return np.asarray(np.sqrt(QUANTILE * np.maximum(np.einsum("bii->bi", spread), 0)))


def limits(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Maximum (q, R) ``(2,)`` and profile limits ``(2, 2)`` of one record.

    The likelihood is laid out on a grid, each limit then found to six digits by scipy. One that
    the likelihood does not have is 0 or infinite.
    """
    from scipy.optimize import brentq, minimize, minimize_scalar

    def nats(point: np.ndarray) -> np.ndarray:
        return _nats(z, np.asarray(point))

    middle = np.log(np.var(np.diff(z)) / 2)
    axis = np.linspace(middle - 16, middle + 8, 97)
    surface = nats(np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1))
    low = np.unravel_index(surface.argmin(), surface.shape)
    options = {"xatol": 1e-9, "fatol": 1e-11}
    best = minimize(nats, axis[list(low)], method="Nelder-Mead", options=options)

    def rise(at: float, index: int) -> float:
        """Twice the least rise where one coordinate is ``at``, less the quantile."""
        own, others = (np.s_[..., index], np.s_[..., 1 - index])
        points = np.empty((len(axis), 2))
        points[own], points[others] = at, axis
        least = int(nats(points).argmin())

        def along(x: float) -> float:
            point = points[least].copy()
            point[others] = x
            return float(nats(point))

        around = axis[max(least - 1, 0)], axis[min(least + 1, len(axis) - 1)]
        ended = minimize_scalar(along, bounds=around, method="bounded", options={"xatol": 1e-7})
        return float(2 * (min(ended.fun, along(axis[least])) - best.fun) - QUANTILE)

    found = np.array([[0.0, np.inf], [0.0, np.inf]])
    for index in range(2):
        profile = surface.min(axis=1 - index)
        for side, sign in ((0, -1), (1, 1)):
            within = np.flatnonzero(2 * (profile - best.fun) <= QUANTILE)
            last = within.min() if side == 0 else within.max()
            # The profile between the points of the grid is lower than on them.
            ahead = [axis[i] for i in (last + sign, last + 2 * sign) if 0 <= i < len(axis)]
            outside = [at for at in ahead if rise(at, index) > 0]
            if outside:
                root = brentq(rise, axis[last], outside[0], args=(index,), xtol=1e-7)
                found[index, side] = np.exp(root)
    return np.exp(best.x), found


def _each(z: np.ndarray, at: np.ndarray) -> np.ndarray:
    return contributions(z, *np.exp(np.moveaxis(at, -1, 0)))


def _nats(z: np.ndarray, at: np.ndarray) -> np.ndarray:
    total: np.ndarray = _each(z, at).sum(axis=-1)
    return total


def _local(z: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Value, gradient and Hessian by differences, all records and points in one loop."""
    h = 1e-3
    steps = h * np.array([[i, j] for i in (-1, 0, 1) for j in (-1, 0, 1)])
    f = _nats(z[:, None], at[:, None] + steps).reshape(-1, 3, 3)
    slope = np.stack([f[:, 2, 1] - f[:, 0, 1], f[:, 1, 2] - f[:, 1, 0]], axis=1) / (2 * h)
    first, second = (
        f[:, 2, 1] - 2 * f[:, 1, 1] + f[:, 0, 1],
        f[:, 1, 2] - 2 * f[:, 1, 1] + f[:, 1, 0],
    )
    mixed = (f[:, 2, 2] - f[:, 2, 0] - f[:, 0, 2] + f[:, 0, 0]) / 4
    hessian = np.stack([first, mixed, mixed, second], axis=1).reshape(-1, 2, 2) / h**2
    return f[:, 1, 1], slope, hessian
