"""Steps between the times of samples, in blocks that stay in the processor's cache.

The steps of a long record fill as much memory as its times, and each operation on all of them takes
as long as reading them from there.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.table import Floats, Raw

_BLOCK = 1 << 15
_LONG = 100_000
_SAMPLED = 10_000


@dataclass(frozen=True)
class Usual:
    """Steps that are no gaps.

    Attributes:
        lowest, highest, mean: of them, s.
        stray: the share of those that are far from the median.
    """

    lowest: float
    highest: float
    mean: float
    stray: float


@dataclass(frozen=True, eq=False)
class Steps:
    """The steps between times.

    Attributes:
        seconds: the times, ``(N,)`` with N of at least 2.

    >>> steps = Steps(np.array([0.0, 1.0, 2.0, 5.0]))
    >>> len(steps), steps.lowest, steps.highest, steps.median
    (3, 1.0, 3.0, 1.0)
    """

    seconds: Floats

    def __len__(self) -> int:
        return len(self.seconds) - 1

    def blocks(self) -> Iterator[tuple[int, Floats]]:
        """The steps in their order, and the row of the first of each block.

        A block is overwritten by the next one.
        """
        memory = np.empty(min(_BLOCK, len(self)))
        for start in range(0, len(self), _BLOCK):
            times = self.seconds[start : start + _BLOCK + 1]
            yield start, np.subtract(times[1:], times[:-1], out=memory[: len(times) - 1])

    @property
    def lowest(self) -> float:
        """The shortest one; NaN where a time is missing."""
        return self._extremes[0]

    @property
    def highest(self) -> float:
        """The longest one; NaN where a time is missing."""
        return self._extremes[1]

    @cached_property
    def _extremes(self) -> tuple[float, float]:
        both = np.array([(block.min(), block.max()) for _, block in self.blocks()])
        return float(both[:, 0].min()), float(both[:, 1].max())

    @cached_property
    def median(self) -> float:
        """The median; of a long record it is looked for among the steps that are close to it."""
        close = self._close() if len(self) >= _LONG else None
        return float(np.median(np.diff(self.seconds))) if close is None else close

    @cached_property
    def mean(self) -> float:
        """The mean."""
        return float(self.seconds[-1] - self.seconds[0]) / len(self)

    def _close(self) -> float | None:
        rows = np.arange(0, len(self), len(self) // _SAMPLED)
        some = self.seconds[rows + 1] - self.seconds[rows]
        low, high = np.quantile(some, (0.48, 0.52), method="nearest")
        below, close = 0, [np.empty(0)]
        for _, block in self.blocks():
            near = block >= low
            below += len(near) - int(np.count_nonzero(near))
            near &= block <= high
            close.append(block[near])
        among = np.concatenate(close)
        both = np.array([(len(self) - 1) // 2, len(self) // 2]) - below
        if not 0 <= both[0] <= both[1] < len(among):
            return None
        return float(low if low == high else np.partition(among, both)[both].mean())

    def above(self, limit: float) -> NDArray[np.intp]:
        """The rows of longer steps."""
        if self.highest <= limit:
            return np.empty(0, np.intp)
        rows = [start + np.flatnonzero(block > limit) for start, block in self.blocks()]
        return np.concatenate(rows)

    def usual(self, limit: float, far: float) -> Usual:
        """Steps up to a limit, and the share of them that are further from the median than far."""
        extremes, sums, stray, count = [], [], 0, 0
        for _, block in self.blocks():
            own = block if self.highest <= limit else block[block <= limit]
            if len(own):
                extremes.append((own.min(), own.max()))
                sums.append(own.sum())
                count += len(own)
                own -= self.median
                stray += int(np.count_nonzero(np.abs(own, out=own) > far))
        low, high = np.array(extremes).T
        mean = math.fsum(sums) / count
        return Usual(float(low.min()), float(high.max()), mean, stray / count)


def rises(column: Raw) -> bool:
    """Whether numbers rise from row to row; not where one is missing.

    >>> rises(np.array([1, 2, 4])), rises(np.array([1.0, np.nan, 2.0]))
    (True, False)
    """
    starts = range(0, len(column) - 1, _BLOCK)
    blocks = (column[start : start + _BLOCK + 1] for start in starts)
    return all(bool((block[1:] > block[:-1]).all()) for block in blocks)


def since_first(column: Raw, scale: float) -> Floats:
    """Numbers less the first of them, scaled: integers are subtracted as integers."""
    if scale == 1.0 and column[0] == 0 and column.dtype == np.float64:
        return np.ascontiguousarray(column)
    since = np.empty(len(column))
    for start in range(0, len(column), _BLOCK):
        rows = slice(start, start + _BLOCK)
        np.multiply(column[rows] - column[0], scale, out=since[rows])
    return since
