"""Steps between the times of samples that are no gaps."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.passes import BLOCK, in_parts
from tuner.data.logs.steps import Steps
from tuner.data.logs.table import Floats

_SUMMED = 1e-9  # far above the rounding error of a sum of steps


@dataclass(frozen=True, eq=False)
class Usual:
    """Steps that are no gaps.

    Attributes:
        steps: all steps.
        gaps: the rows of those that are.
        longest: the longest other one of each block, ``(blocks,)``; -inf where all are gaps.
    """

    steps: Steps
    gaps: NDArray[np.intp]
    longest: Floats

    def __len__(self) -> int:
        return len(self.steps) - len(self.gaps)

    def blocks(self, starts: Iterable[int], instead: float) -> Iterator[Floats]:
        """The steps of blocks, with a number in place of gaps; each is overwritten by the next."""
        for start, block in self.steps.blocks(starts):
            first, last = np.searchsorted(self.gaps, (start, start + len(block)))
            block[self.gaps[first:last] - start] = instead
            yield block

    @property
    def lowest(self) -> float:
        """The shortest one, s."""
        return self.steps.lowest

    @property
    def highest(self) -> float:
        """The longest one, s."""
        return float(self.longest.max())

    @cached_property
    def mean(self) -> float:
        """The mean, s."""
        sums = in_parts(lambda starts: [b.sum() for b in self.blocks(starts, 0.0)], len(self.steps))
        return math.fsum(one for part in sums for one in part) / len(self)

    def mean_is_near(self, step: float, most: float) -> bool:
        """Whether the mean differs by at most so much from a step, s.

        What it is but for its rounding follows from the ends and the gaps, and nearly always tells.
        """
        seconds = self.steps.seconds
        whole = float(seconds[-1] - seconds[0])
        between = float((seconds[self.gaps + 1] - seconds[self.gaps]).sum())
        distance, error = abs((whole - between) / len(self) - step), _SUMMED * whole / len(self)
        if abs(distance - most) > error:
            return distance < most
        return abs(self.mean - step) <= most

    def stray(self, far: float) -> float:
        """The share of those that are further from the median than far."""
        usual = self.steps.median
        ends = np.stack([self.steps.extremes[:, 0], self.longest], axis=1)
        away = np.abs(ends - usual).max(axis=1) > far

        def of_part(starts: range) -> int:
            blocks = self.blocks((start for start in starts if away[start // BLOCK]), usual)
            return sum(_count_away(block, usual, far) for block in blocks)

        return sum(in_parts(of_part, len(self.steps))) / len(self) if away.any() else 0.0


def _count_away(steps: Floats, usual: float, far: float) -> int:
    away = np.abs(np.subtract(steps, usual, out=steps), out=steps)
    return int(np.count_nonzero(away > far))
