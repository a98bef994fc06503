"""Stretches of a record whose measurements contradict the rest: long, smooth errors.

What is wrong for seconds and drifts looks like motion to every likelihood, so that neither a gate
nor heavy tails tell it from a large process noise. Differences within a window do not depend on
the state, and those of a wrong stretch are far beyond what the better half of the record has.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tuner.identifiability.least_squares import Estimate, distances, estimate_of_most
from tuner.identifiability.linear_form import NoiseModel, linear_problem
from tuner.identifiability.windows import batch, differences, of_windows, scales
from tuner.problem.problem import Problem

_ROWS = 24
"""Measurements of a window: a second at 24 Hz; more where the model has many states."""


class Refusals(NamedTuple):
    """Refused measurements of one recording, ``(N, m)`` of bool each.

    Attributes:
        seen: which measurements there are.
        wrong: which of them lie in stretches that contradict the rest.
    """

    seen: np.ndarray
    wrong: np.ndarray


def wrong_stretches(problem: Problem, gate: float) -> tuple[Refusals, ...]:
    """The measurements in stretches that contradict the rest, for each recording.

    The noise is estimated by the better half of all windows. A window is refused where its
    differences are more than ``gate`` times as far out as those of the median one, and so are all
    measurements in it; windows overlap by a half. What lies between two refused stretches and is
    shorter than each of them is refused as well: it is smooth by chance, as a port's error is at
    the top of a flight.

    Args:
        problem: of a linear model, as for :func:`tuner.determined`.
        gate: how many times as far out; the root of the mean square of a normal window's
            differences is within twice the median one's.

    Raises:
        NoModelError: for a filter that is not that of a linear model, and too few measurements.
    """
    linear = linear_problem(problem)
    n, m = linear.recordings[0].F.shape[-1], len(linear.recordings[0].H)
    rows = -(-max(_ROWS, m * (2 * n + 1)) // m) * m
    noise = estimate_of_most(differences(linear.recordings, rows), linear.entries)
    size = scales(linear.recordings)
    return tuple(
        _as_long(_wrong(model, noise, rows, size, gate), linear.samples)
        for model in linear.recordings
    )


def _as_long(found: Refusals, samples: int) -> Refusals:
    """The same of as many samples as the longest recording has."""
    rest = np.zeros((samples - len(found.seen), found.seen.shape[1]), bool)
    return Refusals(*(np.concatenate([each, rest]) for each in found))


def _wrong(
    model: NoiseModel, noise: Estimate, rows: int, size: np.ndarray, gate: float
) -> Refusals:
    """Which measurements of a recording are refused."""
    seen = np.argwhere(np.isfinite(model.z))
    far = np.zeros(len(seen), bool)
    for first, out in _windows(model, seen, noise, rows, size):
        for start in first[out > gate**2]:
            far[start : start + rows] = True
    wrong = np.zeros(model.z.shape, bool)
    wrong[tuple(seen[bridged(far)].T)] = True
    return Refusals(np.isfinite(model.z), wrong)


def _windows(
    model: NoiseModel, seen: np.ndarray, noise: Estimate, rows: int, size: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """First measurement of each window, and its distance in units of the median one."""
    from tuner.distributions import chi_square_at

    last = len(seen) - rows
    if last < 0:
        return
    starts = np.unique(np.append(np.arange(0, last, rows // 2), last))
    most = batch(model.Q.shape[1], model.F.shape[-1], rows)
    for k in range(0, len(starts), most):
        first = starts[k : k + most]
        found = of_windows([(model, seen[i : i + rows]) for i in first], rows, size)
        if found is None:
            continue
        taken, kept = found
        usual = float(chi_square_at(0.5, taken.r.shape[1]))
        judged = taken.windows(np.flatnonzero(kept))
        yield first[kept], distances(judged, noise.values) / usual


def bridged(far: np.ndarray) -> np.ndarray:
    """The flags, with gaps between two runs that are shorter than each filled.

    >>> "".join("01"[int(i)] for i in bridged(np.array([int(c) for c in "1110111000110"], bool)))
    '1111111000110'
    """
    filled = far.copy()
    runs = np.flatnonzero(np.diff(far.astype(int), prepend=0, append=0)).reshape(-1, 2)
    for (start, end), (after, until) in pairwise(runs):
        if after - end < min(end - start, until - after):
            filled[end:after] = True
    return filled
