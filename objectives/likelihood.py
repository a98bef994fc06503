"""How well a Kalman filter foretells its measurements: the likelihood of its innovations."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import jax.numpy as jnp
from jax import Array

from objectives.kinds import Kind


class Likely(NamedTuple):
    """The negative logarithm of the density of the numbers so far, nats, and how many they are."""

    nats: Array
    numbers: Array


@dataclass(frozen=True)
class InnovationLikelihood:
    """Mean negative logarithm of the Gaussian density of a measured number, in nats.

    For innovations y of variances s, taken one after another, it is
    L = mean(y^2 / s + ln s + ln 2 pi) / 2, which may be negative. A difference of 1 / N, N numbers
    counting, is one nat of the whole record: the likelihood differs by a factor e. The unit of y
    shifts L and moves no optimum. :meth:`deviation` says L in the unit of y.

    The outputs need ``innovation`` and ``variance``, ``(m,)``. A number counts where the truth is
    not NaN and its variance is not 0, which a filter's is where nothing was measured. The truth is
    the measurement ``(m,)``, or ``()``, which stands for all m: zeros ``(N,)`` leave it to the
    filter what counts. Source: Schweppe, IEEE Transactions on Information Theory 11, 1965.

    >>> from typing import NamedTuple
    >>> class Outputs(NamedTuple):
    ...     innovation: Array
    ...     variance: Array
    >>> likelihood = InnovationLikelihood()
    >>> two = Outputs(jnp.array([3.0, -3.0]), jnp.array([9.0, 9.0]))
    >>> total, _ = likelihood.update(likelihood.init(), two, jnp.zeros(2))
    >>> round(float(likelihood.deviation(likelihood.value(total, None))), 12)
    3.0
    """

    kind: ClassVar[Kind] = "likelihood"

    def init(self) -> Likely:
        """Nothing yet."""
        return Likely(jnp.zeros(()), jnp.zeros(()))

    def added(self, output: Any, truth: Array) -> tuple[Array, Array]:
        """The nats of each number, 0 where it does not count, and whether it counts."""
        seen = ~jnp.isnan(truth) & (output.variance != 0)
        variance = jnp.where(seen, output.variance, 1.0)
        nats = (output.innovation**2 / variance + jnp.log(variance) + math.log(2 * math.pi)) / 2
        return jnp.where(seen, nats, 0.0), seen

    def update(self, total: Likely, output: Any, truth: Array) -> tuple[Likely, None]:
        """Add one sample."""
        return added_up(total, self.added(output, truth)), None

    def value(self, total: Likely, kept: None) -> Array:
        """The mean, ``()``; NaN where nothing counts."""
        return total.nats / total.numbers

    def deviation(self, value: Array | float) -> Array:
        """The deviation within which a number is foretold: exp(L) / sqrt(2 pi e), in its unit.

        It is sqrt(s) for a filter whose s is constant and right, and larger for one that foretells
        worse, or that is surer or less sure than it may be. Infinite beyond all numbers.
        """
        return deviation_of(value)


def added_up(total: Likely, added: tuple[Array, Array]) -> Likely:
    """One sample's numbers added to a sum."""
    amounts, counted = added
    return Likely(total.nats + amounts.sum(), total.numbers + counted.sum())


def deviation_of(value: Array | float) -> Array:
    """exp(L) / sqrt(2 pi e).

    >>> round(float(deviation_of(jnp.log(jnp.sqrt(2 * jnp.pi * jnp.e)) + jnp.log(3.0))), 12)
    3.0
    """
    return jnp.exp(jnp.asarray(value) - math.log(2 * math.pi * math.e) / 2)
