"""A linear filter whose gain is computed beforehand."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.declared import Channel
from filters.small_linalg import matmul


class SteadyGains(NamedTuple):
    """A discrete linear model with the gain on its measurements.

    Attributes:
        A: the model's dynamics over a sample, ``(n, n)``.
        C: the model's measurements, ``(m, n)``.
        K: gain, x+ = x + K (z - C x), ``(n, m)``.
        begin: maps the first measurement to the start, ``(n, m)``.
    """

    A: Array
    C: Array
    K: Array
    begin: Array


class SteadyGainState(NamedTuple):
    """The estimate before a sample, and whether there has been one.

    Attributes:
        x: predicted estimate, ``(n,)``.
        begun: 1 once there was a measurement, else 0.
    """

    x: Array
    begun: Array


@dataclass(frozen=True)
class SteadyGain:
    """A filter with one gain for all samples: measure, output, predict.

    It begins at the first sample in which nothing is missing, with the state that fits it; until
    then its estimate is 0. Where a measurement is missing its innovation is 0.
    A building block: its parameters are those of a model, which declares them.

    Attributes:
        names: of the states.
        note: comment on it where it is written as code.

    >>> from filters import run
    >>> half = SteadyGains(jnp.eye(1), jnp.eye(1), jnp.array([[0.5]]), jnp.eye(1))
    >>> run(SteadyGain(("level",)), half, jnp.array([[4.0], [jnp.nan], [8.0]]))[1][:, 0].tolist()
    [4.0, 4.0, 6.0]
    """

    names: tuple[str, ...]
    note: str = ""

    inputs = MappingProxyType({"z": Channel("", "measurements; NaN is a missing one")})

    @property
    def states(self) -> Mapping[str, Channel]:
        """The states, one by one."""
        return {name: Channel("", "") for name in self.names}

    @property
    def outputs(self) -> Mapping[str, Channel]:
        """The states, in one array."""
        return {"x": Channel("", "estimate", self.names)}

    def init(self, params: SteadyGains) -> SteadyGainState:
        """The start, of which nothing is known."""
        return SteadyGainState(
            jnp.zeros(params.A.shape[0], params.A.dtype), jnp.zeros((), params.A.dtype)
        )

    def step(
        self, params: SteadyGains, state: SteadyGainState, inputs: Array
    ) -> tuple[SteadyGainState, Array]:
        """Correct, output, and predict to the next sample."""
        whole = ~jnp.isnan(inputs).any()
        shown = matmul(params.begin, jnp.where(whole, inputs, 0.0))
        x = jnp.where(state.begun > 0, state.x, shown)
        begun = jnp.where(whole, 1.0, state.begun)
        y = jnp.where(begun > 0, inputs - matmul(params.C, x), jnp.nan)
        x = x + matmul(params.K, jnp.where(jnp.isnan(y), 0.0, y))
        return SteadyGainState(matmul(params.A, x), begun), x
