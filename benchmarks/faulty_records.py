"""Records of three models, simulated with and without a fault."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from filters import (
    ConstantVelocity,
    ConstantVelocityNoise,
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    LevelSample,
    LocalLevel,
    LocalLevelNoise,
    PositionSample,
)

SAMPLES = 1000
DRAG, DRIVE, STEP = 0.2, 0.8, 0.1
TURN = 2 * np.pi


@dataclass(frozen=True)
class Model:
    """A filter with the process for which it is right.

    Attributes:
        filter: the filter.
        params: makes its parameters from q and R.
        samples: from measurements ``(N,)`` to its inputs.
        states: from a generator to noise-free measurements, ``(N, k)``.
        q, R: the true ones.
    """

    filter: Any
    params: Callable[[Any, Any], Any]
    samples: Callable[[Any], Any]
    states: Callable[[np.random.Generator, int], np.ndarray]
    q: float
    R: float


def walk(draw: np.random.Generator, count: int, q: float = 0.09) -> np.ndarray:
    return np.cumsum(np.sqrt(q) * draw.standard_normal((SAMPLES, count)), axis=0)


def track(draw: np.random.Generator, count: int, q: float = 0.5, dt: float = 0.5) -> np.ndarray:
    root = np.linalg.cholesky(q * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]]))
    place, speed, found = np.zeros(count), np.zeros(count), []
    for _ in range(SAMPLES):
        noise = root @ draw.standard_normal((2, count))
        place, speed = place + dt * speed + noise[0], speed + noise[1]
        found.append(place)
    return np.array(found)


def rotor(draw: np.random.Generator, count: int, q: float = 0.05) -> np.ndarray:
    """The angle of a driven rotor with quadratic drag, whose torque is a white noise."""
    angle = 0.1 * draw.standard_normal(count)
    speed = 1.0 + 0.3 * draw.standard_normal(count)
    found = []
    for _ in range(SAMPLES):
        angle = angle + STEP * speed
        speed = speed + STEP * (DRIVE - DRAG * speed * np.abs(speed))
        speed = speed + np.sqrt(q * STEP) * draw.standard_normal(count)
        found.append(angle)
    return np.array(found)


def turned(model: Any, x: jax.Array, u: Any) -> jax.Array:
    return jnp.stack([x[0] + STEP * x[1], x[1] + STEP * (DRIVE - DRAG * x[1] * jnp.abs(x[1]))])


def pushed(model: Any, x: jax.Array, u: Any) -> jax.Array:
    return jnp.zeros((2, 2)).at[1, 1].set(model * STEP)


def first(model: Any, x: jax.Array, u: Any) -> jax.Array:
    return x[:1]


def kept(model: Any, x: jax.Array, u: Any) -> jax.Array:
    return x


def wandered(model: Any, x: jax.Array, u: Any) -> jax.Array:
    return model * jnp.eye(1)


def extended(q: Any, R: Any, x0: Any = (0.0, 1.0), P0: Any = (0.01, 0.09)) -> ExtendedModel:
    return ExtendedModel(q, R * jnp.ones(1), jnp.array(x0), jnp.diag(jnp.array(P0)))


def column(z: Any) -> ExtendedSample:
    return ExtendedSample(z[:, None])


MODELS = {
    "local level": Model(LocalLevel(1.0), LocalLevelNoise, LevelSample, walk, 0.09, 1.0),
    "constant velocity": Model(
        ConstantVelocity(0.5), ConstantVelocityNoise, PositionSample, track, 0.5, 4.0
    ),
    "extended (rotor)": Model(
        ExtendedKalman(turned, pushed, first), extended, column, rotor, 0.05, 0.01
    ),
}
BEGUN = Model(
    ExtendedKalman(kept, wandered, first),
    partial(extended, x0=(0.0,), P0=(0.09,)),
    column,
    walk,
    0.09,
    1.0,
)
"""A local level that begins at 0."""


# Faults: from a generator, what is measured without noise (N, k), the noise's deviation and a size
# to measurements (N, k).


def none(draw: np.random.Generator, x: np.ndarray, sd: float, size: float) -> np.ndarray:
    return x + sd * draw.standard_normal(x.shape)


def outliers(
    draw: np.random.Generator, x: np.ndarray, sd: float, size: float, share: float
) -> np.ndarray:
    """A share of the measurements is off by so many deviations, on either side."""
    wrong = draw.random(x.shape) < share
    return none(draw, x, sd, 0) + wrong * size * sd * draw.choice([-1.0, 1.0], x.shape)


def coloured(draw: np.random.Generator, x: np.ndarray, sd: float, size: float) -> np.ndarray:
    """Noise of the same variance, with a correlation of ``size`` from sample to sample."""
    noise = [draw.standard_normal(x.shape[1])]
    for _ in range(SAMPLES - 1):
        new = draw.standard_normal(x.shape[1])
        noise.append(size * noise[-1] + np.sqrt(1 - size**2) * new)
    return x + sd * np.array(noise)


def wrapped(draw: np.random.Generator, x: np.ndarray, sd: float, size: float) -> np.ndarray:
    """Jumps ``size`` times by a full turn, at random places, and stays there."""
    z = none(draw, x, sd, 0)
    for _ in range(int(size)):
        at = draw.integers(SAMPLES // 10, SAMPLES, x.shape[1])
        z = z - TURN * sd / 0.1 * (np.arange(SAMPLES)[:, None] >= at)
    return z


def growing(draw: np.random.Generator, x: np.ndarray, sd: float, size: float) -> np.ndarray:
    """The variance grows exponentially with the rank of the level, by exp(size) to both ends."""
    rank = 2 * np.argsort(np.argsort(x, axis=0), axis=0) / (SAMPLES - 1) - 1
    return x + sd * np.exp(size * rank / 2) * draw.standard_normal(x.shape)


def ageing(draw: np.random.Generator, x: np.ndarray, sd: float, size: float) -> np.ndarray:
    """The variance grows exponentially with time, by exp(size) to both ends."""
    rank = np.linspace(-1, 1, SAMPLES)[:, None]
    return x + sd * np.exp(size * rank / 2) * draw.standard_normal(x.shape)


def displaced(draw: np.random.Generator, x: np.ndarray, sd: float, size: float) -> np.ndarray:
    """The truth begins so many deviations from where the filter does."""
    return none(draw, x, sd, 0) + size * sd


@dataclass(frozen=True)
class Fault:
    """A fault of several sizes, and the test that is there for it."""

    make: Callable[..., np.ndarray]
    sizes: tuple[float, ...]
    test: str


FAULTS = {
    "1 % outliers, deviations": Fault(
        partial(outliers, share=0.01), (4, 5, 6, 8, 10, 15, 20, 40), "outliers"
    ),
    "10 % outliers, deviations": Fault(
        partial(outliers, share=0.1), (2, 3, 4, 5, 6, 8, 10, 20), "outliers"
    ),
    "coloured noise, correlation": Fault(
        coloured, (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95), "whiteness"
    ),
    "full turns, number": Fault(wrapped, (1, 2, 4), "full turns"),
    "noise with the level, ln": Fault(growing, (np.log(2), 1.0, 1.5, 2.0, 2.5, 3.0), "over level"),
    "noise with time, ln": Fault(ageing, (np.log(2), 1.0, 1.5, 2.0, 2.5, 3.0), "over time"),
}
STARTS = Fault(displaced, (2, 4, 6, 8, 10, 14, 20, 30, 50, 100), "start")
