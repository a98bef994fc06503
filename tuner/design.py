"""Observers of linear models as problems: the fastest within a variance, and the quietest.

No data is needed. The model is x' = A x + w, y = C x + v with white noise; the observer
x^' = A x^ + L (y - C x^), whose error moves by A - L C. In discrete time the observer is the
predictor x^(k+1) = A x^(k) + L (y(k) - C x^(k)), so variances are those before a measurement.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from objectives import (
    Factors,
    Mode,
    SteadyKalman,
    lyapunov,
    placing,
    steady_kalman,
    steady_variance,
    stein,
    unseen_modes,
    without_undriven,
)
from tuner.constraint import Constraint
from tuner.parameters import Limited, Parameter, Positive, covariance
from tuner.problem import Problem
from tuner.solvers.known import Known
from tuner.space import Space

_stein, _lyapunov = jax.jit(stein), jax.jit(lyapunov)
WIDEST = 100.0
"""How many times as fast as the slowest pole the others may be."""
SMOOTHING = 3e-4
"""How far inside its limit a pole has to stay where several measurements are used."""


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
    def placeable(self) -> bool:
        """Whether the only measurement sees every state, so that poles can be put anywhere."""
        try:
            placing(self.A, self.C[0])
        except ValueError:
            return False
        return len(self.C) == 1

    @property
    def finite(self) -> bool:
        """Whether the best gain is finite: always in discrete time, else where all of y is noisy."""
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

    def variance(self, L: Array) -> Array:
        """Steady variance of the error that counts, ``()``; differentiable in L ``(n, m)``."""
        row = jnp.asarray(self.error)
        return steady_variance(self.closed(L), self._noise(L), row, discrete=self.discrete)

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


class Observer(NamedTuple):
    """A point of a design.

    Attributes:
        decay: the decay rate that is asked of the slowest pole, 1/s.
        L: gain, ``(n, m)``.
    """

    decay: Array
    L: Array


@dataclass(frozen=True, eq=False)
class _Variance:
    """The variance that a design is about, as objective or constraint."""

    design: LinearDesign

    def __call__(self, observer: Observer, _: None) -> Array:
        return self.design.variance(observer.L)


def _time_constant(observer: Observer, _: None) -> Array:
    """Of the slowest pole, s."""
    return 1 / observer.decay


def fastest(name: str, design: LinearDesign, bound: float, unit: str = "") -> Problem:
    """The observer whose slowest pole decays fastest while the variance keeps a bound.

    With one measurement that sees every state the unknowns are factors of the characteristic
    polynomial (:class:`objectives.Factors`), otherwise the gains and a smoothed spectral abscissa
    (Vanbiervliet, Vandereycken, Michiels, Vandewalle and Diehl, SIAM J. Optim. 20(1), 2009).

    Raises:
        ValueError: for a bound that no observer keeps, with the least variance.
    """
    least = design.least()
    if not bound > least:
        raise ValueError(
            f"the bound {bound:g} is not above {least:.6g}, the least variance that any observer "
            "reaches; widen it, measure more, or measure better"
        )
    limit = Constraint("variance", _Variance(design), bound, unit)
    if design.placeable:
        return _placed(name, design, bound, limit)
    return _smoothed(name, design, bound, limit)


def _placed(name: str, design: LinearDesign, bound: float, limit: Constraint) -> Problem:
    placed = _Placed(design)
    decay = _begin(placed, bound)
    parameters: dict[str, Parameter] = {
        "decay": Positive(decay, 1e-4 * decay, 1e4 * decay, unit="1/s")
    }
    if placed.factors.odd:
        parameters["spread"] = Limited(1.0, 0.0, WIDEST)
    for i in range(placed.factors.pairs):
        parameters[f"damping_{i + 1}"] = Limited(1.0, 0.0, WIDEST)
        parameters[f"stiffness_{i + 1}"] = Limited(1.0, 0.0, WIDEST**2)
    return Problem(
        name=name,
        space=Space.of(**parameters),
        filter=None,
        build=placed,
        objective=_time_constant,
        constraints=(limit,),
    )


@dataclass(frozen=True, eq=False)
class _Placed:
    """From factors of the characteristic polynomial to the gain."""

    design: LinearDesign

    @property
    def factors(self) -> Factors:
        return Factors(len(self.design.states), self.design.discrete)

    def __call__(self, values: dict[str, Array]) -> Observer:
        factors, decay = self.factors, values["decay"]
        rate = decay if self.design.dt is None else jnp.exp(-decay * self.design.dt)
        pairs = [
            (values[f"damping_{i + 1}"], values[f"stiffness_{i + 1}"]) for i in range(factors.pairs)
        ]
        coefficients = factors.coefficients(rate, values.get("spread"), pairs)
        matrix = placing(self.design.A, self.design.C[0])
        return Observer(decay, (jnp.asarray(matrix) @ coefficients)[:, None])


def _begin(placed: _Placed, bound: float) -> float:
    """The fastest decay rate at which coinciding poles keep the bound; or the quietest."""
    design, factors = placed.design, placed.factors
    values = {"spread": jnp.zeros(())} if factors.odd else {}
    for i in range(factors.pairs):
        values |= {f"damping_{i + 1}": jnp.zeros(()), f"stiffness_{i + 1}": jnp.zeros(())}
    unit = max(float(np.abs(np.linalg.eigvals(design.A)).max()), 1e-6)
    rates = np.geomspace(1e-6, 1e6, 241) * unit
    if design.dt is not None:
        rates = np.geomspace(1e-6, 10.0, 141) / design.dt
    variance = jax.jit(jax.vmap(lambda decay: design.variance(placed(values | {"decay": decay}).L)))
    found = np.asarray(variance(jnp.asarray(rates)))
    found = np.where(np.isfinite(found) & (found >= 0), found, np.inf)
    kept = np.flatnonzero(found <= bound)
    return float(rates[kept[-1] if kept.size else np.argmin(found)])


def _smoothed(name: str, design: LinearDesign, bound: float, limit: Constraint) -> Problem:
    start, size = _hurried(design, bound), _sizes(design)
    decay = design.decay(start)
    gains = _Gains(design, start, _rates(design, size))
    parameters: dict[str, Parameter] = {
        "decay": Positive(0.9 * decay, 1e-4 * decay, 1e4 * decay, unit="1/s")
    }
    return Problem(
        name=name,
        space=Space.of(**parameters, **gains.parameters()),
        filter=None,
        build=gains,
        objective=_time_constant,
        constraints=(limit, Constraint("stability", _Smoothed(design, size), 1.0)),
    )


def _hurried(design: LinearDesign, bound: float) -> np.ndarray:
    """The Kalman gain of a model that grows faster by e^(alpha t), alpha as large as allowed.

    All poles of the true model then decay faster than alpha (Anderson and Moore, 1969): an observer
    that keeps the bound and is fast already.
    """

    def gain(alpha: float) -> np.ndarray:
        d, grown = design, np.exp(alpha * design.dt) if design.dt else 1.0
        A = d.A * grown if d.discrete else d.A + alpha * np.eye(len(d.A))
        # Noise of measurements that have none, small enough not to count.
        V = d.V + 1e-9 * np.eye(len(d.V)) * (np.trace(d.V) or np.trace(d.C @ d.W @ d.C.T) or 1.0)
        K = steady_kalman(A, d.C, d.W, V, discrete=d.discrete).gain
        return np.asarray((A @ K if d.discrete else K) / grown)

    def kept(alpha: float) -> bool:
        try:
            L = gain(alpha)
        except ValueError:
            return False
        variance = float(design.error @ design.covariance(L) @ design.error)
        return design.decay(L) > 0 and variance <= 0.98 * bound

    unit = 1 / design.dt if design.dt else max(np.abs(np.linalg.eigvals(design.A)).max(), 1e-3)
    kept_rates = [rate for rate in unit * np.geomspace(1e-4, 1e4, 17) if kept(rate)]
    if not kept_rates:
        return gain(0.0)
    slow = max(kept_rates)
    fast = slow * np.sqrt(10)
    for _ in range(8):
        middle = float(np.sqrt(slow * fast))
        slow, fast = (middle, fast) if kept(middle) else (slow, middle)
    return gain(slow)


def _sizes(design: LinearDesign) -> np.ndarray:
    """A typical error of every state, ``(n,)``: in its units nothing depends on the user's."""
    L = _hurried(design, np.inf) if not design.finite else None
    P = design.kalman().predicted if L is None else design.covariance(L)
    size = np.sqrt(np.maximum(np.diag(P), 0.0))
    return np.asarray(np.where(size > 0, size, size.max() or 1.0))


