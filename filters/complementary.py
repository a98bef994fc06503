"""Complementary filters with one or two gains: of first order, Mahony's and Madgwick's."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.declared import Channel, Param, components
from filters.imu import ATTITUDE, LEVEL, ImuSample
from filters.rotation import (
    begun,
    cross,
    from_rotation_vector,
    multiply,
    normalise,
    or_else,
    rotate,
    rotate_back,
)
from filters.validate import check_setup

UP = (0.0, 0.0, 1.0)


class ComplementaryGain(NamedTuple):
    """The gain of a first-order complementary filter."""

    tau: Annotated[
        Array,
        Param(
            "s",
            "time constant: rates count for what is faster, angles for what is slower",
            typical=1.0,
            low=1e-3,
            high=1e3,
            smaller="noise and disturbances of the angle come through",
            larger="a bias b of the rate leaves an error of tau b",
        ),
    ]
    angle0: Annotated[Array, Param("rad", "angle at the start", typical=0.0)]


class AngleSample(NamedTuple):
    """A rate and an angle of the same shape; NaN is missing, a rate then 0."""

    rate: Annotated[Array, Channel("rad/s", "angular rate")]
    angle: Annotated[Array, Channel("rad", "measured angle", kind="angle")]


@dataclass(frozen=True)
class Complementary:
    """One angle, or several independent ones, from its rate and a measurement of itself.

    a (angle + rate dt) + (1 - a) measured with a = tau / (tau + dt): stable for every tau. A bias
    of the rate leaves an error of tau times the bias. The mixing filter with K1 = 1/tau and K2 = 0
    is the same but for terms of dt/tau.

    Attributes:
        dt: sample time, s.
    """

    dt: float

    params, inputs = ComplementaryGain, AngleSample
    states = outputs = {"angle": Channel("rad", "estimated angle", kind="angle")}  # noqa: RUF012

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: ComplementaryGain) -> Array:
        """The start."""
        return params.angle0

    def step(
        self, params: ComplementaryGain, state: Array, inputs: AngleSample
    ) -> tuple[Array, Array]:
        """Integrate the rate, and go a share of the way to the measured angle."""
        ahead = state + or_else(inputs.rate, jnp.zeros_like(inputs.rate)) * self.dt
        apart = jnp.where(jnp.isnan(inputs.angle), 0.0, inputs.angle - ahead)
        angle = ahead + self.dt / (params.tau + self.dt) * apart
        return angle, angle


class MahonyGains(NamedTuple):
    """Gains of Mahony's filter."""

    Kp: Annotated[
        Array,
        Param(
            "1/s",
            "how fast the attitude follows gravity and field",
            typical=0.74,
            low=1e-3,
            high=1e2,
            smaller="errors of the gyroscopes last longer",
            larger="accelerations and disturbed fields come through",
        ),
    ]
    Ki: Annotated[
        Array,
        Param(
            "1/s^2",
            "how fast the bias follows",
            typical=0.0012,
            low=1e-7,
            high=1e1,
            smaller="a bias is found later",
            larger="the bias follows accelerations, and overshoots",
        ),
    ]
    q0: Annotated[Array, LEVEL]


class MahonyState(NamedTuple):
    """Attitude ``(4,)`` and the bias that is added to the rates, rad/s, ``(3,)``."""

    q: Array
    push: Array


@dataclass(frozen=True)
class Mahony:
    """The explicit complementary filter with bias; with a field it knows the heading too.

    Source: Mahony, Hamel and Pflimlin, IEEE Trans. Automatic Control 53(5), 2008, (48). The field
    is compared by its horizontal direction in the estimated attitude, earth y being north.

    Attributes:
        dt: sample time, s.
    """

    dt: float

    params, inputs, outputs = MahonyGains, ImuSample, {"att": ATTITUDE}
    states = components("q", "", "attitude, sensor to earth", "wxyz") | components(
        "push", "rad/s", "what is added to the rates against their bias", "xyz"
    )

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: MahonyGains) -> MahonyState:
        """The start, without bias."""
        return MahonyState(params.q0, jnp.zeros(3, params.q0.dtype))

    def step(
        self, params: MahonyGains, state: MahonyState, inputs: ImuSample
    ) -> tuple[MahonyState, Array]:
        """Compare directions, turn, and output the attitude ``(4,)``."""
        q = begun(state.q, inputs.acc)
        error = _apart(q, inputs.acc, jnp.array(UP, inputs.acc.dtype))
        if inputs.mag is not None:
            level = rotate(q, _seen(inputs.mag))
            north = jnp.stack([jnp.zeros_like(level[2]), jnp.hypot(level[0], level[1]), level[2]])
            error = error + _apart(q, inputs.mag, normalise(north))
        push = state.push + params.Ki * self.dt * error
        rate = or_else(inputs.gyr, -push) + params.Kp * error + push
        q = normalise(multiply(q, from_rotation_vector(rate * self.dt)))
        return MahonyState(q, push), q


