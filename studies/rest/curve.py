"""White noise, bias instability and random walk, read from an Allan curve.

The model is avar(tau) = N^2 / tau + (2 ln 2 / pi) F^2 + K^2 tau / 3: white noise, flicker noise
and a random walk of the rate (IEEE Std 952-1997, annex C). It is linear in the squares, which are
found by generalised least squares. F is left out where the curve does not ask for it.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tuner.data.allan import AllanCurve, chi_square_limits
from tuner.data.signal import Floats

FLICKER = 2 * np.log(2) / np.pi
"""The Allan variance of flicker noise over its squared coefficient."""
ROOM = 0.02
"""Tolerance of an Allan variance at short times, at which its density is 1 % off."""
_FITTED = 2  # every second point: neighbours are nearly redundant
_LATER = 3  # half a decade
_SPANS = 5  # the fit's last point averages a fifth of the record
_SURE = 3.84
"""Least reduction of chi-square by a term of the model."""


class Limited(NamedTuple):
    """A number with its 95 % limits; low is 0 where only the upper one is known."""

    value: float
    low: float
    high: float

    def times(self, factor: float) -> "Limited":
        """The number in another unit."""
        return Limited(*(factor * number for number in self))

    @property
    def known(self) -> bool:
        """Whether it is more than an upper limit."""
        return self.low > 0


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise parameters read from an Allan curve, in the record's unit.

    Attributes:
        curve: the curve.
        white: N, unit/sqrt(Hz).
        flicker: F, unit; 0 where the curve does not ask for it.
        walk: K, unit/s/sqrt(Hz).
        instability: B = the curve's floor over 0.664, unit, as sensors are compared by.
        floor_s: where the floor is, the least upper limit of the curve, s.
        from_s: the shortest averaging time that is white noise, s.
        to_s: the longest that was fitted, s.
        fits: whether the model explains the curve.
    """

    curve: AllanCurve
    white: Limited
    flicker: Limited
    walk: Limited
    instability: Limited
    floor_s: float
    from_s: float
    to_s: float
    fits: bool

    def model(self, taus: Floats) -> Floats:
        """The model's Allan deviations, unit."""
        squares = np.array([self.white.value, self.flicker.value, self.walk.value]) ** 2
        return np.asarray(np.sqrt(_columns(taus) @ squares))


def read_noise(curve: AllanCurve) -> Noise:
    """Fit the curve from the shortest averaging time on from which it is white noise.

    A sensor's own filter, and coarse steps, bend the curve at short times. So the fit begins at
    the first point from which on, over a decade, the model holds within ``ROOM`` and chance, and
    from where half a decade later would give no other density. Where there is a bend before that
    point, some of it is left that chance hides, more in a short record. It fades as 1 / tau, so
    the fit then begins half a decade later, if white noise is still the most there.
    """
    last = max(int(np.searchsorted(curve.taus, curve.taus[-1] * 3 / _SPANS, "right")), 4)
    white = _white_from(curve, last)
    first = _beyond_the_bend(curve, white, last) if white else 0
    # The floor has the least upper limit: far out a few means may differ little by chance.
    lowest = int(np.argmin(curve.highs[first:last])) + first
    floor = Limited(*(float(c[lowest]) for c in (curve.deviations, curve.lows, curve.highs)))
    return replace(
        _fit(curve, first, last),
        instability=floor.times(float(1 / np.sqrt(FLICKER))),
        floor_s=float(curve.taus[lowest]),
        from_s=float(curve.taus[first]),
        to_s=float(curve.taus[last - 1]),
        fits=white is not None,
    )


def _white_from(curve: AllanCurve, last: int) -> int | None:
    """The first point from which the curve has no bend; None where there is none."""
    for first in range(max(last - 3, 1)):
        tried = _fit(curve, first, last)
        if _holds(curve, tried, first, last) and _density_stays(curve, tried, first, last):
            return first
    return None


def _beyond_the_bend(curve: AllanCurve, white: int, last: int) -> int:
    later = min(int(np.searchsorted(curve.taus, _LATER * curve.taus[white])), last - 4)
    if later <= white:
        return white
    noise, there = _fit(curve, white, last), curve.taus[later : later + 1]
    share = noise.white.value**2 / there / noise.model(there) ** 2
    return later if share.item() > 0.5 else white


def _columns(taus: Floats) -> Floats:
    return np.stack([1 / taus, np.full_like(taus, FLICKER), taus / 3], axis=1)


