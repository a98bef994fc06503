"""The timed work: Kownacki's gyroscope filter on a step and on white noise."""

from dataclasses import dataclass
from functools import cached_property

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import GyroscopeFilter, KownackiNoise, LinearModel, Transition
from objectives import Data, Reading, StepResponse, Welch
from tuner import Fixed, Positive, Problem, Space

DT = 1e-4
STEP = 0.2
R = 1.3872e-6  # Table 1
Q = 1027.47 * R  # the ratio of Table 2
ONES = ((1.0, 1.0), (1.0, 1.0))


@dataclass(frozen=True)
class Work:
    """A record of a given length.

    Attributes:
        samples: its length N.
        repetitions: how often each call is timed.
    """

    samples: int = 100_000
    repetitions: int = 15

    @cached_property
    def step(self) -> np.ndarray:
        """The step signal, ``(N,)``."""
        return np.asarray(np.where(np.arange(self.samples) >= self.samples // 2, STEP, 0.0))

    @cached_property
    def noise(self) -> np.ndarray:
        """White noise of variance R, ``(N,)``."""
        return np.asarray(np.sqrt(R) * np.random.default_rng(0).standard_normal(self.samples))

    @cached_property
    def signal(self) -> np.ndarray:
        """Their sum, the input of a filter, ``(N,)``."""
        return np.asarray(self.step + self.noise)

    @cached_property
    def pair(self) -> np.ndarray:
        """Both side by side, ``(N, 2)``."""
        return np.stack([self.step, self.noise], axis=1)

    @cached_property
    def welch(self) -> Welch:
        """The estimate of the spectrum."""
        return Welch.matlab(self.samples)

    def problem(self, reading: Reading) -> Problem:
        """Minimise the paper's cost over R and Q; R1 needs one signal, the others two."""
        one = reading is Reading.R1
        objective = StepResponse(DT, self.welch, reading)
        return Problem(
            name=reading.name,
            space=Space.of(
                R=Positive(R, low=1e-13, high=1.0),
                Q=Positive(Q, low=1e-13, high=1e2),
                P0=Fixed(ONES),
            ),
            filter=GyroscopeFilter(DT) if one else GyroscopeFilter(DT, (2,)),
            build=noise,
            objective=objective,
            data=Data(self.signal if one else self.pair, objective.truth(self.step)),
        )


def noise(values: dict[str, Array]) -> KownackiNoise:
    """The filter's parameters from the space's."""
    return KownackiNoise(values["R"], values["Q"], values["P0"])


def linear_model(R: float, Q: float) -> LinearModel:
    """The same filter for the generic path."""
    return LinearModel(
        transition=Transition(
            F=jnp.array([[1.0, DT], [0.0, 1.0]]), G=DT * jnp.eye(2), Q=Q * jnp.eye(2)
        ),
        H=jnp.array([[1.0, 0.0]]),
        R=jnp.array([R]),
        P0=jnp.ones((2, 2)),
        x0=jnp.zeros(2),
    )


def pairs(count: int) -> np.ndarray:
    """Points (R, Q) around the work's own, ``(count, 2)``."""
    spread = np.random.default_rng(1).uniform(-2.0, 2.0, (count, 2))
    return np.array([R, Q]) * np.exp(spread)
