"""Strapdown dead reckoning through a block of samples, with the sums that its errors depend on."""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.imu import SixAxes
from filters.rotation import from_rotation_vector, multiply, normalise, or_else, rotate


class Calibration(NamedTuple):
    """A gyroscope's errors: bias, rad/s, ``(3,)``, and matrix ``(3, 3)`` of the rest."""

    bias: Array
    matrix: Array


class Navigation(NamedTuple):
    """Result of dead reckoning: attitude ``(4,)``, velocity and place in earth axes ``(3,)``."""

    q: Array
    speed: Array
    place: Array


class Sums(NamedTuple):
    """Sums over a block of samples, times the sample time, for the error's transition.

    Attributes:
        axes: rotation matrices, ``(3, 3)``.
        force: specific force in earth axes, ``(3,)``.
        turned: columns of the rotation matrix times rates, ``(3, 9)``.
        square: squared rate, ``()``.
        rate: raw rates, ``(3,)``.
    """

    axes: Array
    force: Array
    turned: Array
    square: Array
    rate: Array


class Quiet(NamedTuple):
    """State of the rest detection: low-passed rate and force ``(3,)``, and time at rest, s."""

    rate: Array
    force: Array
    seconds: Array


@dataclass(frozen=True)
class RestRule:
    """The rule for when the sensor is at rest, and how sure that is.

    Attributes:
        memory: time constant of the low pass that samples are compared with, s.
        rate: largest rate, and deviation of it, rad/s.
        force: largest deviation of the specific force, m/s^2.
        seconds: time for which both have to be small.
        speed: root of the density of the speed's measurement at rest, m/s s^1/2.
        bias: the same of the bias's measurement, rad/s s^1/2.
    """

    memory: float = 0.5
    rate: float = 0.0349
    force: float = 0.5
    seconds: float = 1.5
    speed: float = 1e-3
    bias: float = 5e-4


AT_REST = RestRule()
"""The rule for a sensor in the hand or on a body."""


class Reckoning(NamedTuple):
    """Parameters of dead reckoning through a block, and its beginning.

    Attributes:
        gravity: m/s^2, ``()``.
        lead: how far ahead of each sample the attitude is wanted, s, ``()``.
        known: the gyroscopes' errors.
        at: where the block begins.
        quiet: what has been quiet until then.
    """

    gravity: Array
    lead: Array
    known: Calibration
    at: Navigation
    quiet: Quiet


class Reckoned(NamedTuple):
    """The state of dead reckoning within a block."""

    at: Navigation
    sums: Sums
    quiet: Quiet


@dataclass(frozen=True)
class Strapdown:
    """Dead reckoning through a block of samples."""

    dt: float
    rule: RestRule

    def init(self, params: Reckoning) -> Reckoned:
        """The beginning of the block, with nothing summed up."""
        at, quiet = params.at, params.quiet
        zero = jnp.zeros(3, at.q.dtype)
        sums = Sums(jnp.outer(zero, zero), zero, jnp.zeros((3, 9), zero.dtype), zero[0], zero)
        return Reckoned(at, sums, quiet)

    def step(
        self,
        params: Reckoning,
        state: Reckoned,
        inputs: SixAxes,
    ) -> tuple[Reckoned, Array]:
        """Take one sample, and output the attitude, ahead of it by the lead."""
        known = params.known
        (q, speed, place), sums, quiet = state
        inputs = inputs._replace(gyr=or_else(inputs.gyr, known.bias))
        free = inputs.gyr - known.bias
        rate = free - (known.matrix * free).sum(axis=1)
        q = normalise(multiply(q, from_rotation_vector(rate * self.dt)))
        axes = jnp.stack([rotate(q, axis) for axis in jnp.eye(3, dtype=q.dtype)], axis=1)
        down = jnp.zeros(3, q.dtype).at[2].set(params.gravity)
        missing = jnp.isnan(inputs.acc).any()
        a = jnp.where(missing, 0.0, inputs.acc)
        force = jnp.where(missing, down, (axes * a).sum(axis=1))  # then as if nothing pushed
        seen = inputs._replace(acc=jnp.where(missing, quiet.force, a))
        speed = speed + (force - down) * self.dt
        place = place + speed * self.dt
        turned = (axes[:, :, None] * rate).reshape(3, 9)
        grown = Sums(axes, force, turned, rate @ rate, inputs.gyr)
        sums = Sums(*(total + self.dt * part for total, part in zip(sums, grown, strict=True)))
        ahead = multiply(q, from_rotation_vector(rate * params.lead))
        return Reckoned(Navigation(q, speed, place), sums, self._quiet(quiet, seen)), ahead

    def _quiet(self, quiet: Quiet, inputs: SixAxes) -> Quiet:
        rule = self.rule
        share = -jnp.expm1(jnp.asarray(-self.dt / rule.memory, inputs.gyr.dtype))
        rate = quiet.rate + share * (inputs.gyr - quiet.rate)
        force = quiet.force + share * (inputs.acc - quiet.force)
        still = (
            (((inputs.gyr - rate) ** 2).sum() < rule.rate**2)
            & (((inputs.acc - force) ** 2).sum() < rule.force**2)
            & (jnp.abs(rate).max() < rule.rate)
        )
        return Quiet(rate, force, jnp.where(still, quiet.seconds + self.dt, 0.0))
