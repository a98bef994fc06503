"""Exact discretisation of a linear model at any sample time, also at one traced by JAX."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.small_linalg import matmul

TERMS = 16
"""Terms of the series where norm(A) h is at most 1/2: the rest is below 2^-16 / 17!, 5e-20."""
MOST_DOUBLINGS = 20
"""Enough for a step a million times as long as the fastest time constant."""


class Step(NamedTuple):
    """The discretised linear model of one sample time.

    Attributes:
        F: transition, ``(n, n)``.
        push: integral of expm(A t) over the step, through which constant inputs act,
            ``(n, n)``.
        Q: covariance of the noise that enters, ``(n, n)``.
    """

    F: Array
    push: Array
    Q: Array


def exact(A: Array, S: Array, dt: Array | float, nilpotent: int | None = None) -> Step:
    """Discretise dx = (A x + c) dt + w, white noise w of spectral density S.

    The series of F, push and Q, without a linear solve, so that it may stand inside a time loop:
    push = sum of A^k h^(k+1) / (k+1)!, F = 1 + A push, and Q' = A Q + Q A' + S. Over a part of the
    step that is short for A, which is then doubled: push + F push, F F, Q + F Q F'. Where a power
    of A is 0, as of positions and their derivatives, the series ends by itself, and is exact.
    :func:`filters.van_loan` does the same with a matrix exponential of twice the size.

    Args:
        A: dynamics, ``(n, n)``, 1/s.
        S: spectral density, ``(n, n)``, symmetric, unit^2 s.
        dt: sample time, s.
        nilpotent: the power of A that is 0 whatever its entries are; None where there is none.

    >>> A, S = jnp.array([[0.0, 1.0], [0.0, 0.0]]), jnp.diag(jnp.array([0.0, 6.0]))
    >>> step = exact(A, S, 1.0, nilpotent=2)
    >>> step.F.tolist(), step.Q.tolist()
    ([[1.0, 1.0], [0.0, 1.0]], [[2.0, 3.0], [3.0, 6.0]])
    """
    if nilpotent is not None:
        return _polynomials(A, S, dt, nilpotent)
    length = jax.lax.stop_gradient(jnp.abs(A).sum(axis=1).max() * dt)
    doublings = jnp.clip(
        jnp.ceil(jnp.log2(jnp.where(length > 0, length, 1.0))) + 1, 0, MOST_DOUBLINGS
    )
    part = dt / 2**doublings
    begun = _series(A * part, S * part, part, TERMS)

    def double(i: Array, step: Step) -> Step:
        F, push, Q = step
        twice = Step(matmul(F, F), push + matmul(F, push), Q + matmul(matmul(F, Q), F.T))
        pairs = zip(twice, step, strict=True)
        return Step(*(jnp.where(i < doublings, new, old) for new, old in pairs))

    F, push, Q = jax.lax.fori_loop(0, MOST_DOUBLINGS, double, begun)
    return Step(F, push, (Q + Q.T) / 2)


def _polynomials(A: Array, S: Array, h: Array | float, nilpotent: int) -> Step:
    """The finite sums; no sample time enters products, so that they stay outside of loops."""
    one = jnp.eye(len(A), dtype=A.dtype)
    power, push, time = one, one * h, h
    for k in range(2, nilpotent + 1):
        power, time = matmul(A, power) / k, time * h
        push = push + power * time
    noise, Q, time = S, S * h, h
    for k in range(2, 2 * nilpotent):
        turned = matmul(A, noise)
        noise, time = (turned + turned.T) / k, time * h
        Q = Q + noise * time
    return Step(one + matmul(A, push), push, Q)


def _series(T: Array, N: Array, h: Array | float, terms: int) -> Step:
    """The sums of a given number of terms, of A h and S h."""
    one = jnp.eye(len(T), dtype=T.dtype)
    power, push, noise, Q = one, one, N, N
    for k in range(2, terms + 1):
        power = matmul(T, power) / k
        push = push + power
        turned = matmul(T, noise)
        noise = (turned + turned.T) / k
        Q = Q + noise
    return Step(one + matmul(T, push), push * h, Q)
