"""Inertial navigation with an error-state Kalman filter and any aiding sensors.

Attitude, velocity and position come from gyroscopes and accelerometers; other measurements
correct them, and both sensors' biases.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.ins_aiding import (
    Aid,
    field_direction,
    forward_speed,
    height,
    level_part,
    pace,
    place,
    standstill,
    taken,
)
from filters.ins_facts import STATES, InsNoise, InsOutputs, InsSample
from filters.ins_motion import POSITION, SIZE, Densities, Motion, corrected, moved, spread
from filters.rotation import from_rotation_vector, level, multiply
from filters.validate import check_setup


class InsState(NamedTuple):
    """The state of the filter between samples.

    Attributes:
        at: the motion.
        P: covariance of its errors, ``(15, 15)``.
        gyr: the last rate, ``(3,)``.
        acc: the last specific force, ``(3,)``.
        fixed: 1 where a measurement has begun the position's axis, else 0, ``(3,)``.
    """

    at: Motion
    P: Array
    gyr: Array
    acc: Array
    fixed: Array


@dataclass(frozen=True)
class ErrorStateIns:
    """An inertial navigation filter of 15 error states, with any aiding sensors.

    It begins at the first complete sample of the accelerometers, at rest or nearly so. They show
    which way is up; the magnetometer or the parameter ``heading`` gives the heading. Measurements
    are taken one after another, all linearised at the prediction; the estimated error then corrects
    the motion. Without a magnetometer the heading becomes known by accelerations that the aiding
    shows. The earth is flat and does not rotate. Source: Solà, Quaternion kinematics for the
    error-state Kalman filter, 2017, ch. 7, with errors of attitude in the earth frame.

    Attributes:
        dt: sample time, s.
        frame: enu: earth x east, y north, z up; the accelerometers show +g along the sensor's z in
            level rest. ned: earth x north, y east, z down; sensor forward, right, down, -g along z.

    >>> from filters import assembled, parameter_facts, run
    >>> typical = {name: fact.typical for name, fact in parameter_facts(ErrorStateIns).items()}
    >>> at_rest = InsSample(jnp.zeros((50, 3)), jnp.tile(jnp.array([0.0, 0.0, 9.80665]), (50, 1)))
    >>> aided = at_rest._replace(baro=jnp.full(50, 2.0))
    >>> out = run(ErrorStateIns(dt=0.02), assembled(ErrorStateIns, typical), aided)[1]
    >>> out.position[-1].round(2).tolist()
    [0.0, 0.0, 2.0]
    """

    params = InsNoise
    inputs = InsSample
    states = STATES
    outputs = InsOutputs

    dt: float
    frame: Literal["enu", "ned"] = "enu"

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: InsNoise) -> InsState:
        """The start: without attitude, at the origin."""
        zero = jnp.zeros(3, params.tilt0.dtype)
        tilts = [params.tilt0, params.tilt0, params.heading0]
        rest = [params.gyr_bias0, params.acc_bias0, params.velocity0, params.position0]
        P = jnp.diag(jnp.concatenate([jnp.stack(tilts), jnp.repeat(jnp.stack(rest), 3)]) ** 2)
        unknown = Motion(jnp.zeros(4, zero.dtype), zero, zero, zero, zero)
        return InsState(unknown, P, zero, zero, zero)

    def step(
        self, params: InsNoise, state: InsState, inputs: InsSample
    ) -> tuple[InsState, InsOutputs]:
        """Navigate through the sample, then take the measurements at its end."""
        gyr = jnp.where(jnp.isnan(inputs.gyr), state.gyr, inputs.gyr)
        acc = jnp.where(jnp.isnan(inputs.acc), state.acc, inputs.acc)
        going = state.at.q @ state.at.q > 0
        live = going | (~jnp.isnan(inputs.acc).any() & (acc @ acc > 0))
        up = self._up * jnp.array([0.0, 0.0, 1.0], gyr.dtype)
        first = self._first(params, jnp.where(live, acc, up), inputs.mag)
        at = state.at._replace(q=jnp.where(going, state.at.q, first))
        dt = jnp.where(going, jnp.asarray(self.dt, gyr.dtype), 0.0)
        at, growth = moved(at, gyr, acc, params.gravity * up, dt)
        P = spread(state.P, growth, Densities(*params[:4]), dt)
        seen = _at_once(inputs, going, live)
        begun = _placed(
            state._replace(at=at, P=P, gyr=gyr, acc=acc), *self._first_place(params, seen)
        )
        seen = _without_first(seen, begun.fixed > state.fixed)
        brought = taken(begun.P, self._aids(params, begun.at, seen))
        at = corrected(begun.at, brought.x)
        kept = at._replace(q=jnp.where(live, at.q, 0.0))
        outputs = InsOutputs(*at, brought.innovation, brought.variance, brought.P)
        return begun._replace(at=kept, P=brought.P), outputs

    @property
    def _up(self) -> float:
        """The sign of up along z, of the earth and of a level sensor."""
        return 1.0 if self.frame == "enu" else -1.0

    def _bearing(self, compass: Array) -> Array:
        """A compass direction as the angle about earth z from earth x, rad."""
        return jnp.pi / 2 - compass if self.frame == "enu" else compass

    def _first(self, params: InsNoise, acc: Array, mag: Array | None) -> Array:
        """The attitude at the start, ``(4,)``."""
        z = jnp.array([0.0, 0.0, 1.0], acc.dtype)
        q = level(acc * self._up)
        turn = self._bearing(params.heading)
        if mag is not None:
            seen, (x, y, _) = level_part(q, mag)
            north = self._bearing(params.declination)
            turn = jnp.where(seen, north - jnp.arctan2(y, x), turn)
        return multiply(from_rotation_vector(turn * z), q)

    def _first_place(self, params: InsNoise, seen: InsSample) -> tuple[Array, Array]:
        """Measurement that may begin the position, and its variances: GPS, else the barometer."""
        if seen.gps is not None:
            return seen.gps, jnp.stack([params.R_gps, params.R_gps, params.R_gps_up])
        unknown = jnp.full(2, jnp.nan, params.R_baro.dtype)
        z = unknown[:1] if seen.baro is None else (self._up * seen.baro)[None]
        return jnp.concatenate([unknown, z]), jnp.broadcast_to(params.R_baro, (3,))

    def _aids(self, params: InsNoise, at: Motion, seen: InsSample) -> list[Aid | None]:
        """The measurements, in the order of AIDS."""
        missing: list[Aid | None] = [None, None, None]
        gps, vel, baro, speed, mag, still = seen[2:]
        level_up = params.R_gps, params.R_gps_up
        north = self._bearing(params.declination)
        return [
            *(missing if gps is None else place(level_up, at, gps)),
            *(missing if vel is None else pace(params.R_gps_vel, at, vel)),
            None if baro is None else height(params.R_baro, at, self._up * baro),
            None if speed is None else forward_speed(params.R_speed, at, speed),
            None if mag is None else field_direction(params.R_mag, at, mag, north),
            *(missing if still is None else standstill(params.R_still, at, still)),
        ]


def _at_once(inputs: InsSample, going: Array, live: Array) -> InsSample:
    """The aiding that counts at this sample: none before the start, and the field not at it,
    where it has given the heading."""
    gates = dict.fromkeys(("gps", "gps_vel", "baro", "speed", "still"), live) | {"mag": going}
    given = {name: getattr(inputs, name) for name in gates}
    return inputs._replace(
        **{
            name: jnp.where(gates[name], value, jnp.nan)
            for name, value in given.items()
            if value is not None
        }
    )


def _placed(state: InsState, place: Array, R: Array) -> InsState:
    """A first position begins the motion's, axis by axis, with its own variance."""
    begins = (state.fixed == 0) & ~jnp.isnan(place)
    keep = jnp.ones(SIZE, R.dtype).at[POSITION].set(jnp.where(begins, 0.0, 1.0))
    new = jnp.zeros(SIZE, R.dtype).at[POSITION].set(jnp.where(begins, R, 0.0))
    return state._replace(
        at=state.at._replace(position=jnp.where(begins, place, state.at.position)),
        P=state.P * jnp.outer(keep, keep) + jnp.diag(new),
        fixed=jnp.where(begins, 1.0, state.fixed),
    )


def _without_first(seen: InsSample, began: Array) -> InsSample:
    """The coordinates left to be taken: those that did not just begin the position, ``(3,)``."""
    if seen.gps is not None:
        return seen._replace(gps=jnp.where(began, jnp.nan, seen.gps))
    if seen.baro is not None:
        return seen._replace(baro=jnp.where(began[2], jnp.nan, seen.baro))
    return seen
