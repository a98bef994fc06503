"""The paper's two experiments, as far as its text determines them, and motion to tune on."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import TiltSample
from filters.tilt_euler import TO_PAPER
from objectives import Data
from studies.suh2004.paper import ACC_VARIANCE, DT, GYR_VARIANCE, SAMPLES, GyroUnit
from studies.suh2004.settings import Settings
from tuner.data.simulation import GRAVITY, Bursts, Motion, Sensor, Swing, measure, simulate

SWING = Swing(size=(np.radians(15.0), np.radians(12.0), np.radians(60.0)))
EVERY = 10.0
"""Mean interval of bursts, s."""


@dataclass(frozen=True, eq=False)
class Recordings:
    """A batch of records: inputs ``(N, k, 3)`` and true (theta, phi), rad, ``(N, k, 2)``."""

    inputs: TiltSample
    truth: Array

    @property
    def count(self) -> int:
        """The number of records, k."""
        return self.truth.shape[1]

    @property
    def data(self) -> Data:
        """The records as a problem's data."""
        return Data(self.inputs, self.truth)


def experiment_1(unit: GyroUnit, samples: int = SAMPLES) -> TiltSample:
    """At rest: chirps sqrt(2) sin(a k^2) with the printed variances in place of the noise."""
    k = np.arange(1, samples + 1)
    a = 1.0 + 0.1 * np.arange(6)
    chirps = np.sqrt(2) * np.sin(a * k[:, None] * k[:, None])
    scale = np.radians(1.0) if unit == "deg/s" else 1.0
    acceleration = chirps[:, :3] * np.sqrt(ACC_VARIANCE) + [0.0, 0.0, 1.0]
    rate = chirps[:, 3:] * np.sqrt(GYR_VARIANCE) * scale
    return TiltSample(jnp.asarray(acceleration), jnp.asarray(rate * TO_PAPER))


def experiment_2(unit: GyroUnit) -> TiltSample:
    """On the cart: the same, with five pushes along y, the true attitude still zero."""
    still = experiment_1(unit)
    t = DT * np.arange(1, SAMPLES + 1)
    push = np.zeros(SAMPLES)
    for i in range(5):
        begin = 3.0 + 4 * i
        on = (t >= begin) & (t < begin + 2)
        push[on] += 0.1 * (i + 1) * (-1) ** i * np.sin(2 * np.pi * (t[on] - begin))
    return still._replace(acc=jnp.asarray(np.asarray(still.acc) + push[:, None] * [0.0, 1.0, 0.0]))


def recordings(settings: Settings, count: int, seed: int) -> Recordings:
    """Random motions of their own seeds, measured with the paper's noise and a random bias."""
    made = [_record(settings, seed + i) for i in range(count)]
    inputs = [sample for sample, _ in made]
    stacked = jax.tree.map(lambda *leaves: jnp.asarray(np.stack(leaves, axis=1)), *inputs)
    return Recordings(stacked, jnp.asarray(np.stack([truth for _, truth in made], axis=1)))


def _record(settings: Settings, seed: int) -> tuple[TiltSample, np.ndarray]:
    bursts = Bursts(round(settings.seconds / EVERY), settings.burst) if settings.burst else None
    motion = simulate(seconds=settings.seconds, dt=DT, seed=seed, swing=SWING, bursts=bursts)
    unit = np.radians(1.0) if settings.gyro_unit == "deg/s" else 1.0
    bias = np.radians(settings.bias) * np.random.default_rng([seed, 1]).uniform(-1, 1, 3)
    measured = measure(
        motion,
        gyroscope=Sensor(float(np.sqrt(np.mean(GYR_VARIANCE)) * unit), tuple(bias)),
        accelerometer=Sensor(float(np.sqrt(np.mean(ACC_VARIANCE))) * GRAVITY),
        seed=seed,
    )
    return TiltSample(measured.acc / GRAVITY, measured.gyr), _tilt(motion)


def _tilt(motion: Motion) -> np.ndarray:
    return np.ascontiguousarray(motion.angles[:, [1, 0]])
