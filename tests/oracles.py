"""Textbook loops in plain NumPy and mpmath, written for reading: nothing here uses the project.

Every function takes and gives NumPy arrays (or mpmath numbers) and shares no code with what it
checks: linear solves where the filters have none, loops where they have a scan.
"""

from fractions import Fraction
from typing import NamedTuple

import mpmath
import numpy as np


class Model(NamedTuple):
    """x' = F x + w with cov w = W per sample, z = H x + v with cov v = R, x0 known to P0."""

    F: np.ndarray
    W: np.ndarray
    H: np.ndarray
    R: np.ndarray
    P0: np.ndarray
    x0: np.ndarray


class Run(NamedTuple):
    """A filter's estimates after each sample, time first."""

    x: np.ndarray
    P: np.ndarray


def kalman_predict(x, P, F, W):
    """x = F x, P = F P F' + W."""
    return F @ x, F @ P @ F.T + W


def kalman_update(x, P, H, R, z):
    """All measurements at once, by a solve, with Joseph's covariance; rows with NaN are dropped."""
    seen = ~np.isnan(z).reshape(len(z), -1).any(axis=1)
    if not seen.any():
        return x, P
    H, R, z = H[seen], R[np.ix_(seen, seen)], z[seen]
    K = np.linalg.solve(H @ P @ H.T + R, H @ P).T
    keep = np.eye(len(P)) - K @ H
    return x + K @ (z - H @ x), keep @ P @ keep.T + K @ R @ K.T


def linear_kalman(model, zs, pushes=None):
    """The Kalman filter; the model's F and W are one matrix or one a sample, pushes is B u."""
    N, n = len(zs), len(model.P0)
    F, W = np.broadcast_to(model.F, (N, n, n)), np.broadcast_to(model.W, (N, n, n))
    x, P, xs, Ps = model.x0, model.P0, [], []
    for k in range(N):
        x, P = kalman_predict(x, P, F[k], W[k])
        if pushes is not None:
            x = x + pushes[k]
        x, P = kalman_update(x, P, model.H, model.R, zs[k])
        xs.append(x)
        Ps.append(P)
    return Run(np.array(xs), np.array(Ps))


def kalman_nats(model, zs, pushes=None):
    """Minus the logarithm of the density of all measurements, by joint innovations."""
    x, P, nats = model.x0, model.P0, 0.0
    for k, z in enumerate(zs):
        x, P = kalman_predict(x, P, model.F, model.W)
        if pushes is not None:
            x = x + pushes[k]
        seen = ~np.isnan(z)
        H, R = model.H[seen], model.R[np.ix_(seen, seen)]
        if seen.any():
            S = H @ P @ H.T + R
            nats += (surprise(z[seen] - H @ x, S) + seen.sum() * np.log(2 * np.pi)) / 2
        x, P = kalman_update(x, P, model.H, model.R, z)
    return nats


def conditional_mean(model, zs):
    """The last state and its covariance given all measurements, from their joint distribution.

    No recursion on a covariance of errors: the covariance of all states is written down, and
    the last one is conditioned on z_1..z_N in a single solve (Bayesian least squares).
    """
    F, W, H, R, P0, x0 = model
    N, n, m = len(zs), len(x0), len(H)
    power = [np.linalg.matrix_power(F, k) for k in range(N + 1)]
    states = np.zeros((N, n, N, n))
    for i in range(N):
        for j in range(N):
            start = power[i + 1] @ P0 @ power[j + 1].T
            noise = [power[i - k] @ W @ power[j - k].T for k in range(min(i, j) + 1)]
            states[i, :, j] = start + sum(noise)
    joint = np.einsum("ax,ixjy,by->iajb", H, states, H).reshape(N * m, N * m)
    joint += np.kron(np.eye(N), R)
    cross = np.einsum("xjy,by->xjb", states[-1], H).reshape(n, N * m)
    expected = np.concatenate([H @ power[k + 1] @ x0 for k in range(N)])
    x = power[N] @ x0 + cross @ np.linalg.solve(joint, zs.reshape(-1) - expected)
    return x, states[-1, :, -1] - cross @ np.linalg.solve(joint, cross.T)


def exact_update(x, P, h, r, z):
    """One scalar measurement in exact rational arithmetic; lists of float64 in and out."""
    x, h = [Fraction(v) for v in x], [Fraction(v) for v in h]
    P = [[Fraction(v) for v in row] for row in P]
    states = range(len(x))
    g = [sum(P[i][j] * h[j] for j in states) for i in states]
    s = sum(h[i] * g[i] for i in states) + Fraction(r)
    y = Fraction(z) - sum(h[i] * x[i] for i in states)
    x = [float(x[i] + g[i] * y / s) for i in states]
    return np.array(x), np.array(
        [[float(P[i][j] - g[i] * g[j] / s) for j in states] for i in states]
    )


