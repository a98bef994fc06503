"""Heavy-tailed measurements for any filter: an unlikely measurement gets less weight."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from filters.gated import PATIENCE, GatedState, number_type
from filters.measurement_mask import (
    MeasuredEntries,
    MeasurementMask,
    check_innovations,
    with_fields,
)
from filters.protocol import AnyFilter

WHOLE = 2.0
"""Factor on Student's weight, whose product, up to 1, is the weight in use."""


@dataclass(frozen=True)
class Student:
    """A filter that weighs each sample's measurements as Student's t distribution does.

    The m innovations y_i of variances s_i that a sample brings are taken as if all their variances
    were s_i / w, with w = 2 (nu + m) / (nu c + sum y_i^2 / s_i), at most 1. The state is w of the
    way from that of the step without them to that of the step with them: for an estimate and its
    covariance this is exactly the update with the measurements' variances enlarged so that the
    innovations have s_i / w. All numbers of a sample share one weight, as in a multivariate t
    distribution. Known inputs keep theirs, and what the filter takes to start (variance 0) is taken
    whole. After ``patience`` samples in a row of less than half their weight they are taken whole
    until one fits again, so that a wrong start or a jump is left behind.

    The scale c (:func:`spread`) is such that normal innovations look neither too large nor too
    small: R and q keep their meaning, variances outside the tails. The 2 is not
    Student's: with it a weight of a half or more counts as whole, to 2.7 deviations for nu = 4, so
    that normal innovations keep 99 % of their influence. Without it they keep 86 %, the filter
    lags, and a likelihood makes up for that by a q half as large again.

    The outputs gain ``offered`` and ``predicted``, the innovations and their variances before they
    were weighed; ``weight``, w; ``rejected``, 1 where w is below a half; and ``outside``, 1 where
    it would have been (for nu = 4 beyond 4 deviations), ``(m,)`` each; ``variance`` becomes s / w.
    Source: Roth, Ozkan and Gustafsson, A Student's t filter for heavy tailed process and
    measurement noise, ICASSP 2013; Agamennoni, Nieto and Nebot, IEEE Transactions on Signal
    Processing 60(10), 2012.

    Attributes:
        filter: the filter: its state is an estimate with its covariance, and what does not depend
            on the measurements.
        parts: which numbers its innovations are made of, by :func:`filters.measured_entries`.
        nu: degrees of freedom: 3 to 5 for heavy tails, infinite for normal noise; 1 or more.
        patience: samples of little weight in a row after which the next are taken whole; 1 or more.

    >>> from filters import LevelSample, LocalLevel, LocalLevelNoise, measured_entries, run
    >>> level, noise = LocalLevel(dt=1.0), LocalLevelNoise(jnp.array(0.01), jnp.array(1.0))
    >>> record = LevelSample(jnp.array([5.0, 5.0, 4.9, 80.0, 5.1]))
    >>> student = Student(level, measured_entries(level, noise, record), nu=4.0)
    >>> outputs = run(student, noise, record)[1]
    >>> outputs.weight[:, 0].round(3).tolist()
    [1.0, 1.0, 1.0, 0.002, 1.0]
    """

    filter: AnyFilter
    parts: MeasuredEntries
    nu: float = 4.0
    patience: int = PATIENCE
    same_params = True

    def __post_init__(self) -> None:
        if not any(self.parts):
            raise ValueError(
                "no missing number takes an innovation away, so there is nothing to weigh; leave "
                "student out"
            )
        if not self.nu >= 1:
            raise ValueError(
                f"Student's t of {self.nu:g} degrees of freedom has tails that nothing outweighs; "
                "give 1 or more, 3 to 5 for outliers"
            )
        if self.patience < 1:
            raise ValueError(f"a patience of {self.patience} weighs nothing; give 1 or more")

    def init(self, params: Any) -> GatedState:
        """The filter's own start; nothing was unlikely yet."""
        inner = self.filter.init(params)
        return GatedState(inner, jnp.zeros((), number_type(inner)))

    def step(self, params: Any, state: GatedState, inputs: Any) -> tuple[GatedState, Any]:
        """Take one sample with its weight."""
        mask = MeasurementMask(self.parts)
        without = mask.masked(inputs, jnp.ones(len(self.parts), bool))
        taken, output = self.filter.step(params, state.inner, inputs)
        check_innovations(self.filter, output)
        passed, other = self.filter.step(params, state.inner, without)
        y, s = output.innovation, output.variance
        counts = s > 0
        begins = (mask.seen(inputs) & ~counts).any()
        factor = jnp.where(begins, 1.0, weight(y, s, self.nu))
        w = jnp.where(state.outside < self.patience, factor, 1.0)

        def mixed(one: Array, all: Array) -> Array:
            return one + w * (all - one) if jnp.issubdtype(all.dtype, jnp.floating) else all

        inner, mean_output = jax.tree.map(mixed, (passed, other), (taken, output))
        mean_output = mean_output._replace(innovation=y, variance=s / w)
        row = jnp.where(factor < 0.5, state.outside + 1, 0)
        moved = GatedState(inner, jnp.where(counts.any(), row, state.outside))
        kind = with_fields(type(output), ("offered", "predicted", "weight", "rejected", "outside"))
        rejected, outside = ((counts & (v < 0.5)).astype(y.dtype) for v in (w, factor))
        return moved, kind(*mean_output, y, s, jnp.where(counts, w, 1.0), rejected, outside)


def weight(y: Array, s: Array, nu: float) -> Array:
    """The weight of a sample's innovations ``(m,)`` of variances s, 0 where there is none; ``()``.

    >>> one = jnp.ones(1)
    >>> weight(2.0 * one, one, nu=4.0).item(), round(weight(10.0 * one, one, nu=4.0).item(), 4)
    (1.0, 0.0973)
    """
    counts = s > 0
    size = jnp.where(counts, y**2 / jnp.where(counts, s, 1.0), 0.0).sum()
    m = counts.sum()
    return jnp.minimum(1.0, WHOLE * (nu + m) / (nu * spreads(nu, len(s), s.dtype)[m] + size))


def spreads(nu: float, largest: int, dtype: Any) -> Array:
    """:func:`spread` of 0 to ``largest`` numbers, ``(largest + 1,)``."""
    return jnp.array([1.0, *(spread(nu, m) for m in range(1, largest + 1))], dtype)


@cache
def spread(nu: float, m: int) -> float:
    """The c for which m normal innovations of variance 1 fit t of the scale c as it is.

    The likelihood of m numbers y of the scale t c is flat at t = 1 where the mean of
    (nu + m) y'y / (nu c + y'y) is m.

    >>> round(spread(4.0, 1), 4), round(spread(1e6, 1), 4)
    (0.6906, 1.0)
    """
    from scipy.integrate import quad
    from scipy.optimize import brentq
    from scipy.stats import chi2

    law = chi2(m)

    def over(c: float) -> float:
        total = quad(lambda u: (nu + m) * law.ppf(u) / (nu * c + law.ppf(u)), 0, 1, limit=200)[0]
        return float(total - m)

    return float(brentq(over, 1e-3, 1.5, xtol=1e-10))
