"""The variance of an error over a whole history, not only at its end."""

from dataclasses import dataclass

import jax.numpy as jnp
from jax import Array

from filters import Uncertainty


@dataclass(frozen=True)
class VarianceRatio:
    """The geometric mean, over the samples that count, of a variance over a reference.

    With the Kalman filter's variances as the reference it is at least 1, and 1 for its gains. A
    score of the last sample alone could be gamed: gains that are a thousand times worse in between
    may end well.

    Attributes:
        state: index of the state whose variance counts.
        samples: how many samples count (those with a reference that is not NaN).
    """

    state: int
    samples: int

    def init(self) -> Array:
        """The empty sum."""
        return jnp.zeros(())

    def update(self, total: Array, output: Uncertainty, truth: Array) -> tuple[Array, None]:
        """Add one sample; ``truth`` is the reference variance, NaN where the sample is left out."""
        ratio = jnp.log(output.P[self.state, self.state] / truth)
        return total + jnp.where(jnp.isnan(truth), 0.0, ratio), None

    def value(self, total: Array, kept: None) -> Array:
        """The mean ratio."""
        return jnp.exp(total / self.samples)
