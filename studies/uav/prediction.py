"""Positions predicted from speed and attitude, held against the GPS's."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import assembled, parameter_facts, run
from filters.dead_reckoning import DeadReckoningKalman, DeadReckoningNoise, DeadReckoningSample
from filters.gps_aided import GpsAidedKalman, GpsAidedNoise, GpsAidedSample
from studies.uav.flights import Flight
from studies.uav.judging import Outcome

AHEAD = 5
"""Longest horizon, s."""
MOST = 512
"""Most predictions on one flight, taken at even distances."""


class Predicted(NamedTuple):
    """Errors of B predictions 1 to 5 s ahead, m.

    Attributes:
        horizontal: by the filter's attitude, ``(B, 5)``.
        vertical: by the same, down positive, ``(B, 5)``.
        straight: horizontal ones of a straight line on, ``(B, 5)``.
        reference: horizontal ones by the autopilot's attitude, ``(B, 5)``; None without it.
        glitch: whether the GPS was not trusted meanwhile, ``(B,)``.
    """

    horizontal: np.ndarray
    vertical: np.ndarray
    straight: np.ndarray
    reference: np.ndarray | None
    glitch: np.ndarray


def predicted(flight: Flight, outcome: Outcome) -> Predicted:
    """The prediction from all that is known at a time t0, and from gyroscopes and speed after it.

    The last measured attitude is that of t0 - 1 s, for it needs the position at t0. From there on
    gyroscopes less their estimated bias turn it; from t0 on the speed, which the GPS tells, moves
    the position along the body's axis. The straight line takes the same speed along the last
    displacement.
    """
    last, n = starts(flight), (1 + AHEAD) * flight.every
    ticks = last[:, None] + 1 + np.arange(n)
    rates = flight.rate[ticks]
    angles = _attitudes(flight, outcome.x[last], rates)[:, flight.every :]
    ahead = ticks[:, flight.every :]
    p0 = flight.position[last + flight.every]
    speed = flight.speed[ahead]
    seconds = slice(flight.every - 1, None, flight.every)
    truth = flight.position[ahead][:, seconds]
    error = _tracks(flight, p0, speed, angles)[:, seconds] - truth
    moved = p0 - flight.position[last]
    length = np.linalg.norm(moved, axis=1, keepdims=True)
    line = (
        p0[:, None]
        + (np.cumsum(speed, axis=1) * flight.dt)[:, seconds, None]
        * (moved / np.where(length > 0, length, 1.0))[:, None]
    )
    reference = None
    if flight.reference is not None:
        by_pilot = _tracks(flight, p0, speed, flight.reference[ahead])[:, seconds]
        reference = _flat(by_pilot - truth)
    return Predicted(
        horizontal=_flat(error),
        vertical=error[..., 2],
        straight=_flat(line - truth),
        reference=reference,
        glitch=np.asarray(flight.glitch[ticks].any(axis=1)),
    )


def starts(flight: Flight) -> np.ndarray:
    """Ticks of measured attitudes with all positions and speeds known for as long as needed."""
    last = np.flatnonzero(~np.isnan(flight.z).all(axis=1))
    last = last[last + (1 + AHEAD) * flight.every < len(flight.t)]
    known = ~np.isnan(flight.position).any(axis=1) & ~np.isnan(flight.speed)
    ticks = last[:, None] + np.arange((1 + AHEAD) * flight.every + 1)
    last = last[known[ticks].all(axis=1)]
    evenly = np.linspace(0, len(last) - 1, min(len(last), MOST)).astype(int)
    return np.asarray(last[evenly])


def _flat(error: np.ndarray) -> np.ndarray:
    return np.asarray(np.hypot(error[..., 0], error[..., 1]))


def _padded(values: np.ndarray) -> Array:
    """Values padded to :data:`MOST` rows, so that all flights share one compilation."""
    rest = np.zeros((MOST - len(values), *values.shape[1:]))
    return jnp.asarray(np.concatenate([values, rest]))


def _attitudes(flight: Flight, x: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Angles of the filter without measurements, ``(B, n, 3)``."""
    level = np.tile([1.0, *6 * (0.0,)], (MOST - len(x), 1))
    filter = GpsAidedKalman(flight.dt, every=flight.every)
    found = _turned_on(filter, jnp.asarray(np.concatenate([x, level])), _padded(rates))
    return np.asarray(found)[: len(x)]


@jax.jit(static_argnums=0, compiler_options={"xla_backend_optimization_level": 0})
def _turned_on(filter: GpsAidedKalman, x: Array, rates: Array) -> Array:
    typical = {name: fact.typical for name, fact in parameter_facts(filter).items()}
    # Nothing is measured, so no variance matters.
    known: GpsAidedNoise = assembled(filter, typical)

    def one(x0: Array, rate: Array) -> Array:
        params = known._replace(q0=x0[:4], b0=x0[4:])
        z = jnp.full(rate.shape, jnp.nan)
        return jnp.asarray(run(filter, params, GpsAidedSample(rate, z))[1].angles)

    return jax.vmap(one)(x, rates)


def _tracks(flight: Flight, p0: np.ndarray, speed: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Positions by dead reckoning, ``(B, n, 3)``."""
    found = _moved_on(DeadReckoningKalman(flight.dt), _padded(p0), _padded(speed), _padded(angles))
    return np.asarray(found)[: len(p0)]


@jax.jit(static_argnums=0, compiler_options={"xla_backend_optimization_level": 0})
def _moved_on(filter: DeadReckoningKalman, p0: Array, speed: Array, angles: Array) -> Array:
    typical = {name: fact.typical for name, fact in parameter_facts(filter).items()}
    known: DeadReckoningNoise = assembled(filter, typical)

    def one(x0: Array, v: Array, attitude: Array) -> Array:
        params = known._replace(x0=x0)
        z = jnp.full(attitude.shape, jnp.nan)
        return jnp.asarray(run(filter, params, DeadReckoningSample(v, attitude, z))[1].position)

    return jax.vmap(one)(p0, speed, angles)
