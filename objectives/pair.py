"""Weighed combinations of two objectives, which make up a Pareto front."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array

from objectives.kinds import kind_of
from objectives.score import Fold


class Both(NamedTuple):
    """The truths of both, and how much the second weighs, time first.

    The weight travels with the data, so that all points of a front share one compilation.

    Attributes:
        first, second: the reference of each objective.
        weight: of the second, from 0 to 1, the same at every sample, ``(N,)``.
    """

    first: Any
    second: Any
    weight: Any


class Sums(NamedTuple):
    """The sum of each objective, and the weight."""

    first: Any
    second: Any
    weight: Array


@dataclass(frozen=True)
class WeighedPair:
    """The weighed geometric mean of two objectives: exp((1 - w) ln first + w ln second).

    A likelihood counts by its nats, which are a logarithm already; no unit matters. What is least
    with some weight w between 0 and 1 is on the Pareto front: no other point is better in both.
    Source: Miettinen, Nonlinear Multiobjective Optimization, 1999, 3.1.

    Attributes:
        first: one objective.
        second: the other.
    """

    first: Fold
    second: Fold

    def init(self) -> Sums:
        """The empty sums."""
        return Sums(self.first.init(), self.second.init(), jnp.zeros(()))

    def update(self, total: Sums, output: Any, truth: Both) -> tuple[Sums, tuple[Any, Any]]:
        """Add one sample to both."""
        first, kept = self.first.update(total.first, output, truth.first)
        second, also = self.second.update(total.second, output, truth.second)
        return Sums(first, second, truth.weight), (kept, also)

    def value(self, total: Sums, kept: tuple[Any, Any]) -> Array:
        """The mean, ``()``."""
        one, other = self.logarithms(total, kept)
        return jnp.exp((1 - total.weight) * one + total.weight * other)

    def logarithms(self, total: Sums, kept: tuple[Any, Any]) -> tuple[Array, Array]:
        """The logarithms of both."""
        values = self.first.value(total.first, kept[0]), self.second.value(total.second, kept[1])
        return logarithm(self.first, values[0]), logarithm(self.second, values[1])


def logarithm(objective: Any, value: Array | float) -> Array:
    """The logarithm of an objective's value; of a likelihood its nats, of squares half of it."""
    kind = kind_of(objective)
    if kind == "likelihood":
        return jnp.asarray(value)
    return jnp.log(value) / (2 if kind == "mean square" else 1)
