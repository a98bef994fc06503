"""Steady Kalman filters: the discrete and continuous Riccati equations, differentiable."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.small_linalg import product, solve
from objectives.linear_systems.lyapunov import (
    congruence,
    doubled,
    improved,
    largest_eigenvalue,
    lyapunov,
    stein,
)

_MOST_DOUBLINGS = 50
_MOST_STEPS = 30  # Newton's: two or three from a good start, more where R is tiny
# A change of P as a share of the states' standard deviations: Newton's next would be its square.
_SETTLED, _ACCEPTED = 1e-9, 1e-6
_MOST_TOLD = 1e8  # by the measurements, as a share of the process noise
_TRACE = 1e-12


@jax.custom_jvp
def dare(F: Array, H: Array, Q: Array, R: Array) -> Array:
    """The steady PREDICTED covariance of a discrete Kalman filter, P(-).

    P = F (P - P H' (H P H' + R)^-1 H P) F' + Q, the solution that makes the filter stable: by the
    structure-preserving doubling algorithm (Chu, Fan, Lin and Wang, Int. J. Control 77(8), 2004),
    then Newton's steps in Joseph's form (Kleinman 1968; Hewer 1971), which keep every digit of a
    tiny R and of states in units far apart. Derivatives of any order, in both modes, are those of
    the equation. Units: those of the states, squared.

    Args:
        F: transition over one sample, ``(n, n)``; it may be unstable.
        H: measurement matrix, ``(m, n)``.
        Q: covariance of the noise that enters in one sample, ``(n, n)``, positive semi-definite.
        R: covariance of the measurement noise, ``(m, m)``, positive definite.

    Returns:
        ``(n, n)``; NaN throughout where no solution makes the filter strictly stable: a mode that
        does not die out is not seen in z, or one on the unit circle is not driven
        (:func:`objectives.steady_kalman` names it).

    >>> one = jnp.eye(1)
    >>> round(float(dare(one, one, one, one)[0, 0]), 9)  # the golden section
    1.618033989
    """

    def step(P: Array) -> Array:
        L = product(F, steady_gain(P, H, R))
        return doubled(F - product(L, H), Q + congruence(L, R))

    return _fixed_point(
        step, _doubling(F.T, *_regularised(F.T, product(H.T, solve(R, H)), Q, _MOST_TOLD))
    )


def steady_gain(P: Array, H: Array, R: Array) -> Array:
    """K = P H' (H P H' + R)^-1, ``(n, m)``: the gain on an innovation, with P predicted.

    >>> one = jnp.eye(1)
    >>> steady_gain(3 * one, one, one).tolist(), updated(3 * one, one, one).tolist()
    ([[0.75]], [[0.75]])
    """
    return solve(congruence(H, P) + R, product(H, P.T)).T


def updated(P: Array, H: Array, R: Array) -> Array:
    """The covariance after a measurement, from the predicted P, in Joseph's form, ``(n, n)``."""
    K = steady_gain(P, H, R)
    return congruence(jnp.eye(P.shape[0]) - product(K, H), P) + congruence(K, R)


@dare.defjvp
def _dare_jvp(primals: tuple[Array, ...], tangents: tuple[Array, ...]) -> tuple[Array, Array]:
    F, H, _, R = primals
    dF, dH, dQ, dR = tangents
    P = dare(*primals)
    L = product(F, steady_gain(P, H, R))
    closed = F - product(L, H)
    moved = product(dF - product(L, dH), P, closed.T)
    return P, stein(closed, moved + moved.T + congruence(L, dR) + dQ)


@jax.custom_jvp
def care(A: Array, C: Array, W: Array, V: Array) -> Array:
    """The steady covariance of a Kalman-Bucy filter.

    A P + P A' - P C' V^-1 C P + W = 0, the solution that makes the filter stable; by Cayley's
    transform and the same algorithm as :func:`dare`. Derivatives as there.

    Args:
        A: continuous dynamics, ``(n, n)``, 1/s; it may be unstable.
        C: measurement matrix, ``(m, n)``.
        W: two-sided spectral density of the driving noise, ``(n, n)``, unit^2 s, positive
            semi-definite.
        V: that of the measurement noise, ``(m, m)``, unit^2 s, positive definite.

    Returns:
        ``(n, n)``; NaN throughout where no solution makes the filter strictly stable, and for some
        models whose V or W is a factor 1e12 below what the other one suggests
        (:func:`objectives.steady_kalman` solves those too).

    >>> one = jnp.eye(1)
    >>> float(care(0 * one, one, 4 * one, one)[0, 0].round(12))
    2.0
    """

    def step(P: Array) -> Array:
        K = bucy_gain(P, C, V)
        return improved(A - product(K, C), W + congruence(K, V), P)

    A0, G0, W0 = _cayley(A, product(C.T, solve(V, C)), W)
    # There less of G0 would be another A as well.
    return _fixed_point(step, _doubling(A0, *_regularised(A0, G0, W0, jnp.inf)))


