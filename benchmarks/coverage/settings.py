"""Settings: simulated models and their problems; records of one share a compilation."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import jax.numpy as jnp
import numpy as np
from jax import Array

from benchmarks.coverage.simulated import (
    GRAVITY,
    SPREAD,
    START,
    STEP,
    Noise,
    local_levels,
    pendulums,
    pseudo_true,
    tracks,
)
from filters import (
    ConstantVelocity,
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    LevelSample,
    LocalLevel,
    PositionSample,
)
from objectives import Data, InnovationLikelihood
from tuner import Positive, Problem, Space

Filter = Literal["level", "track", "pendulum"]


@dataclass(frozen=True)
class Setting:
    """Many records of one kind.

    Attributes:
        filter: the filter to tune.
        noise: of the measurements.
        length: samples of a record.
        q, R: the true values of the state's noise and of the measurements' variance.
    """

    filter: Filter
    noise: Noise
    length: int
    q: float
    R: float

    @property
    def name(self) -> str:
        """Filter and noise."""
        return f"{self.filter}, {self.noise}"

    def truth(self) -> dict[str, float]:
        """The values that the intervals must contain, by name."""
        if self.filter == "pendulum":
            return {"q": self.q, "R": self.R}
        q, R = np.exp(pseudo_true(self.filter, self.q, self.R, self.noise))
        return {"q": float(q), "R": float(R)}

    def records(self, seed: int, count: int) -> np.ndarray:
        """Measurements, ``(count, length)``."""
        rng = np.random.default_rng([seed, SETTINGS.index(self)])
        shape = count, self.length, self.q, self.R
        if self.filter == "pendulum":
            return pendulums(rng, *shape)
        make = local_levels if self.filter == "level" else tracks
        return make(rng, *shape, self.noise)

    def problem(self, record: np.ndarray) -> Problem:
        """The likelihood of one record ``(length,)``, begun three times too high and too low."""
        return POSED[self.filter](record, _space(3 * self.q, self.R / 3))


def _space(q: float, R: float) -> Space:
    return Space.of(q=Positive(q, q * 1e-8, q * 1e8), R=Positive(R, R * 1e-8, R * 1e8))


def level_problem(record: np.ndarray, space: Space) -> Problem:
    """A local level, one sample per second."""
    z = jnp.asarray(record)
    data = Data(LevelSample(z), z)
    return Problem("level", space, LocalLevel(1.0), None, InnovationLikelihood(), data)


def track_problem(record: np.ndarray, space: Space) -> Problem:
    """A velocity that white noise changes, one sample per second."""
    z = jnp.asarray(record)
    data = Data(PositionSample(z), z)
    return Problem("track", space, ConstantVelocity(1.0), None, InnovationLikelihood(), data)


def swung(q: Array, x: Array, u: None) -> Array:
    """Angle and rate of a pendulum after one step."""
    return jnp.stack([x[0] + STEP * x[1], x[1] - STEP * GRAVITY * jnp.sin(x[0])])


def pushed(q: Array, x: Array, u: None) -> Array:
    """Covariance of the noise of one step."""
    return jnp.diag(jnp.stack([0 * q, q * STEP]))


def sideways(q: Array, x: Array, u: None) -> Array:
    """The measurement."""
    return jnp.sin(x[:1])


def pendulum_model(values: dict[str, Array]) -> ExtendedModel:
    """The true model, q and R left open."""
    start, spread = jnp.asarray(START), SPREAD**2 * jnp.eye(2)
    return ExtendedModel(values["q"], values["R"][None], start, spread)


def pendulum_problem(record: np.ndarray, space: Space) -> Problem:
    """A pendulum by an extended Kalman filter."""
    z = jnp.asarray(record[:, None])
    data = Data(ExtendedSample(z), z)
    filter = ExtendedKalman(swung, pushed, sideways)
    return Problem("pendulum", space, filter, pendulum_model, InnovationLikelihood(), data)


POSED: dict[Filter, Callable[[np.ndarray, Space], Problem]] = {
    "level": level_problem,
    "track": track_problem,
    "pendulum": pendulum_problem,
}
SETTINGS = (
    Setting("level", "white", 300, 0.5, 1.0),
    Setting("track", "white", 300, 0.02, 1.0),
    Setting("pendulum", "white", 300, 0.02, 1e-4),
    Setting("level", "coloured", 400, 0.5, 1.0),
    Setting("level", "student 6", 400, 0.5, 1.0),
    Setting("track", "coloured", 800, 0.02, 1.0),
    Setting("track", "student 6", 800, 0.02, 1.0),
    Setting("level", "student 4", 400, 0.5, 1.0),
)
"""Coloured and heavy-tailed noise needs longer records: its correlation is learnt from them.

Of 4 degrees of freedom the fourth moment is infinite, and a variance has no normal limit: even of
400 independent such numbers the sandwich of their variance holds in 89 of 100 cases. That setting
is shown and not judged."""
