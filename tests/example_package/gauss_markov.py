"""A level that returns to zero by itself, measured with noise: a Gauss-Markov process."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters import Channel, Param

LEVEL = Channel("unit", "estimated level")


class Noise(NamedTuple):
    tau: Annotated[Array, Param("s", "time constant of the return", 1.0, low=1e-3, high=1e4)]
    sigma: Annotated[Array, Param("unit", "deviation of the level", 1.0, low=1e-6, high=1e6)]
    R: Annotated[Array, Param("unit^2", "variance of a measurement", 1.0, low=1e-12, high=1e12)]


class Outputs(NamedTuple):
    level: Annotated[Array, LEVEL]
    innovation: Annotated[Array, Channel("unit", "measured less predicted", kind="detail")]
    variance: Annotated[Array, Channel("unit^2", "of the innovation", kind="detail")]


@dataclass(frozen=True)
class GaussMarkov:
    """The Kalman filter of x' = a x + w with a = exp(-dt/tau) and var w = sigma^2 (1 - a^2)."""

    dt: float
    params, outputs = Noise, Outputs
    inputs, states = {"z": Channel("unit", "measured level")}, {"level": LEVEL}

    def init(self, params: Noise) -> tuple[Array, Array]:
        """Before the first sample: the level and its variance, over what is known without data."""
        return jnp.zeros_like(params.sigma), params.sigma**2

    def step(
        self, params: Noise, state: tuple[Array, Array], inputs: Array
    ) -> tuple[tuple[Array, Array], Outputs]:
        """Take one sample; NaN is a missing one."""
        a = jnp.exp(-self.dt / params.tau)
        x, P = a * state[0], a**2 * state[1] + params.sigma**2 * (1 - a**2)
        missing, s = jnp.isnan(inputs), P + params.R
        y = jnp.where(missing, 0.0, inputs - x)
        K = jnp.where(missing, 0.0, P / s)
        outputs = Outputs(x + K * y, y[None], jnp.where(missing, 0.0, s)[None])
        return (outputs.level, (1 - K) * P), outputs
