"""Noise from the covariances of differences: autocovariance least squares, weighted."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tuner.identifiability.noise import Entry
from tuner.identifiability.windows import Differences

_ROUNDS = 12
_SETTLED = 1e-3  # a hundredth of such an estimate's accuracy
_HOLD = 1e-9  # weight that keeps undetermined entries where they were
_OUTLIER = 1e3  # squares this much beyond the median window's largest
_MEDIAN = 0.4549364231195724  # median of the square of a standard normal number


@dataclass(frozen=True, eq=False)
class Estimate:
    """Least-squares estimates of the noise parameters.

    Attributes:
        values: not negative, and covariances positive semi-definite, ``(p,)``.
        deviations: of them, if the noise is normal; infinite where nothing determines one.
    """

    values: np.ndarray
    deviations: np.ndarray


def alone(differences: Differences) -> tuple[np.ndarray, np.ndarray]:
    """Estimates of each noise parameter, each as if it caused all differences by itself.

    Returns:
        By the median of the differences' squares, which outliers do not move, and by their mean,
        ``(p,)`` each; NaN where a number leaves no trace, or all differences are 0.
    """
    r, M = differences.r, np.diagonal(differences.M[1:], axis1=2, axis2=3)
    medians, means = np.full(len(M), np.nan), np.full(len(M), np.nan)
    for i, each in enumerate(M):
        traced = each > 1e-9 * each.max(initial=0.0)
        ratios = r[traced] ** 2 / each[traced]
        if len(ratios) and ratios.any():
            means[i] = ratios.mean()
            medians[i] = np.median(ratios) / _MEDIAN or means[i]
    return medians, means


def estimate(differences: Differences, entries: tuple[Entry, ...]) -> Estimate:
    """The noise whose covariances of differences fit the measured ones, by weighted least squares.

    The least-squares problem r r' = sum of theta_i M_i is linear in theta. Its weights are those
    that normal noise of the theta before would have, so that its last round is a step of Fisher's
    scoring to the most likely theta of the windows. Source: Odelson, Rajamani and Rawlings, A new
    autocovariance least-squares method for estimating noise covariances, Automatica 42, 2006; the
    weights by iteration as in Rajamani and Rawlings, Automatica 45, 2009.
    """
    sizes, _ = alone(differences)
    sizes = np.where(np.isfinite(sizes) & (sizes > 0), sizes, 1.0)
    kinds = _kinds(*_without_outliers(differences, sizes), sizes)
    p = len(sizes)
    signed = np.array([len(set(e.place)) > 1 for e in entries])
    theta = np.where(signed, 0.0, 1.0 / p)
    for _ in range(_ROUNDS):
        F, b = _normal_equations(kinds, theta)
        D = np.sqrt(np.where(np.diag(F) > 0, np.diag(F), 1.0))
        F, b = F / np.outer(D, D) + _HOLD * np.eye(p), b / D + _HOLD * theta * D
        before, theta = theta, _with_signs(F, b, signed) / D
        theta = _semidefinite(theta, sizes, entries)
        if np.abs(theta - before).max() <= _SETTLED * np.abs(theta).max():
            break
    F, _ = _normal_equations(kinds, theta)
    return Estimate(theta * sizes, sizes * _deviations(F / 2))


def estimate_of_most(differences: Differences, entries: tuple[Entry, ...]) -> Estimate:
    """The noise of the better half of the windows, for records with outliers.

    The half whose differences the noise explains best is estimated, and all windows are judged
    anew by that, until the half stays: so what is wrong does not count, however wrong, while it is
    in less than half of the windows, and also where it is one long piece. The covariances are
    scaled so that the median window is as far out as that of a normal noise. Source: Rousseeuw and
    Van Driessen, A fast algorithm for the minimum covariance determinant estimator, Technometrics
    41(3), 1999 (concentration steps).
    """
    from tuner.distributions import chi_square_at

    sizes, _ = alone(differences)
    theta = np.where(np.isfinite(sizes) & (sizes > 0), sizes, 1.0) / len(sizes)
    usual = float(chi_square_at(0.5, differences.r.shape[1]))
    best: list[int] = []
    found, scale = Estimate(theta, np.full(len(theta), np.inf)), 1.0
    for _ in range(_ROUNDS):
        order = np.argsort(distances(differences, found.values * scale))
        half = sorted(order[: len(order) // 2 + 1].tolist())
        if half == best:
            break
        best = half
        found = estimate(differences.windows(half), entries)
        scale = float(np.median(distances(differences, found.values))) / usual
    return Estimate(found.values * scale, found.deviations * scale)


def distances(differences: Differences, theta: np.ndarray) -> np.ndarray:
    """Squares of how far each window's differences are out, in deviations of a noise, ``(K,)``."""
    r, M = differences.r[..., None], differences.M
    S = M[0] + np.einsum("p,pkij->kij", theta, M[1:])
    return np.asarray((r * np.linalg.solve(S, r)).sum(axis=(1, 2)))


