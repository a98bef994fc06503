"""A linear model that an observer is designed for, and what a gain comes to there.

The model is x' = A x + w, y = C x + v with white noise; the observer x^' = A x^ + L (y - C x^),
whose error moves by A - L C. In discrete time the observer is the predictor
x^(k+1) = A x^(k) + L (y(k) - C x^(k)), so variances are those before a measurement.
"""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from objectives import (
    Mode,
    SteadyKalman,
    lyapunov,
    steady_kalman,
    stein,
    unseen_modes,
    without_undriven,
)
from tuner.problem.parameters import covariance

_stein, _lyapunov = jax.jit(stein), jax.jit(lyapunov)


@dataclass(frozen=True, eq=False)
class LinearDesign:
    """A linear model with stationary white noise, and the error that counts.

    Attributes:
        states: their names, n of them.
        A: dynamics, ``(n, n)``: 1/s, or over one sample where ``dt`` is given.
        C: what is measured, ``(m, n)``.
        W: spectral density of w (two-sided, unit^2 s), or covariance a sample, ``(n, n)``.
        V: the same of v, ``(m, m)``; zero where the measurement has no noise.
        error: the combination of the states' errors that counts, ``(n,)``.
        dt: sample time, s; None where the model is continuous.

    Raises:
        ValueError: where shapes do not fit, noise is no covariance, the sample time is not
            positive, or a mode that does not die out shows in no measurement.

    >>> bias = LinearDesign(
    ...     ("bias", "speed"), np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[0.0, 1.0]]),
    ...     np.diag([1e-4, 1.0]), np.eye(1), np.array([1.0, 0.0]), None,
    ... )
    >>> bias.kalman().gain.ravel().round(6).tolist()
    [0.01, 1.00995]
    """

    states: tuple[str, ...]
    A: np.ndarray
    C: np.ndarray
    W: np.ndarray
    V: np.ndarray
    error: np.ndarray
    dt: float | None

    def __post_init__(self) -> None:
        n, m = len(self.states), len(self.C)
        wanted = {"A": (n, n), "C": (m, n), "W": (n, n), "V": (m, m), "error": (n,)}
        for name, shape in wanted.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ValueError(
                    f"{name} has the shape {found}; {n} states and {m} measurements need {shape}"
                )
        if self.dt is not None and not 0 < self.dt < np.inf:
            raise ValueError(f"the sample time is {self.dt:g} s; give a positive number, or none")
        for name in ("W", "V"):
            try:
                covariance(getattr(self, name))
            except ValueError as error:
                raise ValueError(f"{name} {error}") from None
        unseen = unseen_modes(self.A, self.C, discrete=self.discrete)
        if unseen:
            words = " and ".join(mode.words(self.states) for mode in unseen)
            raise ValueError(
                f"no measurement shows {words}, which does not die out, so no observer's error "
                "stays bounded; measure it, or leave it out of the model"
            )

    @property
    def discrete(self) -> bool:
        """Whether the model steps by samples."""
        return self.dt is not None

    @property
    def finite(self) -> bool:
        """Whether the best gain is finite: in continuous time only if all of y is noisy."""
        return self.discrete or bool(np.linalg.eigvalsh(self.V)[0] > 0)

    def kalman(self) -> SteadyKalman:
        """The steady Kalman filter.

        A discrete measurement without noise is given some that changes the variance by no more
        than a share of 1e-12: the Riccati equation is solved for noisy ones only.
        """
        V = self.V
        if self.discrete and np.linalg.eigvalsh(V)[0] <= 0:
            size = np.diag(self.C @ self.W @ self.C.T) + np.diag(V)
            V = V + 1e-12 * np.diag(np.where(size > 0, size, size.max() or 1.0))
        return steady_kalman(self.A, self.C, self.W, V, discrete=self.discrete, states=self.states)

    def predictor_gain(self, gain: np.ndarray) -> np.ndarray:
        """L of a filter's gain K: A K where the model steps by samples."""
        return self.A @ gain if self.discrete else gain

    def poles(self, L: np.ndarray) -> np.ndarray:
        """Eigenvalues of A - L C, the slowest first, ``(n,)``."""
        found = np.linalg.eigvals(self.A - L @ self.C)
        speed = np.abs(found) if self.discrete else found.real
        return np.asarray(found[np.argsort(-speed, kind="stable")])

    def decay(self, L: np.ndarray) -> float:
        """Decay rate of the slowest pole, 1/s; negative where the observer is unstable."""
        slowest = self.poles(L)[0]
        return float(-slowest.real if self.dt is None else -np.log(abs(slowest)) / self.dt)

    def covariance(self, L: np.ndarray) -> np.ndarray:
        """Steady covariance of the error, ``(n, n)``; NaN where the observer is unstable."""
        solve = _stein if self.discrete else _lyapunov
        P = np.asarray(solve(self.closed(L), self._noise(L)))
        return np.asarray((P + P.T) / 2)

    def variance(self, L: np.ndarray) -> float:
        """Steady variance of the error that counts; NaN where the observer is unstable."""
        return float(self.error @ self.covariance(L) @ self.error)

    def steady(self, L: Array) -> Array:
        """The covariance as :meth:`covariance`, differentiable in L ``(n, m)``."""
        return (stein if self.discrete else lyapunov)(self.closed(L), self._noise(L))

    def closed(self, L: Array | np.ndarray) -> Array:
        """A - L C, ``(n, n)``."""
        return jnp.asarray(self.A - L @ self.C)

    def _noise(self, L: Array | np.ndarray) -> Array:
        return jnp.asarray(self.W + L @ self.V @ L.T)

    def least(self) -> float:
        """The least variance of the error that counts over all observers.

        Where a continuous measurement has no noise it is not known here, and 0 is returned.
        """
        if not self.finite:
            return 0.0
        return float(self.error @ self.kalman().predicted @ self.error)

    def driven(self) -> tuple["LinearDesign", np.ndarray, tuple[Mode, ...]]:
        """The model without modes that nothing drives and that never die out.

        Their error falls to zero by itself, as 1/t, and the steady gain leaves them alone.

        Returns:
            The model that is left, the basis T ``(n, r)`` that leads back to the states, and the
            modes that were taken out.
        """
        left = without_undriven(self.A, self.W, self.C, discrete=self.discrete)
        if not left.modes:
            return self, np.eye(len(self.states)), ()
        chosen = np.abs(left.T) > 1 - 1e-9
        names = [
            self.states[int(np.argmax(column))] if column.any() else f"part_{i + 1}"
            for i, column in enumerate(chosen.T)
        ]
        T = np.where(chosen.any(axis=0), np.abs(left.T), left.T)  # a state keeps its own sign
        A, W, C = T.T @ self.A @ T, T.T @ self.W @ T, self.C @ T
        rest = LinearDesign(tuple(names), A, C, W, self.V, self.error @ T, self.dt)
        return rest, T, left.modes
