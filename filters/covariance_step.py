"""The two steps of a covariance, each with its derivative written by hand.

Written so, a tangent takes fewer products than the formula's own derivative, and on the way back
little has to be kept of a step: gain, variance and innovation of a measurement, and of a prediction
nothing where its transition is known.
"""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from filters.small_linalg import LARGEST, congruence, contracted, matmul, turned


@jax.custom_jvp
def predicted(F: Array, across: Array, P: Array, W: Array) -> Array:
    """F P F' + W, symmetric to the bit.

    Args:
        F: transition matrix, ``(n, n)``.
        across: ``turned(F)``, whose derivative is F's.
        P: covariance, ``(n, n)``, symmetric.
        W: what is added, ``(n, n)``, symmetric.
    """
    return even(congruence(F, across, P)) + W


@partial(predicted.defjvp, symbolic_zeros=True)
def _predicted_jvp(at: Any, along: Any) -> tuple[Array, Array]:
    (F, across, P, W), (dF, _, dP, dW) = at, along
    # Turned round, each of these products contracts first axes.
    moved = _times(F, turned(_times(F, given(dP, P))))
    moved = even(moved)
    if not none(dW):
        moved = moved + dW
    if not none(dF):
        half = _times_across(_turned_by(across, P), dF)
        moved = moved + (half + half.T)
    return predicted(F, across, P, W), moved


@jax.custom_jvp
def corrected(
    x: Array, P: Array, h: Array, r: Array, z: Array
) -> tuple[Array, Array, Array, Array, Array]:
    """State, covariance, innovation, variance and gain of one scalar measurement.

    Joseph's form as two rank-one steps: see :func:`filters.update`.
    """
    return corrected_weighted(x, P, h, r, z)[0]


def corrected_weighted(
    x: Array, P: Array, h: Array, r: Array, z: Array
) -> tuple[tuple[Array, Array, Array, Array, Array], Array]:
    """The same, and the inverse of the variance, 0 where the measurement is missing."""
    missing = jnp.any(jnp.isnan(z))
    g = by(P, h)
    s = matmul(h, g) + r
    weight = jnp.where(missing, 0.0, 1 / s)
    k = g * weight
    y = jnp.where(missing, 0.0, z - matmul(h, x))
    A = P - jnp.outer(g, g) * weight
    # A h' = r k but for rounding.
    lost = jnp.outer(by(A, h) - r * k, k)
    variance = jnp.where(missing, 0.0, s)
    return (x + jnp.multiply.outer(k, y), A - (lost + lost.T) / 2, y, variance, k), weight


@partial(corrected.defjvp, symbolic_zeros=True)
def _corrected_jvp(at: Any, along: Any) -> tuple[Any, Any]:
    (x, P, h, r, z), (dx, dP, dh, dr, dz) = at, along
    found = corrected(x, P, h, r, z)
    _, _, y, s, k = found
    seen = s != 0
    weight = jnp.where(seen, 1 / jnp.where(seen, s, 1.0), 0.0)
    dx, dP = given(dx, x), given(dP, P)
    dg, dy = by(dP, h), -matmul(h, dx)
    if not none(dh):
        dg, dy = dg + by(P, dh), dy - matmul(dh, x)
    ds = matmul(h, dg)
    if not none(dh):
        ds = ds + s * matmul(k, dh)
    ds = ds if none(dr) else ds + dr
    dy = jnp.where(seen, dy if none(dz) else dy + dz, 0.0)
    dk = weight * (dg - k * ds)
    # d(g g' / s) = Z k' + k Z' with Z = dg - k ds / 2.
    halves = 2 * even(jnp.outer(dg - k * (ds / 2), k))
    # dk y with dk = (dg - k ds) / s, which is not needed by itself.
    share = weight * y
    dx = dx + jnp.multiply.outer(k, dy - ds * share) + jnp.multiply.outer(dg, share)
    return found, (dx, dP - halves, dy, jnp.where(seen, ds, 0.0), dk)


def by(P: Array, h: Array) -> Array:
    """P h for a symmetric P."""
    return matmul(P, h) if len(h) <= LARGEST else contracted(P, h)


def even(P: Array) -> Array:
    """The symmetric part."""
    return (P + P.T) / 2


def none(tangent: Any) -> bool:
    """Whether a derivative is 0 throughout."""
    return isinstance(tangent, jax.custom_derivatives.SymbolicZero)


def given(tangent: Any, like: Array) -> Array:
    """A derivative as an array."""
    return jnp.zeros_like(like) if none(tangent) else tangent


def _times(A: Array, B: Array) -> Array:
    """A B."""
    return matmul(A, B) if len(A) <= LARGEST else A @ B


def _times_across(A: Array, B: Array) -> Array:
    """A B'."""
    return matmul(A, B.T) if len(A) <= LARGEST else jnp.einsum("lk,ik->li", A, B)


def _turned_by(across: Array, P: Array) -> Array:
    """F P."""
    return matmul(across.T, P) if len(P) <= LARGEST else contracted(across, P)