def exact_inertial(T, noise, zs, measured):
    """Kownacki's filters to 40 digits: Phi = [1 T; 0 1], W = Q T^2 I, one state measured.

    ``noise`` is R, Q and P0; ``measured`` is 0 for the gyroscope and 1 for the accelerometer.
    The output is the measured state, rounded to float64.
    """
    with mpmath.workdps(40):
        T, R, Q = (mpmath.mpf(float(v)) for v in (T, *noise[:2]))
        phi, W = mpmath.matrix([[1, T], [0, 1]]), Q * T**2 * mpmath.eye(2)
        x, P = mpmath.matrix([0, 0]), mpmath.matrix(np.asarray(noise[2]).tolist())
        outputs = []
        for z in zs:
            x, P = phi * x, phi * P * phi.T + W
            if not np.isnan(z):
                K = P[:, measured] / (P[measured, measured] + R)
                x = x + K * (mpmath.mpf(float(z)) - x[measured])
                P = P - K * P[measured, :]
            outputs.append(float(x[measured]))
        return np.array(outputs)


def response(F, K, H, w):
    """|xhat / z| at w radians a sample of the filter x = F x + K (z - H F x), output H x."""
    turn = np.exp(1j * w)
    loop = turn * np.eye(len(F)) - (np.eye(len(F)) - np.outer(K, H)) @ F
    return abs(H @ np.linalg.solve(loop, turn * K.astype(complex)))


def rise_time(y, dt):
    """Time from the first sample at 10 % of a unit step to the first at 90 %."""
    return (int(np.argmax(y >= 0.9)) - int(np.argmax(y >= 0.1))) * dt


def lag_to_first_crossing(lag, dt):
    """Trapezoid of lag^2 from its first sample to the first at which lag <= 0 (or the last)."""
    reached = np.flatnonzero(lag <= 0)
    end = reached[0] if reached.size else len(lag) - 1
    square = lag[: end + 1] ** 2
    return dt * (square[1:] + square[:-1]).sum() / 2, end


def lag_below(lag, dt):
    """Trapezoid of max(lag, 0)^2 over the whole of lag."""
    square = np.where(lag > 0, lag, 0.0) ** 2
    return dt * (square[1:] + square[:-1]).sum() / 2


def central_difference(function, point, step):
    """The gradient of a scalar function by central differences, one coordinate after another."""
    shifts = step * np.eye(len(point))
    return np.array([(function(point + s) - function(point - s)) / (2 * step) for s in shifts])


def diffuse_estimates(F, W, h, r, z):
    """A filter that knows nothing of its start, by weighted least squares over whole records.

    The unknowns are the states at all times so far; each step of the model and each measurement is
    an equation, divided by its deviation. No recursion, and no prior.

    Args:
        F, W: transitions and noise that lead to each sample, ``(N, n, n)``; the first is not used.
        h: the row that is measured, ``(n,)``.
        r: variances, ``(N,)``; z: measurements, ``(N,)``, NaN where missing.

    Returns:
        Estimates ``(N, n)`` and covariances ``(N, n, n)`` after each sample, NaN where the
        measurements so far do not determine the state.
    """
    N, n = len(z), len(h)
    x, P = np.full((N, n), np.nan), np.full((N, n, n), np.nan)
    rows, right = np.zeros((0, N * n)), np.zeros(0)
    for k in range(N):
        if k:
            root = np.linalg.inv(np.linalg.cholesky(W[k]))
            step = np.zeros((n, N * n))
            step[:, k * n : (k + 1) * n] = root
            step[:, (k - 1) * n : k * n] = -root @ F[k]
            rows, right = np.vstack([rows, step]), np.append(right, np.zeros(n))
        if not np.isnan(z[k]):
            row = np.zeros((1, N * n))
            row[0, k * n : (k + 1) * n] = h / np.sqrt(r[k])
            rows, right = np.vstack([rows, row]), np.append(right, z[k] / np.sqrt(r[k]))
        if (~np.isnan(z[: k + 1])).sum() >= n:
            some = rows[:, : (k + 1) * n]
            inverse = np.linalg.inv(some.T @ some)
            x[k] = (inverse @ some.T @ right)[-n:]
            P[k] = inverse[-n:, -n:]
    return x, P


def integrated_noise(n, density, dt):
    """Covariance that white noise on the n-th derivative adds, by a sum over a fine grid."""
    middles = (np.arange(20000) + 0.5) / 20000 * dt
    powers = np.array([middles ** (n - 1 - i) for i in range(n)])
    powers /= np.array([[float(np.prod(np.arange(1, n - i)))] for i in range(n)])
    return density * powers @ powers.T * dt / 20000


def surprise(e, S):
    """Squared length of a joint innovation in units of its covariance, and that one's ln det."""
    return e @ np.linalg.solve(S, e) + np.linalg.slogdet(S)[1]


def surprises(innovation, variance):
    """The same of innovations that were taken one after another, ``(N, m)``: 0 where none was."""
    seen = variance > 0
    assert not innovation[~seen].any()
    s = np.where(seen, variance, 1.0)
    return (innovation**2 / s + np.log(s)).sum(axis=1)