class MadgwickGain(NamedTuple):
    """The gain of Madgwick's filter."""

    beta: Annotated[
        Array,
        Param(
            "rad/s",
            "how fast the attitude follows gravity and field",
            typical=0.12,
            low=1e-4,
            high=1e1,
            smaller="errors of the gyroscopes last longer; below their bias the attitude drifts",
            larger="accelerations and disturbed fields come through",
        ),
    ]
    q0: Annotated[Array, LEVEL]


@dataclass(frozen=True)
class Madgwick:
    """A gradient step of constant length towards gravity, and the field where it is given.

    Source: Madgwick, Harrison and Vaidyanathan, IEEE Int. Conf. Rehabilitation Robotics, 2011.

    Attributes:
        dt: sample time, s.
    """

    dt: float

    params, inputs, outputs = MadgwickGain, ImuSample, {"att": ATTITUDE}
    states = components("q", "", "attitude, sensor to earth", "wxyz")

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: MadgwickGain) -> Array:
        """The start."""
        return params.q0

    def step(self, params: MadgwickGain, state: Array, inputs: ImuSample) -> tuple[Array, Array]:
        """Turn by the gyroscopes less the gradient step, and output the attitude ``(4,)``."""
        state = begun(state, inputs.acc)
        slope = _slope(state, inputs.acc, jnp.array(UP, inputs.acc.dtype))
        if inputs.mag is not None:
            level = rotate(state, _seen(inputs.mag))
            north = jnp.stack([jnp.zeros_like(level[2]), jnp.hypot(level[0], level[1]), level[2]])
            slope = slope + _slope(state, inputs.mag, normalise(north))
        # Where no error is left, the slope is rounding without a direction: it makes no step.
        none = jnp.finfo(slope.dtype).eps ** 0.75
        length = jnp.sqrt(slope @ slope + none**2)
        still = jnp.zeros_like(inputs.gyr)
        rate = jnp.concatenate([still[:1], or_else(inputs.gyr, still)])
        moved = multiply(state, rate) / 2
        q = normalise(state + self.dt * (moved - params.beta * slope / length))
        return q, q


def _apart(q: Array, measured: Array, direction: Array) -> Array:
    """Measured direction x expected one, in sensor coordinates; 0 where nothing is measured."""
    unit, _ = _unit(measured)
    return cross(unit, rotate_back(q, direction))


def _unit(measured: Array) -> tuple[Array, Array]:
    """Direction of a vector, and whether it has one: not where it is 0, infinite or NaN."""
    size = jnp.sqrt(measured @ measured)
    seen = (size > 0) & (size < jnp.inf)
    return jnp.where(seen, measured, 0.0) / jnp.where(seen, size, 1.0), seen


def _seen(field: Array) -> Array:
    """The field, or some other where it has no direction: it must not be NaN on its way."""
    return jnp.where(_unit(field)[1], field, jnp.array([0.0, 1.0, 0.0], field.dtype))


def _slope(q: Array, measured: Array, direction: Array) -> Array:
    """Gradient of abs(q* direction q - measured)^2 / 2 by the four entries of q."""
    unit, seen = _unit(measured)
    expected, pull = jax.vjp(lambda q: rotate_back(q, direction), q)
    slope: Array
    (slope,) = pull(jnp.where(seen, expected - unit, 0.0))
    return slope
