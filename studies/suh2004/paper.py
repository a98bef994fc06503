"""The paper's two experiments, as far as its text determines them, and its hand-made parameters."""

from typing import Literal

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from pydantic import Field

from filters import TiltKalman, TiltNoise, TiltOutputs, TiltSample, run
from filters.tilt_euler import TO_PAPER
from objectives import AngleErrors, angle_errors
from tuner.run.settings import StudySettings

STATES = ("pitch", "roll", "rate_x", "rate_y", "rate_z")
DT = 0.05
SAMPLES = 480
ACC_VARIANCE = (1.68e-5, 1.67e-5, 1.68e-5)
"""Of the accelerometers at rest, g^2 (section 5); that of az is not printed, and taken as ax's."""
GYR_VARIANCE = (0.0032, 0.0040, 0.0031)
"""Of the gyroscopes at rest (section 5), in a unit that the paper does not give."""
HEURISTIC = {
    "q1": 1.0,
    "r_nom": 0.05,
    "r3": 1.0,
    "alpha1": 0.4,
    "alpha2": 10.0,
    "delta": 0.005,
    "r_big": 5.0,
}
"""Section 5: "rather heuristic choices based on trial-and-error"."""

GyroUnit = Literal["deg/s", "rad/s"]
UNITS: tuple[GyroUnit, ...] = ("deg/s", "rad/s")
STANDARD, SIMPLE, TWO_STEP = (
    TiltKalman(DT, "standard"),
    TiltKalman(DT, "simple"),
    TiltKalman(DT, "two-step"),
)


class Settings(StudySettings):
    """How the mixed motion is made, and how hard it is searched."""

    gyro_unit: GyroUnit = Field("deg/s", description="unit of the paper's gyroscope variances")
    tune_on: Literal["mixed", "experiment2"] = Field(
        "mixed", description="what is tuned on; experiment2 cannot determine anything"
    )
    seconds: float = Field(120.0, ge=20, le=3600, description="length of each record, s")
    train: int = Field(3, ge=1, le=20, description="records that are tuned on")
    held_out: int = Field(3, ge=1, le=20, description="records that only judge")
    burst: float = Field(4.0, ge=0, le=30, description="largest external acceleration, m/s^2")
    bias: float = Field(0.5, ge=0, le=20, description="largest gyroscope bias, deg/s")
    starts: int = Field(4, ge=1, description="starts of each search, the same for every filter")


def noise(values: dict[str, Array], start: Array | None = None) -> TiltNoise:
    """The filter's parameters from those given by name, the paper's for the others; P0 = 0."""
    all_values = {name: jnp.asarray(value) for name, value in HEURISTIC.items()} | values
    x0 = jnp.zeros(5) if start is None else start
    # Accelerations are in g.
    return TiltNoise(**all_values, gravity=jnp.ones(()), x0=x0, P0=jnp.zeros(()))


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
    return still._replace(acc=still.acc.at[:, 1].add(push))


def outputs(filter: TiltKalman, inputs: TiltSample, parameters: TiltNoise) -> TiltOutputs:
    """A filter's outputs over a record."""
    found: TiltOutputs = _run(filter, parameters, inputs)
    return found


def errors(filter: TiltKalman, inputs: TiltSample) -> AngleErrors:
    """S and M of (12) with the paper's parameters, where the true attitude is zero."""
    angles = outputs(filter, inputs, noise({})).angles
    return angle_errors(angles, jnp.zeros_like(angles))


_run = jax.jit(lambda filter, params, inputs: run(filter, params, inputs)[1], static_argnums=0)
