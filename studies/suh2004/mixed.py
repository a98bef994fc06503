"""Motion with bursts and bias, and the three filters tuned on it with the same means."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Batched, TiltKalman, TiltNoise, TiltOutputs, TiltSample, shared
from objectives import Data, Records, score
from studies.suh2004.paper import (
    ACC_VARIANCE,
    DT,
    GYR_VARIANCE,
    SIMPLE,
    STANDARD,
    TWO_STEP,
    Settings,
    noise,
)
from tuner.data.simulation import GRAVITY, Bursts, Motion, Sensor, Swing, measure, simulate
from tuner.problem.parameters import Bounded, Parameter, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space

SWING = Swing(size=(np.radians(15.0), np.radians(12.0), np.radians(60.0)))
EVERY = 10.0
"""A burst comes every so many seconds on average."""
Q1 = Positive(1.0, 1e-2, 1e4, unit="rad^2/s^3")
R_NOM = Positive(0.05, 1e-4, 1e3, unit="g^2")
DELTA = Positive(0.005, 5e-4, 0.2, unit="g^2", threshold=True)
FREE: dict[str, dict[str, Parameter]] = {
    "standard": {"q1": Q1, "r_nom": R_NOM},
    "simple": {"q1": Q1, "r_nom": R_NOM, "r_big": Positive(5.0, 1e-2, 1e6, "g^2"), "delta": DELTA},
    "two_step": {
        "q1": Q1,
        "r_nom": R_NOM,
        "alpha1": Bounded(0.4, 0.0, 1.0),
        "alpha2": Positive(10.0, 1e-1, 1e6, "g"),
        "delta": DELTA,
    },
}
"""What is tuned of each filter. r3 stays at 1: the scale of all variances is free."""
FILTERS = {"standard": STANDARD, "simple": SIMPLE, "two_step": TWO_STEP}


@dataclass(frozen=True, eq=False)
class Recordings:
    """Records side by side: inputs ``(N, k, 3)`` and true (theta, phi), rad, ``(N, k, 2)``."""

    inputs: TiltSample
    truth: Array

    @property
    def count(self) -> int:
        """k."""
        return self.truth.shape[1]

    @property
    def data(self) -> Data:
        """As a problem takes them."""
        return Data(self.inputs, self.truth)


@dataclass(frozen=True)
class TiltRmse:
    """Root mean square error of pitch and roll together, deg."""

    def __call__(self, outputs: TiltOutputs, truth: Array) -> Array:
        """Of one record, ``()``."""
        square = ((outputs.angles - truth) ** 2).sum(axis=1)
        return jnp.degrees(jnp.sqrt(square.mean()))


OBJECTIVE = Records(TiltRmse())


@dataclass(frozen=True)
class Build:
    """From parameters by name to those of k filters side by side."""

    count: int

    def __call__(self, values: dict[str, Array]) -> TiltNoise:
        """The same for every record."""
        noises: TiltNoise = shared(noise(values), self.count)
        return noises


def recordings(settings: Settings, count: int, seed: int) -> Recordings:
    """Random motions of their own seeds, measured with the paper's noise and a random bias."""
    made = [_record(settings, seed + i) for i in range(count)]
    inputs = [sample for sample, _ in made]
    stacked = jax.tree.map(lambda *leaves: jnp.stack(leaves, axis=1), *inputs)
    return Recordings(stacked, jnp.stack([truth for _, truth in made], axis=1))


def problems(tuned_on: Recordings) -> dict[str, Problem]:
    """One problem for each filter."""
    _refuse_still(tuned_on.truth)
    return {
        name: Problem(
            name=name,
            space=Space.of(**FREE[name]),
            filter=Batched(FILTERS[name]),
            build=Build(tuned_on.count),
            objective=OBJECTIVE,
            data=tuned_on.data,
        )
        for name in FREE
    }


def held_out(name: str, values: dict[str, Array], judged_on: Recordings) -> float:
    """A filter's error on other records, deg."""
    return float(_score(FILTERS[name], shared(noise(values), judged_on.count), judged_on.data))


@jax.jit(static_argnums=0)
def _score(filter: TiltKalman, params: TiltNoise, data: Data) -> Array:
    return score(Batched(filter), OBJECTIVE, params, data)


def _record(settings: Settings, seed: int) -> tuple[TiltSample, Array]:
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
    return TiltSample(measured.acc / GRAVITY, measured.gyr), jnp.asarray(_tilt(motion))


def _tilt(motion: Motion) -> np.ndarray:
    return np.ascontiguousarray(motion.angles[:, [1, 0]])


def _refuse_still(truth: Array) -> None:
    """Refuse data on which a filter that never follows the sensors is the best.

    Raises:
        ValueError: names the direction that such data cannot determine.
    """
    if not float(jnp.abs(truth - truth[0]).max()) > 0:
        raise ValueError(
            "the true attitude never moves in these data, so the error falls to zero as q1 goes "
            "to 0 (a filter that ignores its sensors), and q1 against r_nom, alpha2 and delta is "
            "not determined: tune on records with motion (tune_on = 'mixed')"
        )