def _rates(design: LinearDesign, size: np.ndarray) -> np.ndarray:
    """A natural unit of every gain, ``(n, m)``: errors of states over errors of measurements."""
    seen = np.sqrt(np.diag(design.C * size @ (design.C * size).T))
    rate = 1.0 if design.discrete else max(float(np.abs(np.linalg.eigvals(design.A)).max()), 1e-3)
    return np.asarray(rate * size[:, None] / np.where(seen > 0, seen, 1.0))


@dataclass(frozen=True, eq=False)
class _Smoothed:
    """Whether all poles decay faster than asked, as a smooth number that is 1 just inside.

    With white noise of the states' own size, the covariance of the error seen through
    e^(decay t) is finite only if they do.
    """

    design: LinearDesign
    size: np.ndarray

    def __call__(self, observer: Observer, _: None) -> Array:
        d = self.design
        closed = d.closed(observer.L) * self.size / self.size[:, None]
        one = jnp.eye(len(d.states))
        if d.dt is not None:
            return SMOOTHING * jnp.trace(stein(closed * jnp.exp(observer.decay * d.dt), one))
        grown = lyapunov(closed + observer.decay * one, one)
        return SMOOTHING * observer.decay * jnp.trace(grown)


def quietest(name: str, design: LinearDesign) -> Problem:
    """The observer with the least variance of the error: the Kalman filter, as a search.

    The model must be driven (:meth:`LinearDesign.driven`), and continuous measurements noisy.

    Raises:
        ValueError: where a measurement has no noise: better observers have ever larger gains.
    """
    if not design.finite:
        raise ValueError(
            "a measurement has no noise (the matrix of v is singular) and may be followed ever "
            "faster, so no gain is the best one; give the noise that it has, a bound, or the "
            "sample_time of the measurements"
        )
    if not design.kalman().gain.any():
        raise ValueError(
            "no gain is needed: nothing disturbs what the measurements could correct; give the "
            "noise w that there is, or a bound"
        )
    gains = _gains(design)
    return Problem(
        name=name,
        space=Space.of(**gains.parameters()),
        filter=None,
        build=gains,
        objective=_Variance(design),
    )


