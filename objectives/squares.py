"""Sums of squares, and their root: what the objectives of this package are made of."""

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array


class Squares(NamedTuple):
    """A sum of squares, and of how many samples, ``()`` each."""

    total: Array
    samples: Array

    @classmethod
    def none(cls) -> "Squares":
        """Before the first sample."""
        return cls(jnp.zeros(()), jnp.zeros(()))

    def plus(self, squares: Array, seen: Array) -> "Squares":
        """With the squares of some samples, of which those count that are seen; equal shapes."""
        counted = jnp.where(seen, squares, 0.0).sum()
        return Squares(self.total + counted, self.samples + seen.sum().astype(squares.dtype))

    def root_mean(self) -> Array:
        """The root of the mean, ``()``; NaN where nothing counts.

        >>> Squares.none().plus(jnp.array([9.0, 16.0]), jnp.array([True, False])).root_mean().item()
        3.0
        """
        mean = self.total / self.samples
        return jnp.where(jnp.isnan(mean), mean, root(mean))


def root(square: Array) -> Array:
    """A square root with the derivative 0 at 0; 0 below it, and NaN of NaN."""
    positive = square > 0
    return jnp.where(positive, jnp.sqrt(jnp.where(positive, square, 1.0)), 0 * square)
