"""What is compiled for problems: functions of a static part, shared by equal problems."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
from jax import Array

from filters import AnyFilter, Settling, run
from objectives import Data, Objective, Way, score, score_and_gradient
from tuner.problem.constraint import Constraint
from tuner.problem.space import Space

Build: TypeAlias = Callable[[dict[str, Array]], Any]
"""Makes the filter's parameters from values by name."""


class Static(NamedTuple):
    """The hashable part of a problem; equal ones share one compilation."""

    space: Space
    filter: AnyFilter | None
    objective: Objective
    build: Build
    constraints: tuple[Constraint, ...]
    steady: bool = False

    @property
    def scored(self) -> AnyFilter | None:
        """The filter, with constant gains where they have settled, if these are wanted."""
        return Settling(self.filter) if self.steady and self.filter is not None else self.filter

    def built(self, z: Array) -> Any:
        """The filter's parameters at z."""
        return self.build(self.space.constrain(z))

    def score(self, z: Array, data: Data) -> Array:
        """The objective at z, inside ``jax.jit``."""
        return score(self.filter, self.objective, self.built(z), data)

    def excesses(self, z: Array, data: Data) -> Array:
        """The excess of each constraint at z, ``(m,)``, inside ``jax.jit``."""
        params = self.built(z)
        found = [c.excess(score(self.filter, c.measure, params, data)) for c in self.constraints]
        return jnp.stack(found) if found else jnp.zeros(0)


@jax.jit(static_argnums=0)
def run_filter(filter: AnyFilter, params: Any, inputs: Any) -> Any:
    """The outputs of a filter over a record, compiled; equal filters share the compilation."""
    return run(filter, params, inputs)[1]


@jax.jit(static_argnums=0)
def value_of(static: Static, z: Array, values: dict[str, Array], given: Array, data: Data) -> Array:
    """The objective at z, or of values by name where these are given: one program for both."""
    at = static.space.constrain(z)
    chosen = {name: jnp.where(given, values[name], own) for name, own in at.items()}
    return score(static.scored, static.objective, static.build(chosen), data)


@jax.jit(static_argnums=(0, 1))
def value_and_gradient_of(static: Static, way: Way, z: Array, data: Data) -> tuple[Array, Array]:
    """The objective at z, and its gradient ``(n,)``."""
    return score_and_gradient(static.scored, static.objective, static.built, z, data, way=way)


@jax.jit(static_argnums=0)
def excesses_of(static: Static, z: Array, data: Data) -> tuple[Array, Array]:
    """The excess of each constraint at z, ``(m,)``, and their Jacobian ``(m, n)``."""

    def twice(at: Array) -> tuple[Array, Array]:
        excess = static.excesses(at, data)
        return excess, excess

    slopes, excess = jax.jacfwd(twice, has_aux=True)(z)
    return excess, slopes