def bucy_gain(P: Array, C: Array, V: Array) -> Array:
    """K = P C' V^-1, ``(n, m)``, 1/s: the gain of a Kalman-Bucy filter.

    >>> one = jnp.eye(1)
    >>> bucy_gain(care(-one, one, 3 * one, one), one, one).round(9).tolist()
    [[1.0]]
    """
    return solve(V, product(C, P.T)).T


@care.defjvp
def _care_jvp(primals: tuple[Array, ...], tangents: tuple[Array, ...]) -> tuple[Array, Array]:
    A, C, _, V = primals
    dA, dC, dW, dV = tangents
    P = care(*primals)
    K = bucy_gain(P, C, V)
    moved = product(dA - product(K, dC), P)
    return P, lyapunov(A - product(K, C), moved + moved.T + congruence(K, dV) + dW)


class _Doubling(NamedTuple):
    A: Array
    G: Array
    H: Array
    rounds: Array


def _doubling(A: Array, G: Array, H: Array) -> Array:
    """X near that of X = A' X (I + G X)^-1 A + H, ``(n, n)``: a start for Newton's method."""
    n = A.shape[0]

    def more(state: _Doubling) -> Array:
        size = jnp.abs(state.A).max()
        return (size > 1e-12) & (size < 1e200) & (state.rounds < _MOST_DOUBLINGS)

    def double(state: _Doubling) -> _Doubling:
        A, G, H, rounds = state
        scale = jnp.sqrt(jnp.abs(jnp.diagonal(H)))
        scale = jnp.where(scale > 0, scale, 1.0)
        left = jnp.eye(n) + product(scale[:, None] * G, H / scale)
        both = solve(left, scale[:, None] * jnp.concatenate([A, product(G, A.T)], axis=1))
        reached, informed = both[:, :n] / scale[:, None], both[:, n:] / scale[:, None]
        G = G + product(A, informed)
        H = H + product(A.T, H, reached)
        return _Doubling(product(A, reached), (G + G.T) / 2, (H + H.T) / 2, rounds + 1)

    return jax.lax.while_loop(more, double, _Doubling(A, G, H, jnp.zeros((), int))).H


def _regularised(A: Array, G: Array, H: Array, most: float) -> tuple[Array, Array]:
    """G and H as the doubling can take them; a filter that is stable with them is so without.

    It subtracts, so digits are lost where G H is large: G is made smaller there. And from zero it
    stays in the solution that leaves an unstable, undriven mode alone: H gains a trace of 1/G.
    """
    seen, driven, power = G, H, A
    for _ in range(A.shape[0]):
        seen, driven = seen + congruence(power, G), driven + congruence(power.T, H)
        power = product(power, A)
    seen, driven = jnp.diagonal(seen), jnp.diagonal(driven)
    share = 1 / jnp.maximum(1.0, (seen * driven).max() / most)
    trace = jnp.where(seen > 0, _TRACE / (share * seen), 0.0)
    return share * G, H + jnp.diag(trace)


def _cayley(A: Array, G: Array, W: Array) -> tuple[Array, Array, Array]:
    """The discrete problem that has the continuous one's solution.

    Its rate lies above every rate of A, with which A - rate I is stable and the matrix that is
    inverted regular.
    """
    n = A.shape[0]
    one = jnp.eye(n)
    hamiltonian = jnp.block([[A.T, -G], [-W, -A]])
    most, least = largest_eigenvalue(hamiltonian), solve(hamiltonian, jnp.eye(2 * n))
    middle = jnp.sqrt(most / largest_eigenvalue(least))
    rate = jnp.maximum(middle, 2 * largest_eigenvalue(A))
    shifted = A - rate * one
    joined = jnp.block([[shifted.T, -G], [-W, -shifted]])
    first = jnp.block([[A.T + rate * one], [-W]])
    second = jnp.block([[-G], [-A - rate * one]])
    both = solve(joined, jnp.concatenate([first, second], axis=1))
    return both[:n, :n], both[:n, n:], -both[n:, :n]


class _Steps(NamedTuple):
    P: Array
    change: Array
    rounds: Array


def _fixed_point(improve: Callable[[Array], Array], start: Array) -> Array:
    """The fixed point P = improve(P); NaN where the iteration does not converge."""

    def more(state: _Steps) -> Array:
        return (state.change > _SETTLED) & (state.rounds < _MOST_STEPS)

    def improve_once(state: _Steps) -> _Steps:
        P = improve(state.P)
        P = (P + P.T) / 2
        return _Steps(P, _relative(P - state.P, P), state.rounds + 1)

    end = jax.lax.while_loop(
        more, improve_once, _Steps(start, jnp.asarray(jnp.inf), jnp.zeros((), int))
    )
    return jnp.where(end.change < _ACCEPTED, end.P, jnp.nan)


def _relative(change: Array, P: Array) -> Array:
    deviation = jnp.sqrt(jnp.diagonal(P))
    allowed = deviation[:, None] * deviation
    return jnp.where(change == 0, 0.0, jnp.abs(change) / allowed).max()
