"""The error-state INS against loops in NumPy, a simulated flight, and recorded ones."""

from functools import cache
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation

from filters import ErrorStateIns, InsNoise, InsSample, parameter_facts, run

G = 9.80665
TYPICAL = {name: fact.typical for name, fact in parameter_facts(ErrorStateIns).items()}
HALF_TURN = np.array([1.0, -1.0, -1.0])


def params(dtype=float, **values):
    unknown = values.keys() - TYPICAL.keys()
    assert not unknown
    return InsNoise(**{k: jnp.asarray(v, dtype) for k, v in (TYPICAL | values).items()})


compiled = jax.jit(run, static_argnums=0)


class Flight(NamedTuple):
    """A motion that is known, one tick before and N after it began; enu."""

    dt: float
    attitude: Rotation
    velocity: np.ndarray
    position: np.ndarray
    rate: np.ndarray
    force: np.ndarray


@cache
def flight(N=600, dt=0.05, start=(0.1, 0.05, 0.7)):
    """Turns and pushes of several frequencies, sampled so that the filter's own steps are exact."""
    t = dt * np.arange(N)[:, None]
    rate = np.array([0.3, 0.25, 0.2]) * np.sin(t * [0.7, 0.9, 0.3] + [0.0, 1.0, 2.0])
    rate[0] = 0.0
    push = np.array([1.5, 1.0, 0.7]) * np.sin(t * [0.5, 0.8, 0.6] + [0.5, 0.0, 1.0])
    push[0] = 0.0
    attitude = [Rotation.from_euler("XYZ", start)]
    force = [attitude[0].inv().apply([0.0, 0.0, G])]
    v, p = [np.zeros(3)], [np.zeros(3)]
    for k in range(1, N):
        middle = attitude[-1] * Rotation.from_rotvec(rate[k] * dt / 2)
        force.append(middle.inv().apply(push[k] + [0.0, 0.0, G]))
        attitude.append(middle * Rotation.from_rotvec(rate[k] * dt / 2))
        v.append(v[-1] + push[k] * dt)
        p.append(p[-1] + (v[-1] + v[-2]) / 2 * dt)
    whole = Rotation.concatenate(attitude)
    return Flight(dt, whole, np.array(v), np.array(p), rate, np.array(force))


def now_and_then(values, every, first=1):
    """Only every so many samples."""
    thinned = np.full_like(values, np.nan, dtype=float)
    thinned[first::every] = values[first::every]
    return thinned


FIELD = np.array([0.0, 20.0, -43.0])
"""uT, earth axes; north."""


def measured(rng, noise, every=(10, 10, 5, 4, 5, 0)):
    """All channels of the flight, with noise as the filter believes it to be."""
    f = flight()
    N, dt = len(f.rate), f.dt
    n = {name: float(value) for name, value in noise._asdict().items()}

    def walk(q, start):
        steps = rng.normal(size=(N, 3)) * np.sqrt(q * dt)
        steps[0] = start * rng.normal(size=3)
        return np.cumsum(steps, axis=0)

    gyr_bias, acc_bias = (
        walk(n["q_gyr_bias"], n["gyr_bias0"]),
        walk(n["q_acc_bias"], n["acc_bias0"]),
    )
    # Sample k is wrong by the bias before it, as the filter has it.
    gyr = f.rate + np.vstack([gyr_bias[:1], gyr_bias[:-1]])
    gyr += rng.normal(size=(N, 3)) * np.sqrt(n["q_gyr"] / dt)
    acc = f.force + np.vstack([acc_bias[:1], acc_bias[:-1]])
    acc += rng.normal(size=(N, 3)) * np.sqrt(n["q_acc"] / dt)
    level_gps = np.sqrt([n["R_gps"], n["R_gps"], n["R_gps_up"]])
    gps = f.position + rng.normal(size=(N, 3)) * level_gps
    vel = f.velocity + rng.normal(size=(N, 3)) * np.sqrt(n["R_gps_vel"])
    baro = f.position[:, 2] + rng.normal(size=N) * np.sqrt(n["R_baro"])
    speed = f.attitude.inv().apply(f.velocity)[:, 0] + rng.normal(size=N) * np.sqrt(n["R_speed"])
    # The level part's direction is wrong by a rotation about the vertical.
    twist = Rotation.from_rotvec(np.outer(rng.normal(size=N) * np.sqrt(n["R_mag"]), [0, 0, 1.0]))
    mag = (f.attitude.inv() * twist).apply(FIELD)
    channels = (gps, vel, baro, speed, mag)
    thinned = [now_and_then(v, e) if e else None for v, e in zip(channels, every, strict=False)]
    still = np.zeros(N) if every[5] else None
    sample = InsSample(gyr, acc, *thinned, still)
    return jax.tree.map(jnp.asarray, sample), gyr_bias, acc_bias