@dataclass(frozen=True, eq=False)
class _Gains:
    """From single gains to a point of the design; each is tuned in a unit of its own.

    Attributes:
        design: the design.
        start: where the search begins, ``(n, m)``.
        unit: of every gain, ``(n, m)``.
    """

    design: LinearDesign
    start: np.ndarray
    unit: np.ndarray

    def parameters(self) -> dict[str, Parameter]:
        found: dict[str, Parameter] = {}
        for i, j in np.ndindex(*self.start.shape):
            start, unit = float(self.start[i, j]), float(self.unit[i, j])
            reach = 1e3 * max(abs(start), unit)
            # The ends belong to the search: who gets there has not found an optimum.
            found[self._name(i, j)] = Limited(start, -reach, reach, scale=unit, limited=False)
        return found

    def _name(self, i: int, j: int) -> str:
        return f"L{i + 1}" if self.start.shape[1] == 1 else f"L{i + 1}_{j + 1}"

    def named(self, L: np.ndarray) -> dict[str, float]:
        return {self._name(i, j): float(value) for (i, j), value in np.ndenumerate(L)}

    def __call__(self, values: dict[str, Array]) -> Observer:
        n, m = self.start.shape
        rows = [jnp.stack([values[self._name(i, j)] for j in range(m)]) for i in range(n)]
        return Observer(values.get("decay", jnp.ones(())), jnp.stack(rows))


def _gains(design: LinearDesign) -> _Gains:
    """A stable gain beside the Kalman gain, to start from."""
    kalman = design.predictor_gain(design.kalman().gain)
    start = next(
        (f * kalman for f in (1.5, 1.2, 1.1, 1.02) if design.decay(f * kalman) > 0), kalman
    )
    return _Gains(design, start, np.maximum(np.abs(kalman), 1e-3 * np.abs(kalman).max()))


def riccati(design: LinearDesign) -> Known:
    """The quietest observer by the Riccati equation."""
    kalman = design.predictor_gain(design.kalman().gain)
    found = _gains(design).named(kalman)
    return Known("riccati", lambda _: found, "the Riccati equation's solution")


def gain_of(problem: Problem, z: np.ndarray) -> np.ndarray:
    """The gain L ``(n, m)`` at a point of one of these problems."""
    observer: Observer = problem.static.built(jnp.asarray(z))
    return np.asarray(observer.L)
