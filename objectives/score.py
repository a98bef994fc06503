"""What an objective is, and how a filter is scored by one."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeGuard, cast

import jax
import jax.numpy as jnp
from jax import Array

from filters import AnyFilter, run


class Fold(Protocol):
    """An objective that takes part in the time loop: it sums up what it can and keeps the rest."""

    def init(self) -> Any:
        """The sum before the first sample, any pytree."""
        ...

    def update(self, total: Any, output: Any, truth: Any) -> tuple[Any, Any]:
        """One sample: the new sum, and what has to be kept of this sample (None: nothing)."""
        ...

    def value(self, total: Any, kept: Any) -> Array:
        """One number from the finished sum and what was kept, stacked along time."""
        ...


Measure: TypeAlias = Callable[[Any, Any], Array]
Objective: TypeAlias = Fold | Measure
"""A :class:`Fold`, or a plain function of a filter's stacked outputs and the truth: one number."""


class Data(NamedTuple):
    """What a filter is scored on.

    Attributes:
        inputs: the filter's inputs, a pytree whose leaves have time first, ``(N, ...)``.
        truth: what the outputs are held against; for a :class:`Fold`, with time first.
    """

    inputs: Any
    truth: Any


@dataclass(frozen=True)
class Folded:
    """A filter with an objective in its loop: the state is the pair, the output is what is kept."""

    filter: AnyFilter
    fold: Fold

    def init(self, params: Any) -> tuple[Any, Any]:
        """Both states before the first sample."""
        return self.filter.init(params), self.fold.init()

    def step(
        self, params: Any, state: tuple[Any, Any], inputs: Data
    ) -> tuple[tuple[Any, Any], Any]:
        """One sample of the filter, then of the objective."""
        inner, output = self.filter.step(params, state[0], inputs.inputs)
        total, kept = self.fold.update(state[1], output, inputs.truth)
        return (inner, total), kept


def score(filter: AnyFilter, objective: Objective, params: Any, data: Data) -> Array:
    """Run a filter over the data and score it: one number, differentiable in ``params``."""
    return _judge(objective, data, _collect(filter, objective, params, data))


def score_and_gradient(
    filter: AnyFilter, objective: Objective, build: Callable[[Array], Any], z: Array, data: Data
) -> tuple[Array, Array]:
    """The score and its gradient in z, ``(n,)``, where ``build(z)`` gives the filter's parameters.

    The time loop is differentiated forwards (n is small, and nothing has to be stored for a way
    back), what follows it backwards: one transform of the outputs serves all n parameters.
    """
    along = jax.vmap(
        lambda tangent: jax.jvp(
            lambda point: _collect(filter, objective, build(point), data), (z,), (tangent,)
        ),
        out_axes=(None, 0),
    )
    collected, tangents = along(jnp.eye(z.shape[0]))
    value, pull = jax.vjp(lambda seen: _judge(objective, data, seen), collected)
    (weights,) = pull(jnp.ones_like(value))
    pairs = zip(jax.tree.leaves(weights), jax.tree.leaves(tangents), strict=True)
    parts = [jnp.tensordot(t, w, axes=w.ndim) for w, t in pairs if w.dtype != jax.dtypes.float0]
    return value, sum(parts, jnp.zeros_like(z))


def is_fold(objective: Objective) -> TypeGuard[Fold]:
    """Whether an objective takes part in the time loop."""
    return hasattr(objective, "update")


def _collect(filter: AnyFilter, objective: Objective, params: Any, data: Data) -> tuple[Any, Any]:
    """The loop's part: the objective's sum and what was kept, or all outputs."""
    if is_fold(objective):
        (_, total), kept = run(Folded(filter, objective), params, data)
        return total, kept
    return None, run(filter, params, data.inputs)[1]


def _judge(objective: Objective, data: Data, collected: tuple[Any, Any]) -> Array:
    """The part after the loop: one number."""
    if is_fold(objective):
        return objective.value(*collected)
    return cast("Measure", objective)(collected[1], data.truth)
