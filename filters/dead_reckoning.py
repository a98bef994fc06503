"""Position from speed and attitude, and attitude from positions: Chauhan et al. 2009, section 5.

Axes are north, east, down, those of the body forward, right, down; a body at rest measures -g down.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.kalman import Estimate, Innovation, matmul, update
from filters.validate import check_setup


class DeadReckoningNoise(NamedTuple):
    """What the position filter takes.

    Attributes:
        R: variances of the measured position, m^2, ``(3,)``.
        Q: density of the noise of (V, phi, theta, psi), ``(4, 4)``.
        x0: position at the start, m, ``(3,)``.
        P0: its covariance, ``(3, 3)``.
    """

    R: Array
    Q: Array
    x0: Array
    P0: Array


class DeadReckoningSample(NamedTuple):
    """One tick's inputs; stacked along time for :func:`filters.run`.

    Attributes:
        speed: V along the body's forward axis, m/s, ``()``.
        angles: (phi, theta, psi), rad, ``(3,)``.
        z: measured position, m, ``(3,)``; NaN means missing.
    """

    speed: Array
    angles: Array
    z: Array


class DeadReckoningOutputs(NamedTuple):
    """Position ``(3,)``, its covariance ``(3, 3)``, and the innovations one after another."""

    x: Array
    P: Array
    innovation: Array
    variance: Array


@dataclass(frozen=True)
class DeadReckoningKalman:
    """Dead reckoning by speed and attitude, corrected by positions: (12) to (16).

    Attributes:
        dt: time between ticks, s.
    """

    dt: float

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: DeadReckoningNoise) -> Estimate:
        """The start."""
        return Estimate(params.x0, params.P0)

    def step(
        self, params: DeadReckoningNoise, state: Estimate, inputs: DeadReckoningSample
    ) -> tuple[Estimate, DeadReckoningOutputs]:
        """Move on along the axis, and take what is measured."""
        G = track_jacobian(inputs.speed, inputs.angles)
        x = state.x + self.dt * inputs.speed * G[:, 0]
        estimate = Estimate(x, state.P + self.dt * matmul(matmul(G, params.Q), G.T))
        taken: list[Innovation] = []
        for i, axis in enumerate(jnp.eye(3, dtype=x.dtype)):
            estimate, one = update(estimate, axis, params.R[i], inputs.z[i])
            taken.append(one)
        value = jnp.stack([one.value for one in taken])
        variance = jnp.stack([one.variance for one in taken])
        return estimate, DeadReckoningOutputs(estimate.x, estimate.P, value, variance)


def track_jacobian(speed: Array, angles: Array) -> Array:
    """G: of the velocity by (V, phi, theta, psi), ``(3, 4)``; its first column is the direction."""
    (_, ct, cp), (_, st, sp) = jnp.cos(angles), jnp.sin(angles)
    zero = jnp.zeros((), angles.dtype)
    rows = [
        [ct * cp, zero, -speed * st * cp, -speed * ct * sp],
        [ct * sp, zero, -speed * st * sp, speed * ct * cp],
        [-st, zero, -speed * ct, zero],
    ]
    return jnp.stack([entry for row in rows for entry in row]).reshape(3, 4)


def constructed_attitude(
    positions: Array, acceleration: Array, *, dt: float, gravity: float, slowest: float = 0.0
) -> Array:
    """(phi, theta, psi) at the second of three positions, from them and the accelerometers.

    The heading is the track's, so that there is no sideslip; at rest there is no track.

    Args:
        positions: p1, p2, p3, ``dt`` apart, m, ``(3, 3)``.
        acceleration: specific force, averaged over the same 2 dt, m/s^2, ``(3,)``.
        dt: s.
        gravity: m/s^2.
        slowest: speed over ground up to which the body counts as at rest, m/s.

    Returns:
        ``(3,)``, NaN where it is not defined: at rest, or where the forward force is larger than
        the positions allow.

    >>> level = jnp.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [6.0, 0.0, 0.0]])
    >>> still = constructed_attitude(level, jnp.array([0.0, 0.0, -9.81]), dt=1.0, gravity=9.81)
    >>> (still + 0.0).tolist()
    [0.0, 0.0, 0.0]
    """
    steps = jnp.diff(positions, axis=0) / dt
    v, (fx, fy, fz) = steps.mean(axis=0), (steps[1] - steps[0]) / dt
    moving = jnp.hypot(v[0], v[1]) > slowest
    psi = jnp.arctan2(v[1], jnp.where(moving, v[0], 1.0))
    c, s = jnp.cos(psi), jnp.sin(psi)
    # What a level body with that heading would measure.
    rx, ry, rz = c * fx + s * fy, c * fy - s * fx, fz - gravity
    ax, ay, az = acceleration
    sine = ax / jnp.hypot(rx, rz)
    theta = jnp.arcsin(jnp.clip(sine, -1.0, 1.0)) - jnp.arctan2(rx, -rz)
    down = rx * jnp.sin(theta) + rz * jnp.cos(theta)
    phi = jnp.arctan2(ay * down - az * ry, ay * ry + az * down)
    defined = moving & (jnp.abs(sine) <= 1)
    return jnp.where(defined, jnp.stack([phi, theta, psi]), jnp.nan)
