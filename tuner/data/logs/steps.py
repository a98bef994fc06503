"""Steps between the times of samples.

The steps of a long record fill as much memory as its times: they are made block by block, and only
for what nothing else settles.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

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
        close: those close to the median, where these were.

    >>> steps = Steps(np.array([0.0, 1.0, 2.0, 5.0]))
    >>> len(steps), steps.lowest, steps.highest, steps.median
    (3, 1.0, 3.0, 1.0)
    """

    seconds: Floats
    known: Floats | None = None
    close: "_Close | None" = None

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
        close = self.close
        if close is None and len(self) >= _LONG:
            close = self._found_close(_limits(self.seconds))
        median = None if close is None else close.median(len(self))
        return float(np.median(np.diff(self.seconds))) if median is None else median

    @cached_property
    def mean(self) -> float:
        """The mean."""
        return float(self.seconds[-1] - self.seconds[0]) / len(self)

    def _found_close(self, limits: tuple[float, float]) -> "_Close":
        def of_part(starts: range) -> list[tuple[int, Floats]]:
            return [_parted(block, limits) for _, block in self.blocks(starts)]

        return _Close.of(limits, [one for part in in_parts(of_part, len(self)) for one in part])

    def parted(self, limit: float) -> "Parted":
        """The rows of longer steps, and the longest of the others."""

        def of_part(starts: range) -> list[NDArray[np.intp]]:
            longer = (at for at in starts if self.extremes[at // BLOCK, 1] > limit)
            return [at + _taken_out(block, limit, others, at) for at, block in self.blocks(longer)]

        others = self.extremes[:, 1].copy()
        if self.highest <= limit:
            return Parted(np.empty(0, np.intp), others)
        found = [rows for part in in_parts(of_part, len(self)) for rows in part]
        return Parted(np.concatenate([np.empty(0, np.intp), *found]), others)


class Parted(NamedTuple):
    """Steps parted by a limit.

    Attributes:
        rows: of the longer ones.
        others: the longest other one of each block, ``(blocks,)``; -inf where there is none.
    """

    rows: NDArray[np.intp]
    others: Floats


def _taken_out(block: Floats, limit: float, others: Floats, at: int) -> NDArray[np.intp]:
    """The rows of longer steps of a block, and the longest other one."""
    rows = np.flatnonzero(block > limit)
    block[rows] = -np.inf
    others[at // BLOCK] = block.max()
    return rows


class _Close(NamedTuple):
    """Steps between two limits, between which the median is looked for.

    Attributes:
        limits: the lowest and the highest of them.
        below: number of the shorter ones.
        among: all between, ``(n,)``, in any order.
    """

    limits: tuple[float, float]
    below: int
    among: Floats

    @classmethod
    def of(cls, limits: tuple[float, float], parts: Sequence[tuple[int, Floats]]) -> "_Close":
        """Those of parts."""
        counts, among = zip(*parts, strict=True)
        return cls(limits, sum(counts), np.concatenate(among))

    def median(self, count: int) -> float | None:
        """The median of so many steps; None where it is none of these."""
        both = np.array([(count - 1) // 2, count // 2]) - self.below
        if not 0 <= both[0] <= both[1] < len(self.among):
            return None
        low, high = self.limits
        return low if low == high else float(np.partition(self.among, both)[both].mean())


def _limits(seconds: Floats) -> tuple[float, float]:
    """Two steps between which the median nearly always is, by a sample of times ``(N,)``."""
    every = _every(len(seconds))
    return _around(seconds[1::every] - seconds[:-1:every])


def _every(rows: int) -> int:
    """Every which step is one of a sample: an odd one, for steps that alternate."""
    return (rows - 1) // _SAMPLED | 1


def _around(some: Floats) -> tuple[float, float]:
    low, high = np.quantile(some, _AROUND, method="nearest")
    return float(low), float(high)


def _parted(steps: Floats, limits: tuple[float, float]) -> tuple[int, Floats]:
    """The number of steps below two limits, and those between."""
    near = steps >= limits[0]
    below = len(near) - int(np.count_nonzero(near))
    near &= steps <= limits[1]
    return below, steps.compress(near)


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
    limits = _limits_ahead(column, first, scale)

    def made(starts: range) -> list[_Seen]:
        memory, found = np.empty(BLOCK), []
        with np.errstate(invalid="ignore", over="ignore"):
            for start in starts:
                block = seconds[start : start + BLOCK]
                _write(column[start : start + BLOCK], first, scale, block)
                steps = np.subtract(block[1:], block[:-1], out=memory[: len(block) - 1])
                found.append(_seen(steps, limits))
        return found

    seen = [block for part in in_parts(made, len(column)) for block in part]
    with np.errstate(invalid="ignore", over="ignore"):
        between = seconds[BLOCK::BLOCK] - seconds[BLOCK - 1 : -1 : BLOCK]
    extremes = np.array([block.ends for block in seen])
    np.minimum(extremes[: len(between), 0], between, out=extremes[: len(between), 0])
    np.maximum(extremes[: len(between), 1], between, out=extremes[: len(between), 1])
    if limits is None:
        return Steps(seconds, extremes)
    close = [block.parted for block in (*seen, _seen(between, limits))]
    return Steps(seconds, extremes, _Close.of(limits, close))


class _Seen(NamedTuple):
    """What a block of steps tells: its ends, and its part around the median where that is asked."""

    ends: tuple[float, float]
    parted: tuple[int, Floats]


def _seen(steps: Floats, limits: tuple[float, float] | None) -> _Seen:
    return _Seen(_ends(steps), (0, steps[:0]) if limits is None else _parted(steps, limits))


def _limits_ahead(column: Raw, first: Any, scale: float) -> tuple[float, float] | None:
    """The limits of times that are yet to be made; None where no median is looked for by them.

    That of equal steps costs less than to look for it.
    """
    if len(column) <= _LONG:
        return None
    every = _every(len(column))
    later, earlier = column[1::every], column[:-1:every]
    times = np.empty((2, len(later)))
    with np.errstate(invalid="ignore", over="ignore"):
        for rows, seconds in zip((later, earlier), times, strict=True):
            _write(rows, first, scale, seconds)
        some = times[0] - times[1]
    limits = _around(some) if np.isfinite(some).all() else (0.0, 0.0)
    return limits if limits[0] < limits[1] else None


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
