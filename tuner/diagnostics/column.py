"""The numbers of one measurement among the innovations of a run."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

INSIDE = 4.0
"""Normalised innovations beyond it are outliers: 1 in 15,800 of normal ones."""
CLIP, CLIPPED = 3.0, 0.97334
"""The usual deviation is that of the numbers within so many, and their mean square where normal."""
AFTERMATH, SMALL = 10, 2.0
"""Numbers after an outlier that it may have disturbed, and what is small again."""
Varying: TypeAlias = Literal["", "time", "level"]
"""The variable that the noise changes with."""
PARTS = 10
FEW = 20


def usual(numbers: np.ndarray) -> float:
    """Deviation of numbers without outliers, from those within three deviations, if normal.

    Begins with the median and goes on with the numbers inside until they stay the same.

    >>> round(usual(np.append(np.random.default_rng(1).standard_normal(999), 99.0)), 2)
    0.98
    """
    size = np.abs(numbers)
    scale = float(np.median(size)) / 0.6745
    inside = size <= CLIP * scale
    for _ in range(50):
        if not scale > 0:
            break
        before, scale = inside, float(np.sqrt(np.mean(size[inside] ** 2) / CLIPPED))
        inside = size <= CLIP * scale
        if (inside == before).all():
            break
    return scale if scale > 0 else float(np.sqrt(np.mean(size**2)))


@dataclass(frozen=True, eq=False)
class Column:
    """The numbers of one measurement that count, recording after recording, each in time.

    Attributes:
        name: of the measurement; "" where there is one alone.
        e: innovations over their deviations, ``(n,)``; independent and standard normal for a right
            filter, as are all below in the same order.
        y: innovations.
        times: s.
        recording: the recording of each.
        levels: what was predicted, in the unit of the measurement; None where nobody knows.
    """

    name: str
    e: np.ndarray
    y: np.ndarray
    times: np.ndarray
    recording: np.ndarray
    levels: np.ndarray | None

    def __len__(self) -> int:
        return len(self.e)

    @cached_property
    def scale(self) -> float:
        """Deviation of ``e`` without its outliers; see :func:`usual`."""
        return usual(self.e)

    def correlation(self, lag: int) -> float:
        """Correlation of numbers that are ``lag`` apart in one recording, over their square."""
        pairs = self.e[lag:] * self.e[:-lag]
        same = self.recording[lag:] == self.recording[:-lag]
        power = float(self.e @ self.e)
        return float((pairs * same).sum()) / power if power > 0 else 0.0

    def pairs(self, lag: int) -> int:
        """Number of such pairs."""
        return int((self.recording[lag:] == self.recording[:-lag]).sum())

    @cached_property
    def spread(self) -> float:
        """Factor by which correlation increases the variance of a mean of squares; 1 if white.

        1 + 2 sum r_k^2 (Bartlett, for normal numbers), up to two lags in a row that say nothing.
        """
        bound, total, quiet = 4 / max(len(self), 1), 1.0, 0
        for lag in range(1, len(self) // 5 + 1):
            square = self.correlation(lag) ** 2
            quiet = quiet + 1 if square < bound else 0
            if quiet == 2:
                break
            total += 2 * square if square >= bound else 0.0
        return total

    @cached_property
    def calm(self) -> np.ndarray:
        """Which numbers are not outliers and follow none; all where less than half would remain.

        What follows ends with two numbers in a row within two deviations, and not before an outlier
        that halves each time would be as small as one.
        """
        size = np.abs(self.e)
        small = size <= SMALL * self.scale
        over = small & np.concatenate([[False], small[:-1]])
        near = size > INSIDE * self.scale
        loud = np.where(near, size, 0.0)
        for lag in range(1, AFTERMATH + 1):
            loud = np.concatenate([[0.0], loud[:-1]])
            loud[over & (loud < 2.0**lag * self.scale)] = 0.0
            near = near | (loud > 0)
        return ~near if 2 * near.sum() < len(near) else np.ones_like(near)

    def only(self, rows: np.ndarray) -> "Column":
        """The column with some of its numbers."""
        levels = None if self.levels is None else self.levels[rows]
        parts = (self.e[rows], self.y[rows], self.times[rows], self.recording[rows])
        return Column(self.name, *parts, levels)

    def parts(self, varying: Varying) -> list[np.ndarray]:
        """The rows in ten parts of similar time or level; in one part where nothing varies."""
        rows = np.arange(len(self))
        if varying == "level" and self.levels is not None:
            rows = np.argsort(self.levels, kind="stable")
        return np.array_split(rows, max(min(PARTS, len(rows) // FEW), 1) if varying else 1)

    def evened(self, varying: Varying) -> "Column":
        """The column scaled to the same noise in all parts."""
        if not varying:
            return self
        e = self.e.copy()
        for rows in self.parts(varying):
            scale = usual(e[rows])
            e[rows] /= scale / self.scale if scale > 0 and self.scale > 0 else 1.0
        return replace(self, e=e)
