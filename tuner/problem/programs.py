"""The compiled programs of problems: functions of a static part, shared by equal problems."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import AnyFilter, Settling, assembled, run
from objectives import (
    Data,
    Fold,
    Folded,
    Objective,
    Way,
    kept_bytes,
    score,
    score_and_gradient,
    sum_and_gradient,
)
from tuner.problem.constraint import Constraint
from tuner.problem.space import Space
from tuner.stored_programs import QUICKLY, stored_jit, stored_text

Build: TypeAlias = Callable[[dict[str, Array]], Any]
"""Makes the filter's parameters from values by name."""


@dataclass(frozen=True)
class Assemble:
    """Makes the parameters of a filter that declares them, from values by name."""

    filter: Any

    def __call__(self, values: dict[str, Array]) -> Any:
        """The parameters that the filter's ``init`` and ``step`` take."""
        return assembled(self.filter, values)


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

    @property
    def summing(self) -> tuple[AnyFilter, Fold]:
        """The filter and the objective of a problem that has both in its time loop."""
        return cast("tuple[AnyFilter, Fold]", (self.filter, self.objective))

    def chosen(self, z: Array, values: dict[str, Array], given: Array) -> Any:
        """The filter's parameters at z, or of values by name where these are given."""
        at = self.space.constrain(z)
        return self.build({name: jnp.where(given, values[name], own) for name, own in at.items()})

    def score(self, z: Array, data: Data) -> Array:
        """The objective at z, inside ``jax.jit``."""
        return score(self.filter, self.objective, self.built(z), data)

    def excesses(self, z: Array, data: Data) -> Array:
        """The excess of each constraint at z, ``(m,)``, inside ``jax.jit``."""
        params = self.built(z)
        found = [c.excess(score(self.filter, c.measure, params, data)) for c in self.constraints]
        return jnp.stack(found) if found else jnp.zeros(0)


def kept_bytes_of(static: Static, z: np.ndarray, data: Data) -> int:
    """Memory in bytes that a run at a point keeps for what follows its time loop."""

    def counted() -> str:
        params = jax.eval_shape(static.built, z)
        return str(kept_bytes(static.filter, static.objective, params, data))

    shapes = jax.tree.map(lambda leaf: (np.shape(leaf), np.asarray(leaf).dtype.str), data)
    return int(stored_text(counted, "kept bytes", static, shapes))


@stored_jit(1)
def run_filter(filter: AnyFilter, params: Any, inputs: Any) -> Any:
    """The outputs of a filter over a record, compiled; equal filters share the compilation."""
    return run(filter, params, inputs)[1]


@stored_jit(1, **QUICKLY)
def try_filter(filter: AnyFilter, params: Any, inputs: Any) -> Any:
    """The same for a trial, whose rounding is not that of :func:`run_filter`."""
    return run(filter, params, inputs)[1]


@stored_jit(1)
def value_of(static: Static, z: Array, values: dict[str, Array], given: Array, data: Data) -> Array:
    """The objective at z, or of values by name where these are given: one program for both."""
    return score(static.scored, static.objective, static.chosen(z, values, given), data)


def by_name(values: dict[str, np.ndarray], *, given: bool) -> tuple[dict[str, Array], Array]:
    """Values by name and whether they are given, as :func:`value_of` takes both: on the device."""
    on_device: tuple[dict[str, Array], Array] = jax.device_put((values, np.bool_(given)))
    return on_device


@stored_jit(1)
def sum_of(static: Static, z: Array, values: dict[str, Array], given: Array, data: Data) -> Any:
    """The sum of an objective that keeps nothing else; arguments as of :func:`value_of`."""
    loop = Folded(*static.summing)
    return run(loop, static.chosen(z, values, given), data)[0][1]


@stored_jit(2)
def sum_and_gradient_of(static: Static, way: Way, z: Array, data: Data) -> tuple[Any, Array]:
    """The sum at z, and the gradient ``(n,)`` of its first number."""
    return sum_and_gradient(*static.summing, static.built, z, data, way=way)


@stored_jit(1)
def judged_of(objective: Fold, total: Any) -> tuple[Array, Array]:
    """The objective of a sum, and its derivative by the sum's first number."""

    def value(first: Array) -> Array:
        return objective.value(type(total)(first, *total[1:]), None)

    return jax.value_and_grad(value)(total[0])


@stored_jit(2)
def value_and_gradient_of(static: Static, way: Way, z: Array, data: Data) -> tuple[Array, Array]:
    """The objective at z, and its gradient ``(n,)``."""
    return score_and_gradient(static.scored, static.objective, static.built, z, data, way=way)


@stored_jit(1)
def excesses_of(static: Static, z: Array, data: Data) -> tuple[Array, Array]:
    """The excess of each constraint at z, ``(m,)``, and their Jacobian ``(m, n)``."""

    def twice(at: Array) -> tuple[Array, Array]:
        excess = static.excesses(at, data)
        return excess, excess

    slopes, excess = jax.jacfwd(twice, has_aux=True)(z)
    return excess, slopes


def finite(value: float) -> float:
    """A value, or infinity where it is not a number."""
    return value if math.isfinite(value) else math.inf
