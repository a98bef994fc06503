"""Unit quaternions (w, x, y, z) as rotations, with derivatives that exist at zero.

A quaternion q turns sensor coordinates into earth coordinates, v_earth = q v q*, earth z up. All
functions take one quaternion; use ``jax.vmap`` for many.
"""

import jax.numpy as jnp
from jax import Array

_SMALL = 1e-4
"""Squared angle, rad^2, below which series stand for sine and arc: their error is 1e-18."""
_DOWN = 1e-9
"""Distance of the vertical's cosine from -1 that is taken as upside down; at least the spacing of
numbers, lest the cosine be -1 and not below the limit."""


def multiply(p: Array, q: Array) -> Array:
    """The product p q, ``(4,)``: first q, then p.

    >>> multiply(jnp.array([0.0, 1.0, 0.0, 0.0]), jnp.array([0.0, 0.0, 1.0, 0.0])).tolist()
    [0.0, 0.0, 0.0, 1.0]
    """
    a, b, c, d = p
    w, x, y, z = q
    return jnp.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )


def conjugate(q: Array) -> Array:
    """The inverse rotation, ``(4,)``."""
    return jnp.stack([q[0], -q[1], -q[2], -q[3]])


def rotate(q: Array, v: Array) -> Array:
    """q v q*, ``(3,)``: sensor coordinates into earth coordinates.

    >>> half = jnp.sqrt(0.5)
    >>> turned = rotate(jnp.array([half, 0.0, 0.0, half]), jnp.array([1.0, 0.0, 0.0]))
    >>> [round(x, 12) + 0.0 for x in turned.tolist()]
    [0.0, 1.0, 0.0]
    """
    u = q[1:]
    twice = 2 * cross(u, v)
    return v + q[0] * twice + cross(u, twice)


def rotate_back(q: Array, v: Array) -> Array:
    """q* v q, ``(3,)``: earth coordinates into sensor coordinates."""
    return rotate(conjugate(q), v)


def cross(a: Array, b: Array) -> Array:
    """a x b, ``(3,)``, written out."""
    return jnp.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def from_rotation_vector(v: Array) -> Array:
    """The rotation by abs(v) rad about v ``(3,)``, ``(4,)``; smooth at zero.

    >>> from_rotation_vector(jnp.zeros(3)).tolist()
    [1.0, 0.0, 0.0, 0.0]
    """
    square = v @ v
    small = square < _SMALL
    angle = jnp.sqrt(jnp.where(small, 1.0, square))
    cosine = jnp.where(small, 1 - square / 8 + square**2 / 384, jnp.cos(angle / 2))
    ratio = jnp.where(small, 0.5 - square / 48 + square**2 / 3840, jnp.sin(angle / 2) / angle)
    return jnp.concatenate([cosine[None], ratio * v])


def normalise(q: Array) -> Array:
    """Any vector over its length."""
    return q / jnp.sqrt(q @ q)


def begun(q: Array, acceleration: Array) -> Array:
    """q, or the level attitude of an acceleration where there is none yet: zeros, ``(4,)``.

    Without an acceleration either, it is upright.

    >>> begun(jnp.zeros(4), jnp.array([0.0, 0.0, 9.81]))[0].item()
    1.0
    """
    upright = jnp.array([0.0, 0.0, 1.0], q.dtype)
    square = acceleration @ acceleration
    measured = jnp.where((square > 0) & (square < jnp.inf), acceleration, upright)
    return jnp.where(q @ q > 0, q, level(measured))


def or_else(rate: Array, still: Array) -> Array:
    """A measured rate, with the rate at rest along the axes on which it is missing (NaN)."""
    return jnp.where(jnp.isnan(rate), still, rate)


def level(acceleration: Array) -> Array:
    """The rotation that turns an acceleration measured at rest upright, ``(4,)``, heading 0.

    The shortest turn, so it knows no gimbal lock; upside down it is half a turn about x.

    >>> level(jnp.array([0.0, 0.0, 9.81]))[0].item()
    1.0
    """
    x, y, z = normalise(acceleration)
    down = z < -1 + max(_DOWN, float(jnp.finfo(z.dtype).eps))
    w = jnp.sqrt(jnp.where(down, 1.0, (1 + z) / 2))
    upright = normalise(jnp.stack([w, y / (2 * w), -x / (2 * w), jnp.zeros_like(w)]))
    return jnp.where(down, jnp.array([0.0, 1.0, 0.0, 0.0], w.dtype), upright)
