"""Sensor readings of the flights, with the errors of table 1."""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from filters import PiSample
from studies.you_lee.flight import Motion, Trajectory, motion
from studies.you_lee.paper import MICRO, PER_HOUR
from studies.you_lee.settings import Settings
from tuner.data.simulation import Sensor, even_normals
from tuner.limits import check_amount

ALL = slice(None)


@dataclass(frozen=True, eq=False)
class Flown:
    """Initial values and reference of a flight; exact sensor readings are at mid-interval.

    Attributes:
        angles0, velocity0: true ones at the start, rad and ft/s.
        sensed: readings of exact sensors, ``(N, ...)``.
        truth: (roll, pitch) at the ends of the intervals, rad, ``(N, 2)``.
    """

    angles0: tuple[float, ...]
    velocity0: tuple[float, ...]
    sensed: Motion
    truth: np.ndarray


def flown(settings: Settings, trajectory: Trajectory) -> Flown:
    """One flight."""
    many = settings.samples
    check_amount(f"{many:.4g} samples", 512.0 * many, "take a shorter flight")
    t = settings.dt / 2 * np.arange(2 * settings.samples + 1)
    known = [np.asarray(part) for part in motion(trajectory, settings.course, jnp.asarray(t))]
    angles, velocity = known[0], known[-1]
    sensed = Motion(*(jnp.asarray(part[1::2]) for part in known))
    return Flown(tuple(angles[0].tolist()), tuple(velocity[0].tolist()), sensed, angles[2::2])


def deterministic(settings: Settings, flight: Flown, axes: tuple[int, ...]) -> PiSample:
    """One run with table 1's deviations as constant errors, on some of the sensors' axes.

    Args:
        settings: the sizes of the errors.
        flight: the flight.
        axes: 0 to 2 for p, q, r, and 3 to 5 for fx, fy, fz.
    """
    on = np.isin(np.arange(6), axes)
    still = np.zeros((settings.samples, 1, 3))
    errors = Errors(
        still + settings.acc_bias * MICRO * on[3:],
        still + settings.gyro_bias * PER_HOUR * on[:3],
        still[..., 0],
    )
    return measured(flight, errors)


class Errors(NamedTuple):
    """Errors of the sensors in k runs: ``(N, k, 3)``, ``(N, k, 3)``, ``(N, k)``."""

    force: np.ndarray
    rate: np.ndarray
    airspeed: np.ndarray


def sensor_errors(settings: Settings, first: int, count: int, part: slice = ALL) -> Errors:
    """Table 1's errors in runs with the seeds first, first + 1, ..; every flight gets the same.

    The biases at turn-on decide most of an error, so those of all runs together are spread evenly.

    Args:
        settings: of the study.
        first: seed of the first run.
        count: number of runs.
        part: the runs to be drawn; all if left out.
    """
    still = np.zeros((settings.samples, 3))
    hour = np.sqrt(3600.0)
    gyro_walk, acc_walk = settings.gyro_walk * PER_HOUR / hour, settings.acc_walk * MICRO / hour
    gyro_bias, acc_bias = settings.gyro_bias * PER_HOUR, settings.acc_bias * MICRO
    turn_on = even_normals(count, 6, first)
    runs = list(zip(range(first, first + count), turn_on, strict=True))
    made = []
    for seed, start in runs[part]:
        gyro = Sensor(walk=gyro_walk, bias=tuple(gyro_bias * start[:3]))
        acc = Sensor(walk=acc_walk, bias=tuple(acc_bias * start[3:]))
        draw = np.random.default_rng([seed, 2])
        made.append(
            (
                acc.measure(still, settings.dt, seed + 2**31),
                gyro.measure(still, settings.dt, seed),
                settings.airspeed_noise * draw.normal(size=len(still)),
            )
        )
    return Errors(*(np.stack(errors, axis=1) for errors in zip(*made, strict=True)))


def measured(flight: Flown, errors: Errors) -> PiSample:
    """Sensor readings of a flight in k runs, ``(N, k, ...)``."""
    # In NumPy: nothing has to be compiled for so many runs.
    force, rate = np.asarray(flight.sensed.force), np.asarray(flight.sensed.rate)
    u = np.asarray(flight.sensed.velocity)[:, :1]
    shown = force[:, None] + errors.force, rate[:, None] + errors.rate, u + errors.airspeed
    return PiSample(*map(jnp.asarray, shown))
