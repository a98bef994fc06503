"""A linear system with white noise, the basis of every design without data.

The system is x' = A x + w, y = C x + v; its observer x^' = A x^ + L (y - C x^), whose error moves
by A - L C. In discrete time the observer is the predictor x^(k+1) = A x^(k) + L (y(k) - C x^(k)),
so variances are those before a measurement.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import ArrayLike

from filters import LinearModel, Transition, van_loan
from objectives.in_numpy import in_numpy
from objectives.linear_systems.checks import check_shapes, is_definite, noise
from objectives.linear_systems.lyapunov import lyapunov, stein

_TINY = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True, eq=False, init=False)
class LinearSystem:
    """A linear system with stationary white noise; its arrays are float64 and cannot be written.

    Attributes:
        A: dynamics, ``(n, n)``: 1/s, or over one sample where ``dt`` is given.
        C: measurement matrix, ``(m, n)``.
        W: spectral density of w (two-sided, unit^2 s), or covariance a sample, ``(n, n)``.
        V: the same of v, ``(m, m)``; zero where a measurement has no noise.
        dt: sample time, s; None where the system is continuous.
        states: their names; x1, x2, ... where none are given.
        S: cross-covariance of both noises, ``(n, m)``: E w v'; zero where it is not given.

    Raises:
        ValueError: where shapes do not fit, an entry is not finite, noise is no covariance, or the
            sample time is not positive.

    >>> bias = LinearSystem(
    ...     [[0.0, 0.0], [1.0, 0.0]], [[0.0, 1.0]], [[1e-4, 0.0], [0.0, 1.0]], [[1.0]],
    ...     states=("bias", "speed"),
    ... )
    >>> bias.poles(np.array([[0.02], [0.3]])).round(3).tolist()
    [-0.1, -0.2]
    """

    A: np.ndarray
    C: np.ndarray
    W: np.ndarray
    V: np.ndarray
    dt: float | None
    states: tuple[str, ...]
    S: np.ndarray

    def __init__(
        self,
        A: ArrayLike,
        C: ArrayLike,
        W: ArrayLike,
        V: ArrayLike,
        *,
        dt: float | None = None,
        states: Sequence[str] = (),
        S: ArrayLike | None = None,
    ) -> None:
        given = {"A": A, "C": C, "W": W, "V": V} | ({} if S is None else {"S": S})
        matrices = {name: np.array(part, float) for name, part in given.items()}
        check_shapes(matrices, states)
        matrices.setdefault("S", np.zeros((len(matrices["A"]), len(matrices["C"]))))
        matrices["W"], matrices["V"] = noise(*(matrices[name] for name in "WVS"))
        if dt is not None and not 0 < dt < np.inf:
            raise ValueError(f"the sample time is {dt:g} s; give a positive number, or none")
        names = tuple(states) or tuple(f"x{i + 1}" for i in range(len(matrices["A"])))
        _fill(self, matrices, dt, names)

    @property
    def discrete(self) -> bool:
        """Whether the system is in discrete time."""
        return self.dt is not None

    @property
    def matrices(self) -> dict[str, np.ndarray]:
        """A, C, W, V and S by name."""
        return {"A": self.A, "C": self.C, "W": self.W, "V": self.V, "S": self.S}

    @property
    def noisy(self) -> bool:
        """Whether no combination of the measurements is free of noise."""
        return is_definite(self.V)

    def poles(self, L: np.ndarray) -> np.ndarray:
        """Eigenvalues of A - L C for a gain ``(n, m)``, the slowest first, ``(n,)``."""
        found = np.linalg.eigvals(self.A - L @ self.C)
        speed = np.abs(found) if self.discrete else found.real
        return np.asarray(found[np.argsort(-speed, kind="stable")])

    def rates(self, poles: np.ndarray) -> np.ndarray:
        """Decay rates of poles, 1/s; negative where they grow."""
        if self.dt is None:
            return -np.real(poles)
        return np.asarray(-np.log(np.maximum(np.abs(poles), _TINY)) / self.dt)

    def decay(self, L: np.ndarray) -> float:
        """Decay rate of the slowest pole under a gain, 1/s; negative without stability."""
        return float(self.rates(self.poles(L))[0])

    def covariance(self, L: np.ndarray) -> np.ndarray:
        """Steady covariance of the error under a gain, ``(n, n)``; NaN without stability."""
        solve = stein if self.discrete else lyapunov
        P = in_numpy(solve, self.A - L @ self.C, self._driving(L))
        return np.asarray((P + P.T) / 2)

    def steady(self, L: Array) -> Array:
        """The covariance as :meth:`covariance`, differentiable in L ``(n, m)``."""
        solve = stein if self.discrete else lyapunov
        return solve(jnp.asarray(self.A - L @ self.C), jnp.asarray(self._driving(L)))

    def _driving(self, L: Array | np.ndarray) -> Array | np.ndarray:
        """Covariance of the noise that drives the error, w - L v, ``(n, n)``."""
        shared = self.S @ L.T
        driving: Array | np.ndarray = self.W + L @ self.V @ L.T - shared - shared.T
        return driving

    def in_units(self, states: np.ndarray, measurements: np.ndarray, time: float) -> "LinearSystem":
        """The same system in other units: x = ``states`` x', y = ``measurements`` y', t = time t'.

        Args:
            states: the new ones' basis, ``(n, n)``, regular.
            measurements: a unit each, ``(m,)``.
            time: unit of time, s.
        """

        def inside(matrix: np.ndarray) -> np.ndarray:
            return np.asarray(np.linalg.solve(states, matrix))

        per = 1.0 if self.discrete else time
        parts = {
            "A": per * inside(self.A @ states),
            "C": self.C @ states / measurements[:, None],
            "W": per * inside(inside(self.W).T),
            "V": self.V / measurements / measurements[:, None] / per,
            "S": inside(self.S) / measurements,
        }
        return derived(parts, None if self.dt is None else self.dt / time)

    def restricted(self, T: np.ndarray, states: Sequence[str]) -> "LinearSystem":
        """The system of T'x, where T is an orthonormal basis ``(n, r)`` that allows it."""
        W, S = T.T @ self.W @ T, T.T @ self.S
        parts = {"A": T.T @ self.A @ T, "C": self.C @ T, "W": W, "V": self.V, "S": S}
        return derived(parts, self.dt, tuple(states))

    def sampled(self, dt: float, V: ArrayLike) -> "LinearSystem":
        """A continuous system measured every dt seconds, discretised exactly.

        Args:
            dt: sample time, s.
            V: covariance of a sample's measurement noise, ``(m, m)``; a density does not say it.

        Raises:
            ValueError: for a discrete system, correlated noises, or a V that is not a covariance.

        >>> walk = LinearSystem([[0.0]], [[1.0]], [[2.0]], [[0.0]]).sampled(0.5, [[3.0]])
        >>> walk.W.item(), walk.V.item(), walk.dt
        (1.0, 3.0, 0.5)
        """
        if self.discrete:
            raise ValueError(
                f"the system is discrete, with samples of {self.dt:g} s; sample a continuous one"
            )
        self._refuse_shared("be sampled")
        step = in_numpy(van_loan, self.A, np.eye(len(self.A)), self.W, dt)
        return LinearSystem(step.F, self.C, step.Q, V, dt=dt, states=self.states)

    def filter_model(self, P0: ArrayLike, x0: ArrayLike | None = None) -> LinearModel:
        """The model for :class:`filters.LinearKalman` and the covariance filters.

        Args:
            P0: covariance of the start, ``(n, n)``.
            x0: the start, ``(n,)``; zero where it is not given.

        Raises:
            ValueError: for a continuous system, or correlated noises.

        >>> walk = LinearSystem([[1.0]], [[1.0]], [[2.0]], [[3.0]], dt=1.0)
        >>> walk.filter_model([[1.0]]).R.tolist()
        [3.0]
        """
        if not self.discrete:
            raise ValueError(
                "a filter needs a discrete system; discretise this one with sampled(dt, V)"
            )
        self._refuse_shared("become a filter's model")
        n, variances = len(self.A), np.diag(self.V)
        alone = np.array_equal(self.V, np.diag(variances))
        return LinearModel(
            transition=Transition(jnp.asarray(self.A), jnp.eye(n), jnp.asarray(self.W)),
            H=jnp.asarray(self.C),
            R=jnp.asarray(variances if alone else self.V),
            P0=jnp.asarray(P0, dtype=float),
            x0=jnp.zeros(n) if x0 is None else jnp.asarray(x0, dtype=float),
        )

    def _refuse_shared(self, what: str) -> None:
        if self.S.any():
            raise ValueError(f"w and v are correlated (S is not zero), so the system cannot {what}")


def derived(
    parts: dict[str, np.ndarray], dt: float | None, states: tuple[str, ...] = ()
) -> LinearSystem:
    """A system that follows from one that was checked; it may have no states.

    Rounding may leave what a check would refuse.
    """
    system = object.__new__(LinearSystem)
    _fill(system, parts, dt, states or tuple(f"x{i + 1}" for i in range(len(parts["A"]))))
    return system


def _fill(
    system: LinearSystem,
    parts: dict[str, np.ndarray],
    dt: float | None,
    states: tuple[str, ...],
) -> None:
    for name, part in parts.items():
        kept = np.array(part, float)
        kept.setflags(write=False)
        object.__setattr__(system, name, kept)
    object.__setattr__(system, "dt", dt)
    object.__setattr__(system, "states", states)