def _holds(curve: AllanCurve, noise: Noise, first: int, last: int) -> bool:
    """Whether the model fits over the first decade of the fitted range."""
    near = slice(first, int(np.searchsorted(curve.taus[:last], 10 * curve.taus[first], "right")))
    miss = np.abs(curve.variances[near] / noise.model(curve.taus[near]) ** 2 - 1)
    return bool(np.all(miss < ROOM + 3 * np.sqrt(2 / curve.freedom[near])))


def _density_stays(curve: AllanCurve, noise: Noise, first: int, last: int) -> bool:
    """Whether a fit that begins half a decade later gives the same density, up to chance."""
    later = int(np.searchsorted(curve.taus[:last], _LATER * curve.taus[first]))
    if last - later < 4:
        return True
    other = _fit(curve, later, last).white
    near = abs(noise.white.value / other.value - 1) < ROOM / 2 if other.value > 0 else False
    return near or other.low <= noise.white.value <= other.high


def _fit(curve: AllanCurve, first: int, last: int) -> Noise:
    rows = np.unique(np.append(np.arange(first, last, _FITTED), last - 1))
    without = _solved(curve, rows, (0, 2))
    within = _solved(curve, rows, (0, 1, 2))
    best = within if without.chi_square - within.chi_square > _SURE else without
    nothing = Limited(0.0, 0.0, 0.0)
    return Noise(curve, best.terms[0], best.terms[1], best.terms[2], nothing, 0.0, 0.0, 0.0, False)


class _Solved(NamedTuple):
    terms: tuple[Limited, ...]
    chi_square: float


def _solved(curve: AllanCurve, rows: np.ndarray, terms: tuple[int, ...]) -> _Solved:
    """Generalised least squares with the covariance of the points under the model."""
    from scipy.optimize import nnls

    taus, seen = curve.taus[rows], curve.variances[rows]
    A = _columns(taus)[:, terms]
    squares, model = np.zeros(len(terms)), seen
    root, lines = np.eye(len(rows)), _lines(curve, taus)
    for _ in range(4):
        spread = model * np.sqrt(2 / curve.freedom[rows])
        covariance = spread[:, None] * _correlation(lines, taus, model) * spread
        root = np.linalg.inv(np.linalg.cholesky(covariance))
        B = root @ A
        size = np.linalg.norm(B, axis=0)
        squares = nnls(B / size, root @ seen)[0] / size
        model = np.maximum(A @ squares, 1e-6 * seen)
    rest = root @ (seen - A @ squares)
    known = np.linalg.inv((B / size).T @ (B / size)) / np.outer(size, size)
    limited = dict(zip(terms, map(_limited, squares, np.sqrt(np.diag(known))), strict=True))
    nothing = Limited(0.0, 0.0, 0.0)
    return _Solved(tuple(limited.get(i, nothing) for i in range(3)), float(rest @ rest))


def _limited(square: float, spread: float) -> Limited:
    """The root of an estimated square, with chi-square limits; only an upper one where weak."""
    if square < spread:
        return Limited(float(np.sqrt(square)), 0.0, float(np.sqrt(square + 1.645 * spread)))
    low, high = chi_square_limits(np.array(2 * square**2 / spread**2))
    return Limited(*(float(np.sqrt(square * factor)) for factor in (1.0, low, high)))


class _Lines(NamedTuple):
    """Lines of the periodogram, and their weights in the estimates at each time."""

    f: Floats
    weights: Floats


def _lines(curve: AllanCurve, taus: Floats) -> _Lines:
    low, high = 0.1 / (3 * curve.taus[-1]), 0.5 / curve.taus[0]
    f = np.geomspace(low, high, 3000)
    x = np.pi * f * taus[:, None]
    square = np.sin(x) ** 2 / x
    return _Lines(f, 2 * square * square * np.sqrt(f))


def _correlation(lines: _Lines, taus: Floats, model: Floats) -> Floats:
    """Correlation of the estimates at different times, for the spectrum of the variances.

    Each is a weighted mean of the periodogram, whose lines are independent.
    """
    # A variance at tau is mostly due to the spectrum around 0.4 / tau.
    density = np.exp(np.interp(-np.log(lines.f), np.log(taus / 0.4), np.log(model * taus)))
    weighted = lines.weights * density
    covariance = weighted @ weighted.T
    size = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(size, size) + 1e-3 * np.eye(len(taus))) / 1.001
