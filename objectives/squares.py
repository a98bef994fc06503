"""Sums of squares, and their root: the building blocks of this package's objectives."""

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array


class Squares(NamedTuple):
    """A sum of squares, and the number of samples in it, ``()`` each."""

    total: Array
    samples: Array

    @classmethod
    def none(cls) -> "Squares":
        """The empty sum."""
        return cls(jnp.zeros(()), jnp.zeros(()))

    def plus(self, squares: Array, seen: Array) -> "Squares":
        """The sum with further squares, of which those marked as seen count; equal shapes."""
        counted = jnp.where(seen, squares, 0.0).sum()
        return Squares(self.total + counted, self.samples + seen.sum().astype(squares.dtype))

    def root_mean(self) -> Array:
        """The root mean square, ``()``; NaN where nothing counts.

        >>> Squares.none().plus(jnp.array([9.0, 16.0]), jnp.array([True, False])).root_mean().item()
        3.0
        """
        mean = self.total / self.samples
        return jnp.where(jnp.isnan(mean), mean, root(mean))


def root(square: Array) -> Array:
    """A square root with the derivative 0 at 0; 0 below it, and NaN of NaN."""
    positive = square > 0
    return jnp.where(positive, jnp.sqrt(jnp.where(positive, square, 1.0)), 0 * square)
