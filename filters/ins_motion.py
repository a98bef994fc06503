"""Strapdown navigation through one sample, and how its errors grow: an INS filter's prediction."""

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.attitude import skew
from filters.rotation import from_rotation_vector, multiply, normalise, rotate

SIZE = 15
"""Errors of attitude, gyroscope bias, accelerometer bias, velocity and position, three each."""
TURN, GYR_BIAS, ACC_BIAS, VELOCITY, POSITION = (slice(i, i + 3) for i in range(0, SIZE, 3))


class Motion(NamedTuple):
    """The navigated motion in earth axes, and the sensor's own errors.

    Attributes:
        q: attitude, sensor to earth, ``(4,)``; zeros: not known yet.
        velocity: m/s, ``(3,)``.
        position: m, ``(3,)``.
        gyr_bias: rad/s, ``(3,)``.
        acc_bias: m/s^2, ``(3,)``.
    """

    q: Array
    velocity: Array
    position: Array
    gyr_bias: Array
    acc_bias: Array


class Densities(NamedTuple):
    """Spectral densities of the noise of gyroscopes, accelerometers and both biases, ``()``."""

    gyr: Array
    acc: Array
    gyr_bias: Array
    acc_bias: Array


class Growth(NamedTuple):
    """The transition of the errors over one sample, by its blocks, ``(3, 3)`` each.

    Attributes:
        turn: attitude by gyroscope bias.
        push: velocity by attitude, by gyroscope bias and by accelerometer bias.
    """

    turn: Array
    push: tuple[Array, Array, Array]


def moved(at: Motion, gyr: Array, acc: Array, gravity: Array, dt: Array) -> tuple[Motion, Growth]:
    """Navigate through one sample, with the exact derivatives of the result.

    The rate holds through the sample, the force acts at the attitude in its middle, and the
    position follows the mean of both velocities. An error of attitude is a small rotation in earth
    axes: true q = error q.

    Args:
        at: the motion before the sample.
        gyr: angular rate, rad/s, ``(3,)``.
        acc: specific force, m/s^2, ``(3,)``.
        gravity: the specific force at rest in earth axes, m/s^2, ``(3,)``.
        dt: sample time, s.

    >>> zero = jnp.zeros(3)
    >>> level = Motion(jnp.array([1.0, 0.0, 0.0, 0.0]), zero, zero, zero, zero)
    >>> up = jnp.array([0.0, 0.0, 9.8])
    >>> moved(level, zero, up + jnp.array([1.0, 0.0, 0.0]), up, 2.0)[0].position.tolist()
    [2.0, 0.0, 0.0]
    """
    phi = (gyr - at.gyr_bias) * dt
    half = from_rotation_vector(phi / 2)
    middle = multiply(at.q, half)
    axes, halfway = matrix(at.q), matrix(middle)
    force = _times(halfway, acc - at.acc_bias)
    velocity = at.velocity + (force - gravity) * dt
    ahead = at._replace(
        q=normalise(multiply(middle, half)),
        velocity=velocity,
        position=at.position + (at.velocity + velocity) * (dt / 2),
    )
    turned, push = _times(axes, phi), -dt * skew(force)
    by_rate = -dt / 2 * _product(push, _product(_arc(turned / 2), axes))
    return ahead, Growth(-dt * _product(_arc(turned), axes), (push, by_rate, -dt * halfway))


def spread(P: Array, growth: Growth, noise: Densities, dt: Array) -> Array:
    """The covariance after a sample, F P F' + W, ``(15, 15)``.

    White noise of the accelerometers reaches the position through the velocity; the rest enters W
    to first order in dt.
    """
    P = _forward(_forward(P, growth, dt).T, growth, dt)
    one = jnp.ones(3, P.dtype)
    gyr, acc, gyr_bias, acc_bias = (density * dt * one for density in noise)
    diagonal = jnp.concatenate([gyr, gyr_bias, acc_bias, acc, acc * dt**2 / 3])
    beside = jnp.concatenate([jnp.zeros(9, P.dtype), acc * dt / 2])
    return (P + P.T) / 2 + jnp.diag(diagonal) + jnp.diag(beside, 3) + jnp.diag(beside, -3)


def corrected(at: Motion, x: Array) -> Motion:
    """The motion corrected by its estimated errors x ``(15,)``, which are zero after that."""
    return Motion(
        normalise(multiply(from_rotation_vector(x[TURN]), at.q)),
        at.velocity + x[VELOCITY],
        at.position + x[POSITION],
        at.gyr_bias + x[GYR_BIAS],
        at.acc_bias + x[ACC_BIAS],
    )


def matrix(q: Array) -> Array:
    """The rotation matrix of a unit quaternion, ``(3, 3)``; its columns are the sensor's axes."""
    return jnp.stack([rotate(q, axis) for axis in jnp.eye(3, dtype=q.dtype)], axis=1)


def _arc(v: Array) -> Array:
    """The rotation that a small change of a rotation vector adds to its own, ``(3, 3)``.

    The left Jacobian of SO(3) by its series, which is wrong by abs(v)^6 / 40320.
    """
    square = v @ v
    first = 1 / 2 - square / 24 + square**2 / 720
    second = 1 / 6 - square / 120 + square**2 / 5040
    one = jnp.eye(3, dtype=v.dtype)
    return (1 - second * square) * one + first * skew(v) + second * jnp.outer(v, v)


def _forward(P: Array, growth: Growth, dt: Array) -> Array:
    """F P for any P ``(15, 15)``, block by block: most of F is zero or one."""
    turn, gyr, acc, velocity, position = (P[3 * i : 3 * i + 3] for i in range(5))
    by_turn, by_gyr, by_acc = growth.push
    pushed = _product(by_turn, turn) + _product(by_gyr, gyr) + _product(by_acc, acc)
    return jnp.concatenate(
        [
            turn + _product(growth.turn, gyr),
            gyr,
            acc,
            velocity + pushed,
            position + dt * velocity + dt / 2 * pushed,
        ]
    )


def _product(A: Array, B: Array) -> Array:
    """A B for A of three columns, as columns times rows: XLA keeps it within the time loop."""
    return A[:, :1] * B[:1] + A[:, 1:2] * B[1:2] + A[:, 2:] * B[2:]


def _times(A: Array, v: Array) -> Array:
    """A v, ``(3,)``."""
    return A[:, 0] * v[0] + A[:, 1] * v[1] + A[:, 2] * v[2]
