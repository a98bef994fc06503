"""The mixing filter: roll and pitch from gyroscopes, corrected by accelerometers and the speed.

In a turn the accelerometers show more than gravity. The part due to the turn is subtracted with
the airspeed alone, or with a body velocity that a Kalman filter estimates while the aircraft turns.
Source: You and Lee, Korean, with its equation numbers; docs/you_lee.md tells what is misprinted.
Body axes are forward, right, down; lengths are in any unit, the same in all arguments: the facts
say metres.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.attitude import skew
from filters.declared import Channel, Param
from filters.imu import GRAVITY, XYZ
from filters.kalman import Estimate, predict, update
from filters.small_linalg import matmul
from filters.validate import check_setup

Aid = Literal["none", "airspeed", "velocity"]


class VelocityNoise(NamedTuple):
    """Parameters of the velocity filter (11), (12). Q_k, R_k and P0 share a scale that is free."""

    Q_k: Annotated[
        Array,
        Param(
            "m^2/s^2",
            "variance that enters each component of the velocity in a sample",
            typical=1e-3,
            low=1e-9,
            high=1e3,
            smaller="the velocity follows the accelerometers",
            larger="the velocity follows the airspeed",
            per_sample=True,
        ),
    ]
    R_k: Annotated[Array, Param("m^2/s^2", "variance of the airspeed", typical=1.0)]
    threshold: Annotated[
        Array, Param("rad/s", "length of the measured rates above which it runs", typical=0.05)
    ]
    x0: Annotated[
        Array, Param("m/s", "forward, right, down velocity at the start", typical=0.0, shape=(3,))
    ]
    P0: Annotated[
        Array, Param("m^2/s^2", "variance of each of its components at the start", typical=1.0)
    ]


class PiGains(NamedTuple):
    """Parameters of the mixing filter; ``velocity`` is None where it has no velocity filter."""

    K1: Annotated[
        Array,
        Param(
            "1/s",
            "how fast the angles follow the accelerometers",
            typical=0.1,
            low=1e-4,
            high=1e1,
            smaller="errors of the gyroscopes last longer",
            larger="accelerations come through",
        ),
    ]
    K2: Annotated[
        Array,
        Param(
            "1/s",
            "K1 K2 is how fast the gyroscopes' bias is taken off; 0 for not at all",
            typical=0.01,
            low=1e-6,
            high=1e1,
            smaller="a bias is found later",
            larger="the angles overshoot: less damping",
        ),
    ]
    gravity: Annotated[Array, GRAVITY]
    angles0: Annotated[Array, Param("rad", "roll and pitch at the start", typical=0.0, shape=(2,))]
    velocity: VelocityNoise | None = None


class PiSample(NamedTuple):
    """One sample, body axes forward, right, down; NaN means missing, a rate then stays as it was.

    Lengths may have any unit, if all have it.
    """

    acc: Annotated[
        Array, Channel("m/s^2", "specific force, forward, right, down: -g along z at rest", XYZ)
    ]
    gyr: Annotated[Array, Channel("rad/s", "angular rate about the same axes", XYZ)]
    airspeed: Annotated[Array, Channel("m/s", "airspeed, forward")]


class PiState(NamedTuple):
    """Angles ``(2,)``, integrals of (1) ``(2,)`` in rad/s, last rates ``(3,)``, the velocity."""

    angles: Array
    integral: Array
    rate: Array
    velocity: Estimate | None


class PiOutputs(NamedTuple):
    """The outputs of the filter after a sample; those of a velocity filter are None without one."""

    angles: Annotated[Array, Channel("rad", "roll and pitch", ("roll", "pitch"), "angle")]
    velocity: Annotated[
        Array | None, Channel("m/s", "forward, right, down velocity", XYZ, "detail")
    ]
    running: Annotated[Array | None, Channel("", "whether the velocity filter runs", (), "detail")]


@dataclass(frozen=True)
class PiComplementary:
    """Gyroscopes for fast motion, accelerometers for slow, mixed by K1 and K2 (1).

    An accelerometer attitude that does not exist, because a sample is missing or would need the
    arc sine of more than 1, corrects nothing. All sums are explicit Euler's, as on the machine.

    Attributes:
        dt: sample time, s.
        aid: none (gyroscopes alone), airspeed (10), or velocity (11) to (14).
    """

    dt: float
    aid: Aid = "airspeed"

    params, inputs, outputs = PiGains, PiSample, PiOutputs
    states = {  # noqa: RUF012
        "roll": Channel("rad", "right side down", kind="angle"),
        "pitch": Channel("rad", "nose up", kind="angle"),
        "integral_roll": Channel("rad/s", "what is added to the roll's rate against a bias"),
        "integral_pitch": Channel("rad/s", "what is added to the pitch's rate against a bias"),
    }

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: PiGains) -> PiState:
        """The start."""
        zeros = jnp.zeros(3, params.angles0.dtype)
        velocity = None
        if self.aid == "velocity":
            noise = _noise(params)
            velocity = Estimate(noise.x0, noise.P0 * jnp.eye(3, dtype=noise.x0.dtype))
        return PiState(params.angles0, zeros[:2], zeros, velocity)

    def step(self, params: PiGains, state: PiState, inputs: PiSample) -> tuple[PiState, PiOutputs]:
        """Find the accelerometers' attitude, and move the angles over one sample."""
        rate = jnp.where(jnp.isnan(inputs.gyr), state.rate, inputs.gyr)
        velocity, running, seen = state.velocity, None, jnp.full(2, jnp.nan, rate.dtype)
        if self.aid == "airspeed":
            still = jnp.zeros_like(inputs.airspeed)
            along = jnp.stack([inputs.airspeed, still, still])
            seen = accelerometer_angles(inputs.acc, rate, along, params.gravity)
        elif velocity is not None:
            velocity, running = self._followed(params, state.angles, velocity, inputs, rate)
            seen = accelerometer_angles(inputs.acc, rate, velocity.x, params.gravity)
        exists = ~jnp.isnan(seen)
        apart = jnp.where(exists, jnp.where(exists, seen, 0.0) - state.angles, 0.0)
        pull = params.K1 * apart + state.integral
        angles = state.angles + self.dt * (euler_rates(state.angles, rate) + pull)
        integral = state.integral + self.dt * params.K1 * params.K2 * apart
        state = PiState(angles, integral, rate, velocity)
        return state, PiOutputs(angles, None if velocity is None else velocity.x, running)

    def _followed(
        self,
        params: PiGains,
        angles: Array,
        before: Estimate,
        inputs: PiSample,
        rate: Array,
    ) -> tuple[Estimate, Array]:
        """(11), (12) where the aircraft turns; else u is the airspeed, and v and w stay."""
        noise = _noise(params)
        T, A, one = self.dt, -skew(rate), jnp.eye(3, dtype=rate.dtype)
        known = ~jnp.isnan(inputs.acc).any()
        push = jnp.where(known, inputs.acc, 0.0) + _gravity(angles, params.gravity)
        AA = matmul(A, A)
        ahead = predict(before, one + A * T + AA * (T**2 / 2), noise.Q_k * one)
        ahead = ahead._replace(x=ahead.x + matmul(one * T + A * (T**2 / 2), push))
        moved, _ = update(ahead, one[0], noise.R_k, inputs.airspeed)
        running = (rate @ rate > noise.threshold**2) & known
        along = jnp.where(jnp.isnan(inputs.airspeed), before.x[0], inputs.airspeed)
        held = jnp.concatenate([along[None], before.x[1:]])
        x = jnp.where(running, moved.x, held)
        return Estimate(x, jnp.where(running, moved.P, before.P)), running


