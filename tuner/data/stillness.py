"""Tests for rest: whether a record is at rest, and where."""

from dataclasses import dataclass

import numpy as np

from tuner.data.findings import resolution
from tuner.data.logs.error import LogError
from tuner.data.signal import Floats

MOVED = 16.0
"""Means over a tenth of a second whose variance exceeds their noise by this factor are motion."""
_MEAN_S, _WINDOW_S = 0.1, 1.0
_LEAST = 32  # samples in a window: fewer do not show the noise
_QUIET, _OF_MEDIAN = 0.2, 0.64  # ratio of this quantile of a window's noise variance to the mean
_PLATEAU = 1.3
_THIRD = 20.0  # variance of third differences of white noise of variance 1
_SHORT_S = 2.0  # a shorter rest is not enough to tune on


@dataclass(frozen=True)
class Motion:
    """The motion in a record.

    Attributes:
        ratio: variance of the slow part over that of the noise, in the whole record.
        rest: longest part without motion, from and to in s since the record's first sample; None
            where there is none of 2 s.
    """

    ratio: float
    rest: tuple[float, float] | None


def find_motion(record: Floats, rate_hz: float) -> Motion | None:
    """Distinguish motion from a sensor's own noise; None where it is at rest.

    Motion changes the means over a tenth of a second within three windows of a second (of 32
    samples, if these take longer) far more than the noise that third differences show. A bias that
    drifts does so over minutes and hours, which no such window sees. A sensor's own filter makes
    the fast noise smaller than it is; so the noise is taken from means over so many samples that
    more do not raise it, up to a tenth of a second.

    Args:
        record: even samples, none missing, ``(N,)``.
        rate_hz: sample rate.

    >>> draw, t = np.random.default_rng(0), np.arange(3000) / 50
    >>> noise = draw.standard_normal(3000)
    >>> find_motion(noise, 50.0) is None
    True
    >>> find_motion(noise + np.where(t > 40, 20 * np.sin(t), 0.0), 50.0).rest
    (0.0, 39.0)
    """
    length = max(round(_WINDOW_S * rate_hz), _LEAST)
    count = len(record) // length
    if count < 3:
        return None
    windows = record[: count * length].reshape(count, length)
    step = resolution(record) or 0.0
    noise = _density(windows, rate_hz, step**2 / 12)
    m = max(1, round(_MEAN_S * rate_hz))
    means = _means(windows, m)
    around = _around(means)
    moves = around > MOVED * (noise / m + step**2 / 12)
    if not moves.any():
        return None
    rest = _longest(~moves, length / rate_hz, len(record) / rate_hz)
    return Motion(max(float(record.var() / noise) - 1.0, 0.0), rest)


def check_at_rest(name: str, record: Floats, rate_hz: float, start_s: float = 0.0) -> None:
    """Refuse a record that moves.

    Args:
        name: the record's name.
        record: even samples, none missing, ``(N,)``.
        rate_hz: sample rate.
        start_s: when its first sample was taken, as --from counts.

    Raises:
        LogError: with the place where it rests.
    """
    found = find_motion(record, rate_hz)
    if found is None:
        return
    sentence = f"{name} is not at rest (slow parts are {found.ratio:.3g} times the noise)"
    if found.rest is None:
        raise LogError(f"{sentence}; record at rest, or use a fit that models the motion")
    begin, end = (start_s + at for at in found.rest)
    raise LogError(
        f"{sentence}; it rests from {begin:.9g} s to {end:.9g} s: --from {begin:.9g} --to {end:.9g}"
    )


def _density(windows: Floats, rate_hz: float, least: float) -> float:
    """Variance per sample of the white noise alone, from the quietest windows."""
    found = []
    m, most = 1, max(1, round(_MEAN_S * rate_hz))
    while m <= most and windows.shape[1] // m >= 8:
        thirds = np.diff(_means(windows, m), 3, axis=1)
        quiet = np.quantile((thirds**2).mean(axis=1) / _THIRD, _QUIET) / _OF_MEDIAN
        found.append(max(m * float(quiet), least))
        if len(found) > 1 and found[-1] < _PLATEAU * found[-2]:
            return found[-2]
        m *= 2
    return max(found)


def _means(windows: Floats, m: int) -> Floats:
    """Means over so many samples within each window, ``(windows, means)``."""
    count = windows.shape[1] // m
    whole = windows[:, : count * m].reshape(len(windows), count, m)
    return np.asarray(whole.mean(axis=2))


def _around(means: Floats) -> Floats:
    """The variance of the means in each window and its neighbours, ``(windows,)``."""
    three = np.stack([means[:-2], means[1:-1], means[2:]], axis=1).reshape(len(means) - 2, -1)
    inner = three.var(axis=1, ddof=1)
    return np.asarray(np.pad(inner, 1, mode="edge"))


def _longest(still: np.ndarray, seconds: float, whole: float) -> tuple[float, float] | None:
    """The longest run of still windows, without those at its ends that overlap others."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    begins, ends = edges[::2], edges[1::2]
    if not len(begins):
        return None
    at = int(np.argmax(ends - begins))
    begin = seconds * begins[at]
    end = whole if ends[at] == len(still) else seconds * ends[at]
    if end - begin < max(_SHORT_S, 3 * seconds):
        return None
    first = np.ceil(100 * begin - 1e-6) / 100
    return abs(float(first)), float(np.floor(100 * end + 1e-6) / 100)
