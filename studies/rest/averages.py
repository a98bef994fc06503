"""Walk and white noise by maximum likelihood: exactly, from sines.

Means over m samples of a random walk with white noise are such a thing again, a local level, whose
increments have the covariance of a moving average of order one. Its eigenvectors are sines, so one
transform makes the increments independent; what the filter's innovations say one by one (filters.
LocalLevel, with nothing known at the start) these say at once.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from studies.rest.curve import Limited
from tuner.data.signal import Floats

MOST = 50_000
"""Largest number of means: the white noise's limits are then 0.6 % apart."""
_NATS = 1.920729
"""Fall of the log-likelihood at 95 % limits: half of chi-square's 3.84."""


class Level(NamedTuple):
    """A local level: its variances per mean, or N and K."""

    R: float
    Q: float


@dataclass(frozen=True, eq=False)
class Averages:
    """Means over ``factor`` samples of an axis, and their likelihood.

    Attributes:
        factor: number of samples in a mean.
        dt: sample time of the axis, s.
        means: ``(n,)``.
        powers: squares of the transformed increments, ``(n - 1,)``.
        waves: 2 - 2 cos of their frequencies, ``(n - 1,)``.
    """

    factor: int
    dt: float
    means: Floats
    powers: Floats
    waves: Floats

    @classmethod
    def of(cls, values: Floats, dt: float, factor: int) -> "Averages":
        """Means over the given number of samples, or over more, to have at most ``MOST``."""
        from scipy.fft import dst

        m = max(factor, -(-len(values) // MOST))
        count = len(values) // m
        means = values[: count * m].reshape(count, m).mean(axis=1)
        powers = dst(np.diff(means), type=1, norm="ortho") ** 2
        waves = 4 * np.sin(np.pi * np.arange(1, count) / (2 * count)) ** 2
        return cls(m, dt, means, powers, waves)

    @property
    def step(self) -> float:
        """Seconds between means."""
        return self.factor * self.dt

    def level(self, white: float, walk: float) -> Level:
        """R and Q of the means for N and K; R may be negative where the walk is nearly all."""
        m, q = self.factor, walk**2 * self.dt
        return Level(white**2 / self.step - q * (m * m - 1) / (6 * m), q * m)

    def densities(self, R: Any, Q: Any) -> tuple[Any, Any]:
        """N and K for R and Q of the means, numbers or arrays of any kind."""
        m, q = self.factor, Q / self.factor
        return ((R + q * (m * m - 1) / (6 * m)) * self.step) ** 0.5, (q / self.dt) ** 0.5

    def nats(self, white: float, walk: float) -> float:
        """Minus the log-likelihood of N and K, up to a constant."""
        R, Q = self.level(white, walk)
        variances = Q + R * self.waves
        if not variances.min() > 0:
            return np.inf
        return float(np.sum(np.log(variances) + self.powers / variances)) / 2


def most_likely(averages: Averages) -> tuple[Limited, Limited]:
    """N and K of greatest likelihood with their 95 % profile limits.

    A lower limit of 0 says that there may be no walk at all; the estimate itself may then be 0.

    The time N / K, from which on the walk is more than the noise, is looked for from less than a
    step of the means to a hundred times the record.
    """
    longest = 100 * averages.step * len(averages.means)
    ratios = np.geomspace(1 / longest, 3 / averages.step, 60)
    profile = [_scaled(averages, ratio)[0] for ratio in ratios]
    near = float(ratios[int(np.argmin(profile))])
    ratio = float(_least(lambda x: _scaled(averages, np.exp(x))[0], near, np.log(3.0)).x)
    best, N = _scaled(averages, np.exp(ratio))
    still, alone = _scaled(averages, 0.0)
    if still <= best + 1e-6:
        best, N, ratio = still, alone, -np.inf
    K = N * float(np.exp(ratio))
    return _white_limits(averages, best, N, K), _walk_limits(averages, best, still, N, K)


def _scaled(averages: Averages, ratio: float) -> tuple[float, float]:
    """The least nats for a ratio K/N over all N, and the minimiser N."""
    R, Q = averages.level(1.0, ratio)
    variances = Q + R * averages.waves
    if not variances.min() > 0:
        return np.inf, 1.0
    square = float(np.mean(averages.powers / variances))
    n = len(averages.powers)
    return (n * np.log(square) + n + float(np.log(variances).sum())) / 2, float(np.sqrt(square))


def _white_limits(averages: Averages, best: float, N: float, K: float) -> Limited:
    def excess(white: float) -> float:
        still = averages.nats(white, 0.0)
        if K > 0:
            still = min(still, _least(lambda x: averages.nats(white, np.exp(x)), K, 3.0).fun)
        return still - best - _NATS

    spread = 3 / np.sqrt(len(averages.powers))
    return Limited(N, _crossing(excess, N, -spread), _crossing(excess, N, spread))


def _walk_limits(averages: Averages, best: float, still: float, N: float, K: float) -> Limited:
    def excess(walk: float) -> float:
        found = _least(lambda x: averages.nats(np.exp(x), walk), N, 1.0).fun
        return float(found) - best - _NATS

    begin = K or N / np.sqrt(averages.step) / len(averages.means)
    low = 0.0 if still - best <= _NATS else _crossing(excess, begin, -0.3)
    return Limited(K, low, _crossing(excess, begin, 0.3))


def _least(function: Callable[[float], float], around: float, reach: float) -> Any:
    """The minimum of a function of a logarithm, around a positive number."""
    from scipy.optimize import minimize_scalar

    at = float(np.log(around))
    bounds = (at - reach, at + reach)
    return minimize_scalar(function, bounds=bounds, method="bounded", options={"xatol": 1e-7})


def _crossing(excess: Callable[[float], float], start: float, step: float) -> float:
    """The point at which a function of a positive number rises above 0, in logarithmic steps."""
    from scipy.optimize import brentq

    at = 0.0
    inner = excess(start)
    if inner > 0:  # it begins above: where the estimate is 0, the limit may lie below the start
        step = -step
    for _ in range(60):
        if (excess(start * np.exp(at + step)) > 0) != (inner > 0):
            break
        at += step
        step *= 1.5
    low, high = sorted((at, at + step))
    found = brentq(lambda x: excess(start * np.exp(x)), low, high, xtol=1e-4)
    return float(start * np.exp(found))