def accelerometer_angles(force: Array, rate: Array, velocity: Array, gravity: Array) -> Array:
    """(14): roll and pitch from accelerometers, given a velocity that turns with the body.

    With v = w = 0 it is (10). (14) is printed with q v for q w.

    Args:
        force: specific force, ``(3,)``.
        rate: (p, q, r), rad/s, ``(3,)``.
        velocity: (u, v, w), ``(3,)``.
        gravity: ``()``.

    Returns:
        (phi_a, theta_a), rad, ``(2,)``; NaN where it does not exist, without one in derivatives.

    >>> angles = accelerometer_angles(
    ...     jnp.array([0.5, 0.0, -0.8]), jnp.zeros(3), jnp.zeros(3), jnp.array(1.0)
    ... )
    >>> jnp.degrees(angles).round(6).tolist()
    [0.0, 30.0]
    """
    p, q, r = rate
    # Masked before they are divided: a NaN would reach the derivative by gravity.
    missing = jnp.isnan(force), jnp.isnan(velocity)
    force, (u, v, w) = jnp.where(missing[0], 0.0, force), jnp.where(missing[1], 0.0, velocity)
    theta, level = _arcsin((force[0] + r * v - q * w) / gravity)
    level &= ~(missing[0][0] | missing[1][1] | missing[1][2])
    phi, rolled = _arcsin((r * u - p * w - force[1]) / (gravity * jnp.cos(theta)))
    rolled &= level & ~(missing[0][1] | missing[1][0])
    return jnp.stack([jnp.where(rolled, phi, jnp.nan), jnp.where(level, theta, jnp.nan)])


def euler_rates(angles: Array, rate: Array) -> Array:
    """The rates of (roll, pitch), (2), rad/s, ``(2,)``; pitch must stay below 90 deg.

    Args:
        angles: (roll, pitch), rad, ``(2,)``.
        rate: (p, q, r), rad/s, ``(3,)``.

    >>> euler_rates(jnp.zeros(2), jnp.array([0.1, 0.2, 0.3])).tolist()
    [0.1, 0.2]
    """
    (phi, theta), (p, q, r) = angles, rate
    sine, cosine = jnp.sin(phi), jnp.cos(phi)
    return jnp.stack([p + jnp.tan(theta) * (q * sine + r * cosine), q * cosine - r * sine])


def _noise(params: PiGains) -> VelocityNoise:
    if params.velocity is None:
        raise ValueError("the aid 'velocity' needs a VelocityNoise: PiGains(velocity=...)")
    return params.velocity


def _gravity(angles: Array, gravity: Array) -> Array:
    """(5): gravity in body axes, ``(3,)``."""
    phi, theta = angles
    level = jnp.cos(theta)
    return gravity * jnp.stack([-jnp.sin(theta), jnp.sin(phi) * level, jnp.cos(phi) * level])


def _arcsin(sine: Array) -> tuple[Array, Array]:
    """An arc sine and whether it exists; 0 where it does not. At 1 it would have no derivative."""
    exists = jnp.abs(sine) < 1
    return jnp.arcsin(jnp.where(exists, sine, 0.0)), exists
