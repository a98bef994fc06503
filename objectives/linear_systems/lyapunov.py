"""Steady covariances of linear systems: the Lyapunov and the Stein equation, differentiable."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.small_linalg import product, solve, traced_once

# A mode that keeps a share of 1 - 2^-44 a sample is stable by less than what rounding does to F.
_MOST_DOUBLINGS = 50
_ROUNDING = 1e-14  # of the fastest rate: what rounding does to the slowest
_GONE = 1e-40  # of a power of F: its square is below every unit that the states may have


def stein(F: Array, Q: Array) -> Array:
    """X with X = F X F' + Q: the steady covariance of x' = F x + w with cov w = Q per sample.

    Smith's doubling (SIAM J. Applied Mathematics 16(1), 1968): X takes in F X F', F is squared.
    Derivatives of any order, in both modes, are those of the equation, not of the iteration.

    Args:
        F: transition, ``(n, n)``.
        Q: ``(n, n)``; it need not be symmetric.

    Returns:
        ``(n, n)``; NaN throughout where F is not strictly stable, abs(eigenvalue) < 1.

    >>> float(stein(jnp.array([[0.5]]), jnp.array([[3.0]]))[0, 0])
    4.0
    """
    X: Array = jax.lax.custom_linear_solve(
        lambda X: X - congruence(F, X),
        Q,
        solve=lambda _, B: doubled(F, B),
        transpose_solve=lambda _, B: doubled(F.T, B),
    )
    return X


def lyapunov(A: Array, Q: Array) -> Array:
    """X with A X + X A' + Q = 0: the steady covariance of dx = A x dt + dw, w of density Q.

    Cayley's transform turns it into a Stein equation; one step of refinement in the equation itself
    gives back the digits that the transform costs a stiff A. Derivatives as for :func:`stein`.

    Args:
        A: continuous dynamics, ``(n, n)``, 1/s.
        Q: two-sided spectral density of the noise, ``(n, n)``, unit^2 s; it need not be symmetric.

    Returns:
        ``(n, n)``; NaN throughout where A is not strictly stable, Re(eigenvalue) < 0.

    >>> float(lyapunov(jnp.array([[-2.0]]), jnp.array([[4.0]]))[0, 0])
    1.0
    """
    X: Array = jax.lax.custom_linear_solve(
        lambda X: -_both_sides(A, X),
        Q,
        solve=lambda _, B: _improved_once(A, B),
        transpose_solve=lambda _, B: _improved_once(A.T, B),
    )
    return X


def congruence(F: Array, X: Array) -> Array:
    """F X F'."""
    return product(F, X, F.T)


class _Powers(NamedTuple):
    power: Array
    total: Array
    rounds: Array


@traced_once
def doubled(F: Array, Q: Array) -> Array:
    """The Stein equation's solution by doubling; not for differentiation."""

    def more(state: _Powers) -> Array:
        size = jnp.abs(state.power).max()
        return (size > _GONE) & (size < 1 / _GONE) & (state.rounds < _MOST_DOUBLINGS)

    def double(state: _Powers) -> _Powers:
        power, total, rounds = state
        return _Powers(product(power, power), total + congruence(power, total), rounds + 1)

    end = jax.lax.while_loop(more, double, _Powers(F, Q, jnp.zeros((), int)))
    return jnp.where(jnp.abs(end.power).max() <= _GONE, end.total, jnp.nan)


@traced_once
def largest_eigenvalue(A: Array) -> Array:
    """The largest abs(eigenvalue) of A to within a quarter, ``()``; 0 where A is nilpotent.

    Read from A^64, so that even units 1e12 apart rounds by their 64th root only.
    """

    def square(i: Array, state: tuple[Array, Array]) -> tuple[Array, Array]:
        log, power = state
        size = jnp.abs(power).max()
        power = power / jnp.where(size > 0, size, 1.0)
        return log + jnp.log(size) / 2.0**i, product(power, power)

    return jnp.exp(jax.lax.fori_loop(0, 7, square, (jnp.zeros(()), A))[0])


def _both_sides(A: Array, X: Array) -> Array:
    return product(A, X) + product(X, A.T)


@traced_once
def improved(A: Array, Q: Array, X: Array) -> Array:
    """The Lyapunov equation's solution from an approximation X; not for differentiation.

    The residual of X is solved for by Cayley's transform, whose rounding errors are then small.
    """
    return _transform(A).improved(Q, X)


class _Cayley(NamedTuple):
    """A, with the matrices and the rate that turn a Lyapunov equation into a Stein equation."""

    A: Array
    inverse: Array
    moved: Array
    rate: Array

    def improved(self, Q: Array, X: Array) -> Array:
        over = congruence(self.inverse, _both_sides(self.A, X) + Q)
        return X + doubled(self.moved, 2 * self.rate * over)


def _transform(A: Array) -> _Cayley:
    one = jnp.eye(A.shape[0])
    fast, slow = largest_eigenvalue(A), 1 / largest_eigenvalue(solve(A, one))
    rate = jnp.where(slow > _ROUNDING * fast, jnp.sqrt(fast * slow), jnp.nan)
    inverse = solve(rate * one - A, one)
    return _Cayley(A, inverse, one + 2 * product(inverse, A), rate)


@traced_once
def _improved_once(A: Array, Q: Array) -> Array:
    """The solution from X = 0, improved once; in a loop, which is compiled once."""
    cayley = _transform(A)
    X: Array = jax.lax.fori_loop(0, 2, lambda _, X: cayley.improved(Q, X), jnp.zeros_like(Q))
    return X
