"""How well a Kalman filter foretells its measurements: the likelihood of its innovations."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array


class Likely(NamedTuple):
    """Sum of y^2 / s + ln s over the numbers that count so far, and how many there were."""

    total: Array
    numbers: Array


@dataclass(frozen=True)
class InnovationLikelihood:
    """The deviation of a measured number, as far as the filter foretells it.

    For innovations y of variances s, taken one after another, the mean negative logarithm of the
    Gaussian density of a number is L = mean(y^2 / s + ln s + ln 2 pi) / 2. The value is
    exp(L) / sqrt(2 pi e), in the unit of y: sqrt(s) for a filter whose s is constant and right, and
    larger for one that foretells worse, or that is surer or less sure than it may be. It is least
    where L is, and ln value moves as L does.

    The outputs need ``innovation`` and ``variance``, ``(m,)``. A number counts where the truth is
    not NaN and its variance is not 0, which a filter's is where nothing was measured. The truth is
    the measurement ``(m,)``, or ``()``, which stands for all m: zeros ``(N,)`` leave it to the
    filter what counts. Source: Schweppe, IEEE Transactions on Information Theory 11, 1965.
    """

    def init(self) -> Likely:
        """Nothing yet."""
        return Likely(jnp.zeros(()), jnp.zeros(()))

    def update(self, total: Likely, output: Any, truth: Array) -> tuple[Likely, None]:
        """Add one sample."""
        seen = ~jnp.isnan(truth) & (output.variance != 0)
        variance = jnp.where(seen, output.variance, 1.0)
        each = output.innovation**2 / variance + jnp.log(variance)
        added = jnp.where(seen, each, 0.0).sum()
        return Likely(total.total + added, total.numbers + seen.sum()), None

    def value(self, total: Likely, kept: None) -> Array:
        """The deviation, ``()``; NaN where nothing counts."""
        return jnp.exp((total.total / total.numbers - 1) / 2)
