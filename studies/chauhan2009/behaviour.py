"""Behaviour after a step: how large errors of the pitch are, and for how long."""

from typing import NamedTuple

import numpy as np

from studies.chauhan2009.data import BEFORE, Records, times
from studies.chauhan2009.paper import EVERY
from studies.chauhan2009.settings import Settings

TOLERATED = 5.0
"""Largest error of a settled estimate, %."""


class Behaviour(NamedTuple):
    """Behaviour on single records, ``(k,)`` each, in per cent of the step.

    Attributes:
        peak: largest error within 60 s after the step, %.
        settled: when the error last exceeds 5 % after the step, s.
        ripple: standard deviation of the error over the last 60 s, %.
        offset: its mean there, %.
    """

    peak: np.ndarray
    settled: np.ndarray
    ripple: np.ndarray
    offset: np.ndarray


def behaviour(pitch: np.ndarray, found: Records, settings: Settings, step: float) -> Behaviour:
    """Peak, settling, ripple and offset of estimates after a step.

    Args:
        pitch: estimated, rad, ``(N, k)``.
        found: the records; errors count where there is a measurement.
        settings: for the time line.
        step: the final pitch, deg.
    """
    at = slice(EVERY - 1, None, EVERY)
    t = times(settings)[at]
    error = 100 * np.degrees(pitch - np.asarray(found.truth))[at] / step
    after = (t > BEFORE) & (t <= BEFORE + 60)
    late = t > settings.seconds - 60
    since = np.where((np.abs(error) > TOLERATED) & (t > BEFORE)[:, None], t[:, None] - BEFORE, 0.0)
    return Behaviour(
        peak=np.abs(error[after]).max(axis=0),
        settled=since.max(axis=0),
        ripple=error[late].std(axis=0),
        offset=error[late].mean(axis=0),
    )
