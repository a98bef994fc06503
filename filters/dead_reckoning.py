"""Position from speed and attitude, and attitude from positions: Chauhan et al. 2009, section 5.

Axes are north, east, down, those of the body forward, right, down; a body at rest measures -g down.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.declared import Channel, Param
from filters.kalman import Estimate, Innovation, update
from filters.small_linalg import matmul
from filters.validate import check_setup

NED = ("north", "east", "down")


class DeadReckoningNoise(NamedTuple):
    """Parameters of the position filter."""

    R_horizontal: Annotated[
        Array,
        Param(
            "m^2",
            "variance of the measured position, north and east",
            typical=4.0,
            low=1e-4,
            high=1e4,
            smaller="the track follows the measured positions",
            larger="speed and attitude are trusted longer",
        ),
    ]
    R_down: Annotated[
        Array,
        Param(
            "m^2",
            "variance of the measured position, down",
            typical=9.0,
            low=1e-4,
            high=1e4,
            smaller="the height follows the measured one",
            larger="speed and attitude are trusted longer",
        ),
    ]
    Q_speed: Annotated[
        Array,
        Param(
            "m^2/s",
            "density of the noise of the speed",
            typical=0.5,
            low=1e-6,
            high=1e3,
            smaller="the speed is trusted more",
            larger="the track follows the measured positions",
        ),
    ]
    Q_tilt: Annotated[
        Array,
        Param(
            "rad^2 s",
            "density of the noise of roll and pitch",
            typical=1e-3,
            low=1e-9,
            high=1e1,
            smaller="the pitch is trusted more",
            larger="the height follows the measured one",
        ),
    ]
    Q_heading: Annotated[
        Array,
        Param(
            "rad^2 s",
            "density of the noise of the heading",
            typical=4e-3,
            low=1e-9,
            high=1e1,
            smaller="the heading is trusted more",
            larger="the track follows the measured positions",
        ),
    ]
    x0: Annotated[Array, Param("m", "position at the start", typical=0.0, shape=(3,))]
    P0: Annotated[Array, Param("m^2", "variance of each coordinate at the start", typical=100.0)]

    @property
    def R(self) -> Array:
        """Variances of the measured position, ``(3,)``."""
        return jnp.stack([self.R_horizontal, self.R_horizontal, self.R_down])

    @property
    def Q(self) -> Array:
        """Density of the noise of (V, phi, theta, psi), ``(4, 4)``."""
        return jnp.diag(jnp.stack([self.Q_speed, self.Q_tilt, self.Q_tilt, self.Q_heading]))


class DeadReckoningSample(NamedTuple):
    """One tick's inputs; stacked along time for :func:`filters.run`; a missing position is NaN."""

    speed: Annotated[Array, Channel("m/s", "along the body's forward axis")]
    angles: Annotated[
        Array, Channel("rad", "roll, pitch and yaw", ("roll", "pitch", "yaw"), "angle")
    ]
    position: Annotated[Array, Channel("m", "measured position", NED)]


class DeadReckoningOutputs(NamedTuple):
    """The outputs of the filter after a tick; innovations are one coordinate after another."""

    position: Annotated[Array, Channel("m", "estimated position", NED)]
    P: Annotated[Array, Channel("m^2", "its covariance", NED, "detail")]
    innovation: Annotated[
        Array, Channel("m", "measured positions less what is predicted", NED, "detail")
    ]
    variance: Annotated[Array, Channel("m^2", "predicted variances of these", NED, "detail")]


@dataclass(frozen=True)
class DeadReckoningKalman:
    """Dead reckoning by speed and attitude, corrected by positions: (12) to (16).

    Attributes:
        dt: time between ticks, s.
    """

    dt: float

    params, inputs, outputs = DeadReckoningNoise, DeadReckoningSample, DeadReckoningOutputs
    states = {axis: Channel("m", f"position, {axis}") for axis in NED}  # noqa: RUF012

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: DeadReckoningNoise) -> Estimate:
        """The start."""
        return Estimate(params.x0, params.P0 * jnp.eye(3, dtype=params.x0.dtype))

    def step(
        self, params: DeadReckoningNoise, state: Estimate, inputs: DeadReckoningSample
    ) -> tuple[Estimate, DeadReckoningOutputs]:
        """Move on along the axis, and take the measurements."""
        G = track_jacobian(inputs.speed, inputs.angles)
        x = state.x + self.dt * inputs.speed * G[:, 0]
        estimate = Estimate(x, state.P + self.dt * matmul(matmul(G, params.Q), G.T))
        taken: list[Innovation] = []
        R = params.R
        for i, axis in enumerate(jnp.eye(3, dtype=x.dtype)):
            estimate, one = update(estimate, axis, R[i], inputs.position[i])
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
