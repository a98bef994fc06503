"""Distributions of innovations with outliers: behind a gate, and with heavy tails."""

from dataclasses import dataclass
from math import log, pi
from typing import Any

import jax.numpy as jnp
from jax import Array
from jax.scipy.special import gammaln

from filters.student import spreads


@dataclass(frozen=True)
class PartlyWrong:
    """Innovations of a gated filter, of which some are wrong.

    A number is right with probability 1 - share, and then its innovation y has the filter's
    variance s; or it is wrong and lies anywhere in a range of some width: the density is
    (1 - share) N(y; 0, s) + share / width. So what is refused costs a constant, some ten nats,
    which is more than a right number costs and less than a wrong one taken for right would; to
    refuse everything is dear. Numbers inside the gate and beyond count by one formula, so that the
    gate does not cut the tails off, which would bias the variances, and nothing jumps where a
    number passes it. The share is small: where nothing is wrong it moves a variance by less than
    1 %. Source: Box and Tiao, Biometrika 55(1), 1968, with an even density of what is wrong.

    The outputs are those of :class:`filters.Gated`.

    Attributes:
        widths: of each innovation, ``(m,)``: how far apart wrong numbers may lie, in its unit.
        share: of the numbers that are wrong, as far as is known beforehand.

    >>> from collections import namedtuple
    >>> far = namedtuple("O", "offered predicted")(jnp.array([1e9]), jnp.ones(1))
    >>> law = PartlyWrong(widths=(200.0,))
    >>> round(float(law.added(far, jnp.array([True]))[0][0]), 2)  # ln (200 / 0.001)
    12.21
    """

    widths: tuple[float, ...]
    share: float = 1e-3

    def added(self, output: Any, wanted: Array) -> tuple[Array, Array]:
        """Each number's term, nats, and whether it counts, ``(m,)``."""
        seen = wanted & (output.predicted != 0)
        s = jnp.where(seen, output.predicted, 1.0)
        right = log(1 - self.share) - (output.offered**2 / s + jnp.log(s) + log(2 * pi)) / 2
        wrong = jnp.log(self.share / jnp.asarray(self.widths, right.dtype))
        return jnp.where(seen, -jnp.logaddexp(right, wrong), 0.0), seen


@dataclass(frozen=True)
class HeavyTails:
    """Innovations with Student's t distribution, of a filter that weighs by it.

    The m innovations of a sample are one draw of a multivariate t distribution of nu degrees of
    freedom and the scales c s_i, c by :func:`filters.student.spread`; each number adds the negative
    logarithm of its density given those before it in the sample. Together with the update of
    :class:`filters.Student`: alone, with an update that takes outliers whole, it makes q too large,
    for the filter has to come back from every one of them. Outputs as of that filter.

    Attributes:
        nu: degrees of freedom, those of the filter.

    >>> from collections import namedtuple
    >>> seen = namedtuple("O", "offered predicted")(jnp.array([100.0]), jnp.ones(1))
    >>> round(float(HeavyTails(nu=4.0).added(seen, jnp.array([True]))[0][0]), 2)  # normal: 5001
    21.28
    """

    nu: float = 4.0

    def added(self, output: Any, wanted: Array) -> tuple[Array, Array]:
        """Each number's term, nats, and whether it counts, ``(m,)``."""
        seen = wanted & (output.predicted != 0)
        s = jnp.where(seen, output.predicted, 1.0)
        k = jnp.cumsum(seen, axis=-1) - seen  # those before it
        size = jnp.where(seen, output.offered**2 / s, 0.0)
        c = self.nu * spreads(self.nu, s.shape[-1], s.dtype)[seen.sum(axis=-1, keepdims=True)]
        after = c + jnp.cumsum(size, axis=-1)
        free = (self.nu + k) / 2
        each = (jnp.log(s) + log(pi)) / 2 + gammaln(free) - gammaln(free + 0.5)
        each += (free + 0.5) * jnp.log(after) - free * jnp.log(after - size)
        return jnp.where(seen, each, 0.0), seen
