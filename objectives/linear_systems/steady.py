"""The steady Kalman filter of any model that has one, NumPy outside and JAX inside."""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import numpy as np
import scipy.linalg
from jax import Array

from objectives.linear_systems.modes import Mode, Reduction, unseen_modes, without_undriven
from objectives.linear_systems.riccati import bucy_gain, care, dare, steady_gain, updated

_dare, _care = jax.jit(dare), jax.jit(care)


class SteadyKalman(NamedTuple):
    """A Kalman filter in its steady state.

    Attributes:
        predicted: covariance before a measurement, ``(n, n)``; zero along what was taken out.
        updated: after it, ``(n, n)``; of a continuous filter the same.
        gain: ``(n, m)``; of a continuous filter in 1/s.
        poles: eigenvalues of the filter's error dynamics, without what was taken out, ``(r,)``.
        removed: the undriven modes that were taken out: in the end the filter knows them.
    """

    predicted: np.ndarray
    updated: np.ndarray
    gain: np.ndarray
    poles: np.ndarray
    removed: tuple[Mode, ...]


def steady_kalman(
    A: np.ndarray,
    C: np.ndarray,
    W: np.ndarray,
    V: np.ndarray,
    *,
    discrete: bool,
    states: Sequence[str] | None = None,
) -> SteadyKalman:
    """The steady Kalman filter, without the undriven modes that keep it from having one.

    Args:
        A: dynamics ``(n, n)``: 1/s, or over one sample where ``discrete``.
        C: measurement matrix, ``(m, n)``.
        W: covariance of the noise in a sample, or its spectral density, ``(n, n)``.
        V: the same of the measurement noise, ``(m, m)``.
        discrete: whether A steps by samples.
        states: their names, for the sentences.

    Raises:
        ValueError: where shapes do not fit, V is not positive definite, W is not positive
            semi-definite, a mode that does not die out is not seen, or no solution was found.

    >>> one = np.eye(1)
    >>> float(steady_kalman(one, one, one, one, discrete=True).gain[0, 0].round(6))
    0.618034
    """
    A, C, W, V = (np.asarray(part, dtype=np.float64) for part in (A, C, W, V))
    _check(A, C, W, V)
    unseen = unseen_modes(A, C, discrete=discrete)
    if unseen:
        raise ValueError(
            f"no measurement shows {' and '.join(mode.words(states) for mode in unseen)}, which "
            "does not die out, so its covariance grows without bound; measure it or leave it out"
        )
    part = without_undriven(A, W, C, discrete=discrete)
    if not part.A.size:
        zero = np.zeros_like(A)
        return SteadyKalman(zero, zero, np.zeros_like(C.T), np.zeros(0), part.modes)
    small = _solved(part, V, discrete)
    if np.isnan(small).any():
        raise ValueError(
            "the Riccati equation was not solved, although every mode is seen and driven; the "
            f"model lies too near to one without a steady filter: its poles are {_listed(A)}"
        )
    after, gain = map(np.asarray, _measured(small, part.C, V, discrete))
    closed = part.A - (part.A @ gain if discrete else gain) @ part.C
    T = part.T
    poles = np.linalg.eigvals(closed)
    return SteadyKalman(T @ small @ T.T, T @ after @ T.T, T @ gain, poles, part.modes)


@jax.jit(static_argnums=3)
def _measured(P: Array, C: Array, V: Array, discrete: bool) -> tuple[Array, Array]:
    """The covariance after a measurement, and the gain."""
    return (updated(P, C, V), steady_gain(P, C, V)) if discrete else (P, bucy_gain(P, C, V))


def _solved(part: Reduction, V: np.ndarray, discrete: bool) -> np.ndarray:
    """The covariance before a measurement, ``(r, r)``, by whichever method finds it; else NaN."""
    doubled = np.asarray((_dare if discrete else _care)(part.A, part.C, part.W, V))
    return _by_schur(part, V, discrete) if np.isnan(doubled).any() else doubled


def _by_schur(part: Reduction, V: np.ndarray, discrete: bool) -> np.ndarray:
    """scipy's solution by ordered Schur vectors, for noise a factor 1e12 apart; NaN where none."""
    solve = scipy.linalg.solve_discrete_are if discrete else scipy.linalg.solve_continuous_are
    try:
        return np.asarray(solve(part.A.T, part.C.T, part.W, V))
    except (np.linalg.LinAlgError, ValueError):
        return np.full_like(part.A, np.nan)


def _check(A: np.ndarray, C: np.ndarray, W: np.ndarray, V: np.ndarray) -> None:
    n, m = len(A), len(C)
    if (A.shape, C.shape, W.shape, V.shape) != ((n, n), (m, n), (n, n), (m, m)):
        raise ValueError(
            f"A {A.shape}, C {C.shape}, W {W.shape} and V {V.shape} do not fit; they are (n, n), "
            "(m, n), (n, n) and (m, m)"
        )
    if not all(np.isfinite(part).all() for part in (A, C, W, V)):
        raise ValueError("A, C, W or V has entries that are not finite; every entry must be known")
    for name, matrix, positive in (("V", V, True), ("W", W, False)):
        if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0):
            raise ValueError(f"{name} is not symmetric; a covariance is: give ({name} + {name}')/2")
        deviation = np.sqrt(np.abs(np.diag(matrix)))
        unit = np.where(deviation > 0, deviation, 1.0)
        least = np.linalg.eigvalsh(matrix / np.outer(unit, unit)).min(initial=1.0)
        if least <= 0 if positive else least < -1e-9:
            value = np.linalg.eigvalsh(matrix).min()
            kind = "positive definite" if positive else "positive semi-definite"
            raise ValueError(
                f"{name} is not {kind}: its smallest eigenvalue is {value:.3g}; give a covariance"
            )


def _listed(A: np.ndarray) -> str:
    return ", ".join(f"{value:.4g}" for value in np.linalg.eigvals(A))
