"""Delays of gyroscopes and accelerometers against the optical truth.

Both come with the same times. What both are late may be the truth's clock; what the gyroscopes are
later than the accelerometers is the sensor's.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from studies.broad.trials import GRAVITY, Trial

SMOOTH = 0.02
"""Deviation of the Gaussian that smooths all signals, s: a second derivative is noisy."""
CLEAR = 6
"""Least distance of a counted sample from a gap of the truth, in these deviations."""
LATEST = 0.02
"""Largest delay of the search, s."""
FEWEST = 200
"""The fewest samples that have to count."""


class Late(NamedTuple):
    """Delays of a trial's sensors against the truth, s; NaN where they are not determined."""

    gyroscopes: float
    accelerometers: float


def late(trial: Trial) -> Late:
    """The shifts that fit rate and force to the truth, up to a constant matrix and a bias.

    The force takes the truth's places twice differentiated; the arm from the optical markers to the
    accelerometers, whose turning pushes them, is fitted along.
    """
    step = 1 / trial.rate_hz
    width = SMOOTH / step
    seen = ~np.isnan(trial.truth).any(axis=1)
    if trial.place is not None:
        seen &= ~np.isnan(trial.place).any(axis=1)
    at = _away_from_gaps(seen, int(np.ceil(CLEAR * width)))
    if len(at) < FEWEST:
        return Late(np.nan, np.nan)
    every = max(int(width / 2), 1)  # smoothed neighbours are redundant
    at = at[::every]

    def smooth(values: np.ndarray) -> np.ndarray:
        return np.asarray(gaussian_filter1d(values, width, axis=0))

    turn = smooth(_interpolated(_one_sign(trial.truth, seen), seen))
    turn /= np.linalg.norm(turn, axis=1, keepdims=True)
    rate = _rate(turn, step)
    known = np.concatenate([rate, np.ones((len(rate), 1))], axis=1)[at]
    by_axis = np.kron(np.eye(3), known).reshape(3, len(at), 12)
    t = step * np.arange(len(turn))
    gyroscopes = _delay(CubicSpline(t, smooth(trial.rate)), t[at], by_axis)
    if trial.place is None:
        return Late(gyroscopes, np.nan)
    speed = np.gradient(smooth(_interpolated(trial.place, seen)), step, axis=0)
    push = np.gradient(speed, step, axis=0) + np.array([0.0, 0.0, GRAVITY])
    force = Rotation.from_quat(turn, scalar_first=True).inv().apply(push)
    columns = _regressors(force[at], _arm(rate, step)[at])
    return Late(gyroscopes, _delay(CubicSpline(t, smooth(trial.acceleration)), t[at], columns))


def _away_from_gaps(seen: np.ndarray, margin: int) -> np.ndarray:
    """Samples that are known with all their neighbours up to a margin."""
    unknown = np.array([0, *np.cumsum(~seen)])
    at = np.arange(margin, len(seen) - margin)
    clear: np.ndarray = at[unknown[at + margin + 1] == unknown[at - margin]]
    return clear


def _one_sign(q: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Quaternions without sign changes, where they are known."""
    found = q.copy()
    known = q[seen]
    same = np.where((known[1:] * known[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    found[seen] = known * np.concatenate([[1.0], np.cumprod(same)])[:, None]
    return found


def _interpolated(values: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Values interpolated over the gaps, which do not count."""
    at = np.flatnonzero(seen)
    whole = np.arange(len(values))
    return np.stack([np.interp(whole, at, column[at]) for column in values.T], axis=1)


def _rate(q: np.ndarray, step: float) -> np.ndarray:
    """Angular rate in the sensor's axes, rad/s, ``(N, 3)``: 2 q* dq/dt."""
    w, v = q[:, :1], q[:, 1:]
    slope = np.gradient(q, step, axis=0)
    return np.asarray(2 * (w * slope[:, 1:] - slope[:, :1] * v - np.cross(v, slope[:, 1:])))


def _arm(rate: np.ndarray, step: float) -> np.ndarray:
    """Factor of a point's acceleration by its position on the body, ``(N, 3, 3)``: A + W W."""
    spin = _skew(rate)
    return np.asarray(_skew(np.gradient(rate, step, axis=0)) + spin @ spin)


def _skew(v: np.ndarray) -> np.ndarray:
    x, y, z = v.T
    o = np.zeros(len(v))
    return np.array([[o, -z, y], [z, o, -x], [-y, x, o]]).transpose(2, 0, 1)


def _regressors(force: np.ndarray, arm: np.ndarray) -> np.ndarray:
    """Regressors of a reading, ``(3, n, 15)``: each axis' matrix and bias, and an arm."""
    known = np.concatenate([force, np.ones((len(force), 1))], axis=1)
    own = np.kron(np.eye(3), known).reshape(3, len(force), 12)
    return np.concatenate([own, arm.transpose(1, 0, 2)], axis=2)


def _delay(
    reading: Callable[[np.ndarray], np.ndarray], t: np.ndarray, columns: np.ndarray
) -> float:
    """The delay of a reading: the shift at which columns ``(3, n, m)`` fit it best, s."""
    basis = np.linalg.qr(columns.reshape(-1, columns.shape[-1]))[0]

    def left(delay: float) -> float:
        y = reading(t + delay).T.ravel()
        return float(y @ y - (basis.T @ y) @ (basis.T @ y))

    return float(minimize_scalar(left, bounds=(-LATEST, LATEST), method="bounded").x)
