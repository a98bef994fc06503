"""Simulated pitch steps of a body that is measured at intervals.

The paper gives neither R, P0, the gyroscopes' noise nor the time line; those here are settings.
"""

from dataclasses import dataclass
from functools import partial
from typing import Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import GpsAidedSample, constructed_attitude
from studies.chauhan2009.paper import DT, EVERY
from studies.chauhan2009.settings import Settings
from tuner.data.source import Source

GRAVITY = 9.81
BEFORE, RISE = 60.0, 2.0
"""Level flight before a step, and the duration of a step that the gyroscopes measure, s."""

Motion = Literal["silent", "seen"]
MOTIONS: tuple[Motion, ...] = ("silent", "seen")


@dataclass(frozen=True)
class Step:
    """A step from level to a pitch, deg; the gyroscopes measure it, or only the angles jump."""

    pitch: float
    motion: Motion


class Records(NamedTuple):
    """A batch of k records.

    Attributes:
        inputs: rates and measured angles, ``(N, k, 3)``.
        truth: pitch at the ticks, rad, ``(N, k)``.
    """

    inputs: GpsAidedSample
    truth: Array

    @property
    def source(self) -> Source:
        """A description of the simulated records."""
        gyr = np.asarray(self.inputs.gyr)
        return Source.simulated(f"{gyr.shape[1]} simulated pitch steps", [gyr], 1 / DT)


def records(settings: Settings, steps: list[Step], seeds: list[int]) -> Records:
    """Every step with every seed: those of the first step come first."""
    made = [_record(settings, step, seed) for step in steps for seed in seeds]
    rate, z, truth = (np.stack(part, axis=1) for part in zip(*made, strict=True))
    return Records(GpsAidedSample(jnp.asarray(rate), jnp.asarray(z)), jnp.asarray(truth))


def times(settings: Settings) -> np.ndarray:
    """Times of the ticks, s, ``(N,)``: the first is at one tick."""
    return DT * np.arange(1, round(settings.seconds / DT) + 1)


def _record(settings: Settings, step: Step, seed: int) -> tuple[np.ndarray, ...]:
    t = times(settings)
    rise = RISE if step.motion == "seen" else 0.0
    share = np.clip((t - BEFORE) / rise, 0, 1) if rise else (t > BEFORE).astype(float)
    truth = np.radians(step.pitch) * share
    draw = np.random.default_rng([seed, round(100 * step.pitch)])
    rate = np.radians(settings.bias + settings.gyro_noise * draw.normal(size=(len(t), 3)))
    if rise:
        rate[:, 1] += np.diff(truth, prepend=0.0) / DT
    z = np.radians(settings.noise) * draw.normal(size=(len(t), 3))
    z[:, 1] += truth
    if settings.measured == "gps":
        z = _constructed(settings, truth, draw)
    z[np.arange(1, len(t) + 1) % EVERY != 0] = np.nan
    return rate, z, truth


def _constructed(settings: Settings, pitch: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """Angles from the last three positions and the force between them: those one update ago.

    A climb to the north with the speed along the forward axis.
    """
    still = 0 * pitch
    velocity = settings.speed * np.stack([np.cos(pitch), still, -np.sin(pitch)], axis=1)
    place = DT * velocity.cumsum(axis=0) + settings.gps_noise * draw.normal(size=velocity.shape)
    north, _, down = (np.diff(velocity, axis=0, prepend=velocity[:1]) / DT).T - [
        [0],
        [0],
        [GRAVITY],
    ]
    c, s = np.cos(pitch), np.sin(pitch)
    force = np.stack([c * north - s * down, still, s * north + c * down], axis=1)
    force += settings.acc_noise * draw.normal(size=force.shape)
    z = np.full(velocity.shape, np.nan)
    at = np.arange(3 * EVERY, len(pitch) + 1, EVERY) - 1
    positions = np.stack([place[at - 2 * EVERY], place[at - EVERY], place[at]], axis=1)
    mean = np.stack([force[at - k] for k in range(2 * EVERY)]).mean(axis=0)
    z[at] = _attitudes(positions, mean)
    return z


@jax.jit
def _attitudes(positions: Array, forces: Array) -> Array:
    construct = partial(constructed_attitude, dt=DT * EVERY, gravity=GRAVITY)
    return jax.vmap(construct)(positions, forces)
