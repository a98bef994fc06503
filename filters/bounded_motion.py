"""Attitude of a sensor that stays in a room: strapdown navigation with bounded motion.

External acceleration is no noise that could be averaged over any time one likes: its integrals,
speed and place, stay small. A strapdown navigation whose speed and place are measured to be zero,
loosely, weighs it accordingly, and leaves the accelerometers their say about the vertical.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.attitude import skew
from filters.declared import Channel, Param, components
from filters.imu import ATTITUDE, GRAVITY, LEVEL, XYZ, ImuSample, SixAxes
from filters.kalman import Estimate, predict, update
from filters.protocol import run
from filters.rotation import begun, from_rotation_vector, multiply, normalise
from filters.strapdown import (
    AT_REST,
    Calibration,
    Navigation,
    Quiet,
    Reckoning,
    RestRule,
    Strapdown,
    Sums,
)
from filters.validate import check_setup

SIZE = 21
"""Errors of attitude (3), gyroscope bias, speed, place (3 each), gyroscope matrix (9)."""
_TURN, _BIAS, _SPEED, _PLACE, _MATRIX = (
    slice(i, j) for i, j in ((0, 3), (3, 6), (6, 9), (9, 12), (12, 21))
)


class BoundedMotionNoise(NamedTuple):
    """Parameters of the bounded-motion filter; white noises as roots of their densities.

    As far as the attitude's error shows, all noises share a scale that is free but for the start's
    deviations; the likelihood of the innovations determines it.
    """

    speed: Annotated[
        Array,
        Param(
            "m/s^0.5",
            "of the measurement that the sensor stands still",
            typical=0.3,
            low=1e-3,
            high=1e2,
            smaller="accelerometers show the vertical sooner",
            larger="movements may be faster",
        ),
    ]
    place: Annotated[
        Array,
        Param(
            "m s^0.5",
            "of the measurement that it stays where it was",
            typical=0.2,
            low=1e-3,
            high=1e2,
            smaller="accelerometers show the vertical sooner",
            larger="movements may be wider",
        ),
    ]
    accelerometer: Annotated[
        Array,
        Param(
            "m/s^1.5",
            "white noise of the accelerometers",
            typical=0.03,
            low=1e-4,
            high=1e1,
            smaller="accelerometers are trusted more",
            larger="gyroscopes are trusted more",
            sensor="accelerometer",
        ),
    ]
    gyroscope: Annotated[
        Array,
        Param(
            "rad/s^0.5",
            "white noise of the gyroscopes",
            typical=1e-4,
            low=1e-7,
            high=1e-1,
            smaller="gyroscopes are trusted more",
            larger="accelerometers are trusted more",
            sensor="gyroscope",
        ),
    ]
    turning: Annotated[
        Array,
        Param(
            "s^0.5",
            "noise of the gyroscopes in proportion to the rate",
            typical=5e-4,
            low=1e-6,
            high=1e-1,
            smaller="fast turns are trusted more",
            larger="fast turns are trusted less",
        ),
    ]
    bias: Annotated[
        Array,
        Param(
            "rad/s^1.5",
            "drift of the gyroscopes' bias",
            typical=2e-4,
            low=1e-7,
            high=1e-1,
            smaller="the bias is taken as constant",
            larger="the bias follows faster",
            sensor="gyroscope bias",
        ),
    ]
    matrix0: Annotated[
        Array,
        Param(
            "",
            "deviation of the gyroscopes' scales and misalignments at the start",
            typical=3e-3,
            low=1e-5,
            high=1e-1,
            smaller="scales are taken as calibrated",
            larger="scales are learnt from fast turns",
        ),
    ]
    bias0: Annotated[
        Array, Param("rad/s", "deviation of the gyroscopes' bias at the start", typical=0.02)
    ]
    tilt0: Annotated[Array, Param("rad", "deviation of the attitude at the start", typical=0.03)]
    lead: Annotated[
        Array, Param("s", "how far ahead of the last sample the attitude is wanted", typical=0.0)
    ]
    gravity: Annotated[Array, GRAVITY]
    q0: Annotated[Array, LEVEL]


class BoundedMotionState(NamedTuple):
    """Navigation, calibration, covariance of all errors ``(21, 21)``, and the rest detection."""

    at: Navigation
    known: Calibration
    P: Array
    quiet: Quiet


_NINE = tuple(row + column for row in "xyz" for column in "xyz")
_MEASURED = tuple(f"{what}_{axis}" for what in ("place", "speed", "bias") for axis in XYZ)


class BoundedMotionOutputs(NamedTuple):
    """The outputs of the filter after a sample, or after a block of n, with attitudes ``(n, 4)``.

    No attitude uses a later sample of its block.
    """

    att: Annotated[Array, ATTITUDE]
    bias: Annotated[Array, Channel("rad/s", "bias of the gyroscopes", XYZ)]
    matrix: Annotated[
        Array, Channel("", "scales and misalignments of the gyroscopes less 1", _NINE, "detail")
    ]
    rest: Annotated[Array, Channel("", "whether the sensor is at rest", (), "detail")]
    innovation: Annotated[
        Array,
        Channel("", "what no motion, and at rest the gyroscopes, contradict", _MEASURED, "detail"),
    ]
    variance: Annotated[Array, Channel("", "predicted variances of these", _MEASURED, "detail")]


@dataclass(frozen=True)
class BoundedMotionKalman:
    """An error-state filter of strapdown navigation in a room, from six axes.

    Samples come one by one, or faster in blocks (:func:`blocks`) of a tenth of a second or so,
    rates without gaps: dead reckoning takes every one; the covariance and the pseudo-measurements
    (place and speed are zero; at rest, so is the rate) come once a block.

    Attributes:
        dt: sample time, s.
        rule: when the sensor is at rest.
    """

    dt: float
    rule: RestRule = AT_REST

    params, inputs, outputs = BoundedMotionNoise, SixAxes, BoundedMotionOutputs
    states = (
        components("turn", "rad", "error of the attitude, earth axes", "xyz")
        | components("bias", "rad/s", "error of the gyroscopes' bias", "xyz")
        | components("speed", "m/s", "error of the speed, earth axes", "xyz")
        | components("place", "m", "error of the place, earth axes", "xyz")
        | components("matrix", "", "error of the gyroscopes' scales and axes", _NINE)
    )

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: BoundedMotionNoise) -> BoundedMotionState:
        """The start, at rest at the origin; what quiet samples look like is learnt from them."""
        zero = jnp.zeros(3, params.q0.dtype)
        nine = jnp.repeat(params.matrix0, 9)
        start = jnp.stack(
            [params.tilt0, params.bias0, _START + 0 * params.tilt0, _START + 0 * params.tilt0]
        )
        P = jnp.diag(jnp.concatenate([jnp.repeat(start, 3), nine]) ** 2)
        known = Calibration(zero, jnp.outer(zero, zero))
        quiet = Quiet(zero, zero, zero[0])
        return BoundedMotionState(Navigation(params.q0, zero, zero), known, P, quiet)

    def step(
        self, params: BoundedMotionNoise, state: BoundedMotionState, inputs: SixAxes | ImuSample
    ) -> tuple[BoundedMotionState, BoundedMotionOutputs]:
        """Reckon through a sample or a block, then correct."""
        if inputs.gyr.ndim == 1:
            alone = SixAxes(inputs.acc[None], inputs.gyr[None])
            state, outputs = self.step(params, state, alone)
            return state, outputs._replace(att=outputs.att[0])
        whole = jnp.nan_to_num(inputs.acc).sum(axis=0)
        at = state.at._replace(q=begun(state.at.q, whole))
        reckoning = Reckoning(params.gravity, params.lead, state.known, at, state.quiet)
        samples = SixAxes(inputs.acc, inputs.gyr)
        (at, sums, quiet), att = run(Strapdown(self.dt, self.rule), reckoning, samples)
        span = jnp.maximum(self.dt * inputs.gyr.shape[0], _SHORTEST)
        P = _spread(state.P, params, sums, span)
        rest = quiet.seconds > self.rule.seconds
        seen = self._measured(params, at, sums.rate / span - state.known.bias, rest, span)
        (x, P), innovation, variance = _corrected(P, seen)
        at = Navigation(
            normalise(multiply(from_rotation_vector(x[_TURN]), at.q)),
            at.speed + x[_SPEED],
            at.place + x[_PLACE],
        )
        known = Calibration(
            state.known.bias + x[_BIAS], state.known.matrix + x[_MATRIX].reshape(3, 3)
        )
        return BoundedMotionState(at, known, P, quiet), BoundedMotionOutputs(
            att, known.bias, known.matrix, rest, innovation, variance
        )

    def _measured(
        self, params: BoundedMotionNoise, at: Navigation, bias: Array, rest: Array, span: Array
    ) -> list[tuple[int, Array, Array]]:
        """Index of the error that is measured, its measurement, and the variance."""
        speed = jnp.where(rest, self.rule.speed, params.speed)
        found = [(9 + j, -at.place[j], params.place**2 / span) for j in range(3)]
        found += [(6 + j, -at.speed[j], speed**2 / span) for j in range(3)]
        known = jnp.asarray(self.rule.bias**2 / span, bias.dtype)
        return found + [(3 + j, jnp.where(rest, bias[j], jnp.nan), known) for j in range(3)]


def _corrected(P: Array, seen: list[tuple[int, Array, Array]]) -> tuple[Estimate, Array, Array]:
    """The errors that pseudo-measurements show, with the innovations and their variances."""
    estimate, taken = Estimate(jnp.zeros(SIZE, P.dtype), P), []
    for i, z, r in seen:
        estimate, one = update(estimate, jnp.eye(SIZE, dtype=P.dtype)[i], r, z)
        taken.append(one)
    value, variance, _ = (jnp.stack(part) for part in zip(*taken, strict=True))
    return estimate, value, variance


_SHORTEST = 1e-6
"""Distance in s that two samples at one time are taken to have: densities are divided by it."""
_START = 0.01
"""Deviation of speed and place at the start, m/s and m."""


def blocks(samples: ImuSample, length: int) -> ImuSample:
    """Samples ``(N, ...)`` in blocks ``(N // length, length, ...)``, without an unfinished one.

    >>> blocks(ImuSample(jnp.zeros((10, 3)), jnp.zeros((10, 3))), 4).gyr.shape
    (2, 4, 3)
    """
    cut: ImuSample = jax.tree.map(lambda leaf: _cut(leaf, length), samples)
    return cut


def _cut(leaf: Array, length: int) -> Array:
    count = leaf.shape[0] // length
    return leaf[: count * length].reshape(count, length, *leaf.shape[1:])


def _spread(P: Array, params: BoundedMotionNoise, sums: Sums, span: Array) -> Array:
    """The covariance after a block, ``(21, 21)``; attitude errors are in earth axes."""
    one, push = jnp.eye(3, dtype=P.dtype), skew(sums.force)
    F = jnp.eye(SIZE, dtype=P.dtype)
    F = F.at[_TURN, _BIAS].set(-sums.axes).at[_TURN, _MATRIX].set(-sums.turned)
    # The attitude's error grows through the block: half of it acts on the speed.
    F = F.at[_SPEED, _TURN].set(-push).at[_SPEED, _BIAS].set(push @ sums.axes / 2)
    F = F.at[_SPEED, _MATRIX].set(push @ sums.turned / 2)
    F = F.at[_PLACE, _TURN].set(-span / 2 * push).at[_PLACE, _SPEED].set(span * one)
    turn = params.gyroscope**2 * span + params.turning**2 * sums.square
    densities = jnp.stack([turn, params.bias**2 * span, params.accelerometer**2 * span, 0 * turn])
    W = jnp.diag(jnp.concatenate([jnp.repeat(densities, 3), jnp.zeros(9, turn.dtype)]))
    return predict(Estimate(P[0], P), F, W).P
