"""Pitch steps of a body that is measured now and then, simulated; and what is said of their errors.

The paper gives neither R, P0, the gyroscopes' noise nor the time line; those here are settings.
"""

from dataclasses import dataclass
from functools import partial
from typing import Annotated, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from pydantic import Field, field_validator

from filters import GpsAidedSample, constructed_attitude
from tuner.run.settings import StudySettings

DT, EVERY = 0.25, 4
"""A tick, s, and ticks between measurements (section 6.1)."""
GRAVITY = 9.81
BEFORE, RISE = 60.0, 2.0
"""Level flight before a step, and how long a step takes that the gyroscopes see, s."""
TRACKED = (4.4, 17.4, 28.2)
STEADY = (29.1, 15.7, 3.05)
DRIVEN = (14.1, 35.1, 44.6)
MAGNIFIED = 45.7
"""Pitch angles of Figs 2 to 4, 5, 6 to 8 and 9, deg."""

Motion = Literal["silent", "seen"]
MOTIONS: tuple[Motion, ...] = ("silent", "seen")


class Settings(StudySettings):
    """What the paper leaves open, and how hard the tuning searches."""

    seconds: float = Field(300.0, ge=180, le=3600, description="length of a record, s")
    measured: Literal["angles", "gps"] = Field(
        "angles", description="angles with noise, or those constructed from GPS and accelerometers"
    )
    noise: float = Field(1.0, gt=0, le=20, description="of the measured angles, deg")
    speed: float = Field(20.0, gt=0, le=300, description="gps: along the forward axis, m/s")
    gps_noise: float = Field(0.1, ge=0, le=100, description="gps: of a position, m")
    acc_noise: float = Field(0.1, ge=0, le=100, description="gps: of a tick's force, m/s^2")
    gyro_noise: float = Field(0.1, ge=0, le=20, description="of the gyroscopes in a tick, deg/s")
    bias: tuple[float, float, float] = Field(
        (0.5, -0.3, 0.2), description="of the gyroscopes, deg/s"
    )
    records: int = Field(6, ge=2, le=50, description="seeds of every step that is looked at")
    train: int = Field(2, ge=1, le=20, description="seeds of every step that is tuned on")
    held_out: int = Field(6, ge=1, le=50, description="seeds of every step that only judges")
    tuned_on: tuple[Annotated[float, Field(gt=0, le=80)], ...] = Field(
        (14.1, 35.1), min_length=1, description="pitch angles that are tuned on, deg"
    )
    windows: tuple[Annotated[int, Field(ge=2, le=20)], ...] = Field(
        (2, 4, 6, 8), min_length=1, description="lengths of the fuzzy window that are tried, even"
    )
    factors: tuple[Annotated[float, Field(gt=0)], ...] = Field(
        (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0),
        min_length=2,
        description="lambda of the random noise's sweep",
    )
    starts: int = Field(1, ge=1, description="starts of each search, the same for every filter")

    @field_validator("windows")
    @classmethod
    def _even(cls, windows: tuple[int, ...]) -> tuple[int, ...]:
        odd = [window for window in windows if window % 2]
        if odd:
            raise ValueError(
                f"a line through {odd[0]} residuals need not be unique; take an even number"
            )
        return windows


@dataclass(frozen=True)
class Step:
    """From level to a pitch, deg; the gyroscopes see it, or it is silent: the measurements jump."""

    pitch: float
    motion: Motion


class Records(NamedTuple):
    """k records side by side.

    Attributes:
        inputs: rates and measured angles, ``(N, k, 3)``.
        truth: pitch at the ticks, rad, ``(N, k)``.
    """

    inputs: GpsAidedSample
    truth: Array


def records(settings: Settings, steps: list[Step], seeds: list[int]) -> Records:
    """Every step with every seed: those of the first step come first."""
    made = [_record(settings, step, seed) for step in steps for seed in seeds]
    rate, z, truth = (np.stack(part, axis=1) for part in zip(*made, strict=True))
    return Records(GpsAidedSample(jnp.asarray(rate), jnp.asarray(z)), jnp.asarray(truth))


def times(settings: Settings) -> np.ndarray:
    """Of the ticks, s, ``(N,)``: the first is at one tick."""
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
    """Angles from the last three positions and the force meanwhile: those of one update ago.

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


class Behaviour(NamedTuple):
    """How single records went, ``(k,)`` each; per cent of the step.

    Attributes:
        peak: largest error within 60 s after the step, %.
        settled: when the error last exceeds 5 % after the step, s.
        ripple: standard deviation of the error over the last 60 s, %.
        offset: its mean there, %.
    """

    peak: np.ndarray
    settled: np.ndarray
    ripple: np.ndarray
    offset: np.ndarray


def behaviour(pitch: np.ndarray, found: Records, settings: Settings, step: float) -> Behaviour:
    """What is said of estimates.

    Args:
        pitch: estimated, rad, ``(N, k)``.
        found: the records; errors are looked at where there is a measurement.
        settings: for the time line.
        step: the final pitch, deg.
    """
    at = slice(EVERY - 1, None, EVERY)
    t = times(settings)[at]
    error = 100 * np.degrees(pitch - np.asarray(found.truth))[at] / step
    after = (t > BEFORE) & (t <= BEFORE + 60)
    late = t > settings.seconds - 60
    since = np.where((np.abs(error) > 5) & (t > BEFORE)[:, None], t[:, None] - BEFORE, 0.0)
    return Behaviour(
        peak=np.abs(error[after]).max(axis=0),
        settled=since.max(axis=0),
        ripple=error[late].std(axis=0),
        offset=error[late].mean(axis=0),
    )
