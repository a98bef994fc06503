"""Cases that are likelihoods: Gaussian numbers in closed form, local levels by a loop of NumPy."""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from benchmarks.statuses.case import Case, lowest
from benchmarks.statuses.drawn import Make
from filters import LevelSample, LocalLevel
from objectives import Data, InnovationLikelihood
from tuner import Limited, Positive, Problem, Space

COUNT = 80
NUMBERS = Space.of(mean=Limited(0.0, -10.0, 10.0), deviation=Positive(1.0, 1e-3, 1e3))
PRODUCT = Space.of(gain=Positive(1.0, 1e-3, 1e3), deviation=Positive(1.0, 1e-3, 1e3))
LEVEL = Space.of(q=Positive(1.0, 1e-6, 1e6), R=Positive(1.0, 1e-6, 1e6))
LOG2PI = np.log(2 * np.pi)


class Predicted(NamedTuple):
    """An innovation and its variance, ``(1,)`` each."""

    innovation: Array
    variance: Array


@dataclass(frozen=True)
class Constant:
    """Predicts every number by the same mean and deviation."""

    def init(self, params: tuple[Array, Array]) -> tuple[()]:
        """The empty state."""
        return ()

    def step(
        self, params: tuple[Array, Array], state: tuple[()], inputs: Array
    ) -> tuple[tuple[()], Predicted]:
        """One number."""
        mean, deviation = params
        return state, Predicted((inputs - mean)[None], (deviation**2)[None])


def mean_and_deviation(values: dict[str, Array]) -> tuple[Array, Array]:
    """Both as they are."""
    return values["mean"], values["deviation"]


def only_product(values: dict[str, Array]) -> tuple[Array, Array]:
    """A deviation of two factors, around 0."""
    return jnp.zeros(()), values["gain"] * values["deviation"]


def gaussian(rng: np.random.Generator, number: int) -> Case:
    """Mean and deviation of numbers."""
    x = rng.uniform(-5, 5) + 10 ** rng.uniform(-2, 1.5) * rng.standard_normal(COUNT)
    at = np.array([x.mean(), np.log(x.std())])

    def values(points: np.ndarray) -> np.ndarray:
        error = (x - points[:, :1]) / np.exp(points[:, 1:])
        return np.asarray((error**2).mean(axis=1) / 2 + points[:, 1] + LOG2PI / 2)

    data = Data(jnp.asarray(x), jnp.asarray(x))
    problem = Problem(
        f"gaussian_{number}", NUMBERS, Constant(), mean_and_deviation, InnovationLikelihood(), data
    )
    best = float(values(at[None])[0])
    return Case("likelihood", "gaussian", number, problem, values, best, at, COUNT)


def product(rng: np.random.Generator, number: int) -> Case:
    """A deviation that is the product of two factors."""
    x = 10 ** rng.uniform(-1, 1) * rng.standard_normal(COUNT)
    half = np.log(np.mean(x**2)) / 4

    def values(points: np.ndarray) -> np.ndarray:
        spread = points.sum(axis=1)
        return np.asarray(np.mean(x**2) * np.exp(-2 * spread) / 2 + spread + LOG2PI / 2)

    data = Data(jnp.asarray(x), jnp.asarray(x))
    problem = Problem(
        f"product_{number}", PRODUCT, Constant(), only_product, InnovationLikelihood(), data
    )
    at = np.array([half, half])
    best = float(values(at[None])[0])
    return Case("likelihood", "product", number, problem, values, best, at, COUNT, flat=True)


def level(ratio: tuple[float, float], kind: str, *, wander: bool = True) -> Make:
    """A local level; one that does not wander has its optimum at q = 0 or close to it."""

    def make(rng: np.random.Generator, number: int) -> Case:
        R, q = 10 ** rng.uniform(-1.5, 1.5), 10 ** rng.uniform(*ratio)
        steps = np.sqrt(q * R) * rng.standard_normal(COUNT + 1) * wander
        z = 3.0 + np.cumsum(steps) + np.sqrt(R) * rng.standard_normal(COUNT + 1)

        def values(points: np.ndarray) -> np.ndarray:
            return local_level(z, *np.exp(points.T)) / COUNT

        low, high = LEVEL.box()
        at, best = lowest(values, low, high, dense=141)
        data = Data(LevelSample(jnp.asarray(z)), jnp.asarray(z))
        problem = Problem(
            f"{kind}_{number}", LEVEL, LocalLevel(1.0), None, InnovationLikelihood(), data
        )
        # With q at the end of the box its size is not determined.
        idle = bool((at < low + 5).any() or (at > high - 5).any())
        return Case(
            "likelihood",
            kind,
            number,
            problem,
            values,
            best,
            at,
            COUNT,
            flat=None if idle else False,
            beyond=idle,
        )

    return make


def local_level(z: np.ndarray, q: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Negative log-density of z ``(N + 1,)`` in nats at q and R ``(B,)`` each: a textbook's loop.

    The first measurement is the level's start and does not count.
    """
    x, P, total = np.full_like(q, z[0]), R.copy(), np.zeros_like(q)
    for measured in z[1:]:
        P = P + q
        s, y = P + R, measured - x
        total += (y**2 / s + np.log(s) + LOG2PI) / 2
        x, P = x + P / s * y, P * R / s
    return total


def plan() -> tuple[tuple[Make, int], ...]:
    """Number of cases of each kind."""
    return (
        (gaussian, 5),
        (product, 3),
        (level((-1.5, 1.0), "level"), 5),
        (level((0.0, 0.0), "still level", wander=False), 4),
    )
