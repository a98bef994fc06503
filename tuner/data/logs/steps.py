"""Steps between the times of samples.

The steps of a long record fill as much memory as its times: they are made block by block, and only
for what nothing else settles.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.passes import BLOCK, in_parts
from tuner.data.logs.table import Floats, Raw

_LONG = 100_000
_SAMPLED = 40_000
_AROUND = (0.49, 0.51)  # four standard deviations of the median of so many


@dataclass(frozen=True, eq=False)
class Steps:
    """The steps between times.

    Attributes:
        seconds: the times, ``(N,)`` with N of at least 2.
        known: ``extremes``, where they were found as the times were made.

    >>> steps = Steps(np.array([0.0, 1.0, 2.0, 5.0]))
    >>> len(steps), steps.lowest, steps.highest, steps.median
    (3, 1.0, 3.0, 1.0)
    """

    seconds: Floats
    known: Floats | None = None

    def __len__(self) -> int:
        return len(self.seconds) - 1

    def blocks(self, starts: Iterable[int]) -> Iterator[tuple[int, Floats]]:
        """The steps of the blocks that begin at some rows, each with that row.

        A block is overwritten by the next one.
        """
        memory = np.empty(min(BLOCK, len(self)))
        for start in starts:
            times = self.seconds[start : start + BLOCK + 1]
            yield start, np.subtract(times[1:], times[:-1], out=memory[: len(times) - 1])

    @cached_property
    def extremes(self) -> Floats:
        """The shortest and the longest step of each block, ``(blocks, 2)``."""
        if self.known is not None:
            return self.known
        return np.concatenate(in_parts(self._extremes_of, len(self)))

    def _extremes_of(self, starts: range) -> Floats:
        with np.errstate(invalid="ignore", over="ignore"):  # others tell what is missing
            return np.array([_ends(block) for _, block in self.blocks(starts)])

    @property
    def lowest(self) -> float:
        """The shortest one; NaN where a time is missing."""
        return float(self.extremes[:, 0].min())

    @property
    def highest(self) -> float:
        """The longest one; NaN where a time is missing."""
        return float(self.extremes[:, 1].max())

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
        """The median by those between two limits and the number below; None where it is no such."""
        every = len(self) // _SAMPLED | 1  # odd, for steps that alternate
        some = self.seconds[1::every] - self.seconds[:-1:every]
        low, high = np.quantile(some, _AROUND, method="nearest")

        def of_part(starts: range) -> tuple[int, Floats]:
            below, close = 0, [np.empty(0)]
            for _, block in self.blocks(starts):
                near = block >= low
                below += len(near) - int(np.count_nonzero(near))
                near &= block <= high
                close.append(block.compress(near))
            return below, np.concatenate(close)

        counts, parts = zip(*in_parts(of_part, len(self)), strict=True)
        among = np.concatenate(parts)
        both = np.array([(len(self) - 1) // 2, len(self) // 2]) - sum(counts)
        if not 0 <= both[0] <= both[1] < len(among):
            return None
        return float(low if low == high else np.partition(among, both)[both].mean())

    def above(self, limit: float) -> NDArray[np.intp]:
        """The rows of longer steps."""
        if self.highest <= limit:
            return np.empty(0, np.intp)

        def of_part(starts: range) -> list[NDArray[np.intp]]:
            blocks = self.blocks(at for at in starts if self.extremes[at // BLOCK, 1] > limit)
            return [at + np.flatnonzero(block > limit) for at, block in blocks]

        found = [rows for part in in_parts(of_part, len(self)) for rows in part]
        return np.concatenate([np.empty(0, np.intp), *found])


def since_first(column: Raw, scale: float) -> Steps:
    """The steps of a column's times since the first of them, which are made in the same pass.

    Args:
        column: numbers, ``(N,)``; integers are subtracted as integers.
        scale: seconds per unit of the column.

    >>> since_first(np.array([5, 15, 20]), 0.1).seconds.tolist()
    [0.0, 1.0, 1.5]
    """
    whole = column.dtype.kind in "iub"
    first = column[:1].astype(np.int64 if whole else np.float64)[0]
    plain = scale == 1.0 and first == 0 and not whole
    if plain and column.dtype == np.float64:
        return Steps(np.ascontiguousarray(column))
    seconds = np.empty(len(column))

    def made(starts: range) -> Floats:
        memory, found = np.empty(BLOCK), []
        with np.errstate(invalid="ignore", over="ignore"):
            for start in starts:
                block = seconds[start : start + BLOCK]
                _write(column[start : start + BLOCK], first, scale, block)
                steps = np.subtract(block[1:], block[:-1], out=memory[: len(block) - 1])
                found.append(_ends(steps))
        return np.array(found)

    extremes = np.concatenate(in_parts(made, len(column)))
    with np.errstate(invalid="ignore", over="ignore"):
        between = seconds[BLOCK::BLOCK] - seconds[BLOCK - 1 : -1 : BLOCK]
    np.minimum(extremes[: len(between), 0], between, out=extremes[: len(between), 0])
    np.maximum(extremes[: len(between), 1], between, out=extremes[: len(between), 1])
    return Steps(seconds, extremes)


def _ends(steps: Floats) -> tuple[float, float]:
    """The lowest and the highest of steps, of which there may be none."""
    return float(steps.min(initial=np.inf)), float(steps.max(initial=-np.inf))


def _write(block: Raw, first: Any, scale: float, seconds: Floats) -> None:
    if first.dtype == np.float64 and first == 0 and scale == 1.0:
        seconds[:] = block  # zeros keep their signs
        return
    np.subtract(block, first, out=seconds, dtype=first.dtype, casting="unsafe")
    if scale != 1.0:
        seconds *= scale


def rises(column: Raw) -> bool:
    """Whether numbers rise from row to row; not where one is missing.

    >>> rises(np.array([1, 2, 4])), rises(np.array([1.0, np.nan, 2.0]))
    (True, False)
    """
    starts = range(0, len(column) - 1, BLOCK)
    blocks = (column[start : start + BLOCK + 1] for start in starts)
    return all(bool((block[1:] > block[:-1]).all()) for block in blocks)
