"""The covariance of a filter's error, which depends on no measurement.

A Kalman filter's gains depend on its model alone, so a design can be judged before there is any
data: with the optimal gains, with gains of another origin, and in continuous time. These filters
are building blocks of designs: they take a model and no measurements, and declare nothing.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.exponential import expm
from filters.kalman import Estimate, decorrelate, predict, update
from filters.linear import LinearModel
from filters.small_linalg import matmul, product, solve


class Uncertainty(NamedTuple):
    """The error of a filter after a measurement.

    Attributes:
        P: covariance P(+), ``(n, n)``.
        K: the gain that was applied, ``(n, m)``.
    """

    P: Array
    K: Array


@dataclass(frozen=True)
class KalmanCovariance:
    """Covariance and gains of a Kalman filter: measure, output, predict.

    The first measurement is taken at once, on P0. Source: Ha, Kim and Choi 1981, (14) to (17). The
    inputs only count the samples: any array with time first.
    """

    def init(self, params: LinearModel) -> Array:
        """P0, the covariance before the first measurement."""
        return params.P0

    def step(self, params: LinearModel, state: Array, inputs: Any) -> tuple[Array, Uncertainty]:
        """Take one measurement and predict to the next."""
        n, m = state.shape[0], params.H.shape[0]
        H, variances, z = params.H, params.R, jnp.eye(m, dtype=state.dtype)
        if params.R.ndim == 2:
            H, variances, z = decorrelate(H, params.R, z)
        # Unit measurements on a state of zero leave the gain in the state.
        estimate = Estimate(jnp.zeros((n, m), state.dtype), state)
        for i in range(m):
            estimate, _ = update(estimate, H[i], variances[i], z[i])
        return _predicted(params, estimate.P), Uncertainty(estimate.P, estimate.x)


@dataclass(frozen=True)
class GainCovariance:
    """Covariance of the error with gains from elsewhere: measure, output, predict.

    Source: Ha, Kim and Choi 1981, (19), which is Joseph's form: right for any gain. The inputs are
    the gains, ``(n, m)`` per sample.
    """

    def init(self, params: LinearModel) -> Array:
        """P0, the covariance before the first measurement."""
        return params.P0

    def step(self, params: LinearModel, state: Array, inputs: Array) -> tuple[Array, Uncertainty]:
        """Take one measurement with the given gain and predict to the next."""
        R = params.R if params.R.ndim == 2 else jnp.diag(params.R)
        rest = jnp.eye(state.shape[0], dtype=state.dtype) - matmul(inputs, params.H)
        P = matmul(matmul(rest, state), rest.T) + matmul(matmul(inputs, R), inputs.T)
        return _predicted(params, P), Uncertainty(P, inputs)


class GainTable(NamedTuple):
    """A model with a few gains that take turns.

    Attributes:
        model: the model.
        K: the gains, ``(k, n, m)``.
    """

    model: LinearModel
    K: Array


@dataclass(frozen=True)
class TableCovariance:
    """Covariance of the error with gains from a table, which can be tuned.

    The inputs say which gain is applied, one whole number per sample.
    """

    def init(self, params: GainTable) -> Array:
        """P0, the covariance before the first measurement."""
        return params.model.P0

    def step(self, params: GainTable, state: Array, inputs: Array) -> tuple[Array, Uncertainty]:
        """Take one measurement with the gain of that number and predict to the next."""
        return GainCovariance().step(params.model, state, params.K[inputs])


class Flow(NamedTuple):
    """A continuous Riccati equation over one step.

    Attributes:
        M: the Hamiltonian's exponential, ``(2n, 2n)``; see :func:`riccati_flow`.
        P0: covariance at the start, ``(n, n)``.
    """

    M: Array
    P0: Array


@dataclass(frozen=True)
class RiccatiCovariance:
    """Covariance of a Kalman-Bucy filter's error, exact at the ends of the steps.

    The inputs only count the steps: any array with time first; the first output is P0.
    """

    def init(self, params: Flow) -> Array:
        """P0."""
        return params.P0

    def step(self, params: Flow, state: Array, inputs: Any) -> tuple[Array, Array]:
        """Output P and follow the equation over one step."""
        n = state.shape[0]
        X = params.M[:n, :n] + product(params.M[:n, n:], state)
        Y = params.M[n:, :n] + product(params.M[n:, n:], state)
        P = solve(X.T, Y.T)  # (Y X^-1)', and P is symmetric
        return (P + P.T) / 2, state


def riccati_flow(A: Array, C: Array, W: Array, V: Array, dt: Array) -> Array:
    """The matrix M that carries P' = A P + P A' + W - P C' V^-1 C P over dt.

    With X(0) = I and Y(0) = P(0), ``d[X; Y]/dt = [-A', C' V^-1 C; W, A] [X; Y]``, P = Y X^-1.
    Source: Kalman and Bucy, J. Basic Engineering 83, 1961.

    Args:
        A: dynamics, ``(n, n)``, 1/s.
        C: measurement matrix, ``(m, n)``.
        W: spectral density of the process noise, ``(n, n)``.
        V: spectral density of the measurement noise, ``(m, m)``, positive definite.
        dt: step, s, short against the time in which the fastest mode changes by a factor of 1e8.
    """
    seen = C.T @ jnp.linalg.solve(V, C)
    flow: Array = expm(jnp.block([[-A.T, seen], [W, A]]) * dt)
    return flow


def _predicted(params: LinearModel, P: Array) -> Array:
    move = params.transition
    noise = matmul(matmul(move.G, move.Q), move.G.T)
    return predict(Estimate(params.x0, P), move.F, noise).P
