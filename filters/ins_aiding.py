"""Aiding of an INS filter: every measured number as a row, a variance and a difference."""

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.angles import wrapped
from filters.ins_motion import POSITION, SIZE, TURN, VELOCITY, Motion, matrix
from filters.kalman import Estimate, update_large
from filters.rotation import cross

AIDS = (
    *(f"gps_{axis}" for axis in "xyz"),
    *(f"gps_vel_{axis}" for axis in "xyz"),
    "baro",
    "speed",
    "mag",
    *(f"still_{axis}" for axis in "xyz"),
)
"""The measured numbers, in the order in which they are taken and stand in the outputs."""


class Aid(NamedTuple):
    """One measured number.

    Attributes:
        row: its derivative by the errors, ``(15,)``, or the index of the error that it measures.
        R: its variance, ``()``.
        apart: measured less expected, NaN where it is missing, ``()``.
    """

    row: Array | int
    R: Array
    apart: Array


class Brought(NamedTuple):
    """The error that a sample's measurements show.

    Attributes:
        x: the estimated error, ``(15,)``.
        P: its covariance, ``(15, 15)``.
        innovation: of :data:`AIDS`, ``(12,)``; 0 where nothing was measured.
        variance: of the innovations, ``(12,)``; likewise.
    """

    x: Array
    P: Array
    innovation: Array
    variance: Array


def place(R: tuple[Array, Array], at: Motion, gps: Array) -> list[Aid]:
    """A position, with the variances of its level parts and of its height."""
    apart = gps - at.position
    return [Aid(POSITION.start + i, R[i // 2], apart[i]) for i in range(3)]


def pace(R: Array, at: Motion, velocity: Array) -> list[Aid]:
    """A velocity in earth axes."""
    apart = velocity - at.velocity
    return [Aid(VELOCITY.start + i, R, apart[i]) for i in range(3)]


def standstill(R: Array, at: Motion, still: Array) -> list[Aid]:
    """No velocity, where the flag is 1."""
    return pace(R, at, jnp.where(still > 0.5, jnp.zeros_like(at.velocity), jnp.nan))


def height(R: Array, at: Motion, z: Array) -> Aid:
    """A height, as earth's z."""
    return Aid(POSITION.stop - 1, R, z - at.position[2])


def forward_speed(R: Array, at: Motion, speed: Array) -> Aid:
    """The velocity along the sensor's x axis."""
    forward = matrix(at.q)[:, 0]
    row = jnp.zeros(SIZE, at.q.dtype)
    row = row.at[TURN].set(cross(forward, at.velocity)).at[VELOCITY].set(forward)
    return Aid(row, R, speed - forward @ at.velocity)


def field_direction(R: Array, at: Motion, mag: Array, north: Array) -> Aid:
    """The direction of the magnetic field's level part, anticlockwise about earth z from its x.

    Only that is taken: the field's dip and strength need not be known, and do not disturb the
    tilt, but for the little by which a tilt turns the level part.
    """
    seen, (x, y, z) = level_part(at.q, mag)
    square = x**2 + y**2
    turn = jnp.stack([-x * z / square, -y * z / square, jnp.ones_like(x)])
    row = jnp.zeros(SIZE, at.q.dtype).at[TURN].set(turn)
    return Aid(row, R, jnp.where(seen, wrapped(north - jnp.arctan2(y, x)), jnp.nan))


def level_part(q: Array, mag: Array) -> tuple[Array, Array]:
    """Whether a field has a level part, and the field in earth axes: any other where not."""
    field = (matrix(q) * jnp.where(jnp.isnan(mag), 0.0, mag)).sum(axis=1)
    seen = ~jnp.isnan(mag).any() & (field[0] ** 2 + field[1] ** 2 > 0)
    return seen, jnp.where(seen, field, jnp.array([1.0, 0.0, 0.0], q.dtype))


def taken(P: Array, aids: Sequence[Aid | None]) -> Brought:
    """Take measured numbers one after another; None stands for one that has no channel."""
    estimate = Estimate(jnp.zeros(SIZE, P.dtype), P)
    none = jnp.zeros((), P.dtype)
    found = []
    for aid in aids:
        if aid is None:
            found.append((none, none))
            continue
        estimate, new = update_large(estimate, aid.row, aid.R, aid.apart)
        found.append((new.value, new.variance))
    innovation, variance = (jnp.stack(part) for part in zip(*found, strict=True))
    return Brought(estimate.x, estimate.P, innovation, variance)
