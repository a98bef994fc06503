"""The steady Kalman filter of any model that has one, NumPy outside and JAX inside."""

from typing import NamedTuple

import numpy as np
from jax import Array

from objectives.in_numpy import in_numpy
from objectives.linear_systems.model import LinearSystem, derived
from objectives.linear_systems.modes import Mode, require_detectable, without_undriven
from objectives.linear_systems.riccati import bucy_gain, care, dare, steady_gain, updated


class SteadyKalman(NamedTuple):
    """A Kalman filter in its steady state.

    Attributes:
        predicted: covariance before a measurement, ``(n, n)``; zero along removed modes.
        updated: after it, ``(n, n)``; of a continuous filter the same.
        gain: K on a measurement, ``(n, m)``; of a continuous filter in 1/s.
        predictor: L of the observer x^' = A x^ + L (y - C x^), ``(n, m)``: A K in discrete time
            where w and v share nothing, K in continuous time.
        poles: eigenvalues of the filter's error dynamics, without removed modes, ``(r,)``.
        removed: the undriven modes, which the filter knows in the end.
    """

    predicted: np.ndarray
    updated: np.ndarray
    gain: np.ndarray
    predictor: np.ndarray
    poles: np.ndarray
    removed: tuple[Mode, ...]


def steady_kalman(system: LinearSystem) -> SteadyKalman:
    """The steady Kalman filter, without the undriven modes that keep it from having one.

    A discrete measurement without noise is given some that changes the variance by no more than a
    share of 1e-12: the Riccati equation is solved for noisy ones only. Noise that w and v share is
    taken out of w first, by which a measurement moves the state (Kailath, Sayed and Hassibi 2000,
    8.5).

    Raises:
        ValueError: where a continuous measurement has no noise, a mode that does not die out is not
            seen, or no solution was found.

    >>> walk = LinearSystem([[1.0]], [[1.0]], [[1.0]], [[1.0]], dt=1.0)
    >>> float(steady_kalman(walk).gain[0, 0].round(6))
    0.618034
    """
    if not (system.discrete or system.noisy):
        raise ValueError(
            "a measurement has no noise (V is singular), so no gain is the best one; give its "
            "noise, or the sample time of the measurements"
        )
    require_detectable(system)
    noisy, shared = _independent(_with_noise(system))
    part = without_undriven(noisy)
    small, after, within = _filtered(part.system)
    T, gain = part.T, part.T @ within
    predictor = (noisy.A @ gain if system.discrete else gain) + shared
    return SteadyKalman(
        predicted=T @ small @ T.T,
        updated=T @ after @ T.T,
        gain=gain if system.discrete else predictor,
        predictor=predictor,
        poles=np.linalg.eigvals(T.T @ (system.A - predictor @ system.C) @ T),
        removed=part.modes,
    )


def _with_noise(system: LinearSystem) -> LinearSystem:
    """The system with negligible noise in discrete measurements that have none."""
    if system.noisy:
        return system
    size = np.diag(system.C @ system.W @ system.C.T) + np.diag(system.V)
    trace = 1e-12 * np.diag(np.where(size > 0, size, size.max() or 1.0))
    return derived(system.matrices | {"V": system.V + trace}, system.dt, system.states)


def _independent(system: LinearSystem) -> tuple[LinearSystem, np.ndarray]:
    """The system with the part of w independent of v, and S V^-1 by which y then drives it."""
    shared = np.zeros_like(system.S)
    if not system.S.any():
        return system, shared
    shared = np.linalg.solve(system.V, system.S.T).T
    parts = system.matrices | {
        "A": system.A - shared @ system.C,
        "W": system.W - shared @ system.S.T,
        "S": np.zeros_like(shared),
    }
    return derived(parts, system.dt, system.states), shared


def _filtered(system: LinearSystem) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The covariances before and after a measurement, and the gain."""
    if not system.A.size:
        return system.W, system.W, system.C.T
    P = _solved(system)
    if np.isnan(P).any():
        raise ValueError(
            "the Riccati equation was not solved; the model is close to one without a steady "
            f"filter: its poles are {_listed(system.A)}"
        )
    after, gain = in_numpy(_discrete if system.discrete else _continuous, P, system.C, system.V)
    return P, after, gain


def _discrete(P: Array, C: Array, V: Array) -> tuple[Array, Array]:
    """The covariance after a measurement, and the gain."""
    return updated(P, C, V), steady_gain(P, C, V)


def _continuous(P: Array, C: Array, V: Array) -> tuple[Array, Array]:
    """The covariance, which a measurement does not change, and the gain."""
    return P, bucy_gain(P, C, V)


def _solved(system: LinearSystem) -> np.ndarray:
    """The covariance before a measurement, ``(n, n)``, by whichever method finds it; else NaN."""
    solve = dare if system.discrete else care
    doubled: np.ndarray = in_numpy(solve, system.A, system.C, system.W, system.V)
    return _by_schur(system) if np.isnan(doubled).any() else doubled


def _by_schur(system: LinearSystem) -> np.ndarray:
    """SciPy's solution by ordered Schur vectors, for noises 1e12 apart; NaN where none is found."""
    from scipy.linalg import solve_continuous_are, solve_discrete_are

    solve = solve_discrete_are if system.discrete else solve_continuous_are
    try:
        return np.asarray(solve(system.A.T, system.C.T, system.W, system.V))
    except (np.linalg.LinAlgError, ValueError):
        return np.full_like(system.A, np.nan)


def _listed(A: np.ndarray) -> str:
    return ", ".join(f"{value:.4g}" for value in np.linalg.eigvals(A))