def _without_outliers(differences: Differences, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The differences of windows without values far beyond those of the others."""
    r, M = differences.r, differences.M
    diagonals = np.diagonal(M, axis1=2, axis2=3)
    expected = diagonals[0] + np.einsum("p,pkd->kd", sizes, diagonals[1:])
    surprise = (r**2 / np.where(expected > 0, expected, np.inf)).max(axis=1)
    kept = surprise <= _OUTLIER * np.median(surprise)
    return r[kept], M[:, kept]


class _Kinds(NamedTuple):
    """Windows of U kinds, those of a kind with the same covariance.

    Attributes:
        counts: of each, ``(U,)``.
        squares: the sum of r r' over those of each, ``(U, d, d)``.
        known: the covariance of what is known of the noise, ``(U, d, d)``.
        unit: that of each unknown at its estimate alone, ``(p, U, d, d)``.
    """

    counts: np.ndarray
    squares: np.ndarray
    known: np.ndarray
    unit: np.ndarray


def _kinds(r: np.ndarray, M: np.ndarray, sizes: np.ndarray) -> _Kinds:
    found: dict[bytes, list[int]] = {}
    for k in range(len(r)):
        found.setdefault(M[:, k].tobytes(), []).append(k)
    first = [members[0] for members in found.values()]
    squares = np.stack([r[members].T @ r[members] for members in found.values()])
    counts = np.array([len(members) for members in found.values()])
    return _Kinds(counts, squares, M[0, first], M[1:, first] * sizes[:, None, None, None])


def _normal_equations(kinds: _Kinds, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """F theta = b of the weighted problem; F/2 is the Fisher information of theta."""
    counts, squares, known, M = kinds.counts[:, None, None], *kinds[1:]
    S = known + np.tensordot(theta, M, 1)
    # Where the previous noise explains nearly nothing, measured squares keep the weights finite.
    numbers = counts.sum() * S.shape[1]
    power = (_trace(squares) * 1e-12 + _trace(counts * S) * 1e-13) / numbers
    W = np.linalg.inv(S + power * np.eye(S.shape[1]))
    WM = W @ M
    F = _products(counts * WM, WM)
    return F, _products(WM, (W @ (squares - counts * known))[None])[:, 0]


def _trace(many: np.ndarray) -> float:
    """The sum of the traces of matrices ``(U, d, d)``."""
    return float(np.trace(many, axis1=1, axis2=2).sum())


def _products(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Traces of products, over all kinds: of ``(p, U, d, d)`` and ``(q, U, d, d)`` ``(p, q)``."""
    turned = np.swapaxes(B, 2, 3)
    return np.asarray(A.reshape(len(A), -1) @ turned.reshape(len(B), -1).T)


def _with_signs(F: np.ndarray, b: np.ndarray, signed: np.ndarray) -> np.ndarray:
    """The minimiser of x F x / 2 - b x in which only the signed entries may be negative."""
    from scipy.optimize import nnls

    values, V = np.linalg.eigh(F)
    root = np.sqrt(np.maximum(values, 1e-15 * values[-1]))
    A = (V * root).T
    both = np.hstack([A, -A[:, signed]])
    x, _ = nnls(both, (V.T @ b) / root)
    found: np.ndarray = x[: len(b)]
    found[signed] -= x[len(b) :]
    return found


def _semidefinite(theta: np.ndarray, sizes: np.ndarray, entries: tuple[Entry, ...]) -> np.ndarray:
    """The same with each covariance replaced by the nearest positive semi-definite one."""
    theta = theta.copy()
    names = dict.fromkeys(e.parameter for e in entries if len(e.place) == 2)
    for name in names:
        mine = [i for i, e in enumerate(entries) if e.parameter == name]
        n = 1 + max(max(entries[i].place) for i in mine)
        P = np.zeros((n, n))
        for i in mine:
            a, b = entries[i].place
            P[a, b] = P[b, a] = theta[i] * sizes[i]
        scale = np.sqrt(np.where(np.diag(P) > 0, np.diag(P), 1.0))
        values, V = np.linalg.eigh(P / np.outer(scale, scale))
        if values[0] < 0:
            P = (V * np.maximum(values, 0.0)) @ V.T * np.outer(scale, scale)
        for i in mine:
            theta[i] = P[entries[i].place] / sizes[i]
    return theta


def _deviations(information: np.ndarray) -> np.ndarray:
    D = np.sqrt(np.diag(information))
    silent = D == 0
    D = np.where(silent, 1.0, D)
    values, V = np.linalg.eigh(information / np.outer(D, D))
    lost = values < 1e-12 * values[-1]
    spread = (V**2 / np.where(lost, np.inf, values)).sum(axis=1)
    open_ = silent | ((V[:, lost] ** 2).sum(axis=1) > 1e-9)
    return np.where(open_, np.inf, np.sqrt(spread) / D)
