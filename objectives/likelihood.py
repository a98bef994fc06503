"""How well a Kalman filter predicts its measurements: the likelihood of its innovations."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol

import jax.numpy as jnp
from jax import Array

from objectives.kinds import Kind


class Likely(NamedTuple):
    """The negative logarithm of the density of the numbers so far, nats, and how many they are."""

    nats: Array
    numbers: Array


class Law(Protocol):
    """The distribution of innovations, which gives each number's term of the likelihood."""

    def added(self, output: Any, wanted: Array) -> tuple[Array, Array]:
        """The nats of each number, 0 where it does not count, and whether it counts, ``(m,)``."""


@dataclass(frozen=True)
class Normal:
    """Innovations y of variances s are normal: y^2 / s + ln s + ln 2 pi, halved.

    The outputs need ``innovation`` and ``variance``, ``(m,)``; a variance of 0 does not count,
    which a filter's is where nothing was measured.
    """

    def added(self, output: Any, wanted: Array) -> tuple[Array, Array]:
        """The nats of each number, 0 where it does not count, and whether it counts."""
        seen = wanted & (output.variance != 0)
        variance = jnp.where(seen, output.variance, 1.0)
        nats = (output.innovation**2 / variance + jnp.log(variance) + math.log(2 * math.pi)) / 2
        return jnp.where(seen, nats, 0.0), seen


@dataclass(frozen=True)
class InnovationLikelihood:
    """Mean negative logarithm of the density of a measured number, in nats.

    For normal innovations y of variances s, taken one after another, it is
    L = mean(y^2 / s + ln s + ln 2 pi) / 2, which may be negative. A difference of 1 / N, N numbers
    counting, is one nat of the whole record: the likelihood differs by a factor e. The unit of y
    shifts L and moves no optimum. :meth:`deviation` says L in the unit of y.

    A number counts where the truth is not NaN and its law says so. The truth is the measurement
    ``(m,)``, or ``()``, which stands for all m: zeros ``(N,)`` leave it to the filter what counts.
    Source: Schweppe, IEEE Transactions on Information Theory 11, 1965.

    Attributes:
        law: normal, or one of :mod:`objectives.robust` for measurements of which some are wrong.

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

    law: Law = Normal()
    kind: ClassVar[Kind] = "likelihood"

    def init(self) -> Likely:
        """The empty sum."""
        return Likely(jnp.zeros(()), jnp.zeros(()))

    def added(self, output: Any, truth: Array) -> tuple[Array, Array]:
        """The nats of each number, 0 where it does not count, and whether it counts."""
        return self.law.added(output, ~jnp.isnan(truth))

    def update(self, total: Likely, output: Any, truth: Array) -> tuple[Likely, None]:
        """Add one sample."""
        nats, counted = self.added(output, truth)
        return Likely(total.nats + nats.sum(), total.numbers + counted.sum()), None

    def value(self, total: Likely, kept: None) -> Array:
        """The mean, ``()``; NaN where nothing counts."""
        return total.nats / total.numbers

    def deviation(self, value: Array | float) -> Array:
        """The deviation within which a number is predicted: exp(L) / sqrt(2 pi e), in its unit.

        It is sqrt(s) for a filter whose s is constant and right, and larger for one that predicts
        worse, or that is surer or less sure than it may be. Infinite beyond all numbers.
        """
        return jnp.exp(jnp.asarray(value) - math.log(2 * math.pi * math.e) / 2)
