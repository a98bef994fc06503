"""The digits that times were written with, and which differences of steps they explain."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tuner.data.logs.passes import BLOCK, in_parts
from tuner.data.logs.table import Floats, Raw

_DIGITS = 9
_SAMPLED = 1000
_MARGIN = 1.001


@dataclass(frozen=True, eq=False)
class Resolution:
    """The step of the last digit in use of a column of times.

    Attributes:
        most: the step by some of its times, s; that by all is no longer.
        find: gives the step by all of them, s, for which each is looked at.
    """

    most: float
    find: Callable[[], float]

    @classmethod
    def of_step(cls, step: float) -> "Resolution":
        """A known step, s."""
        return cls(step, lambda: step)

    @classmethod
    def of_column(cls, column: Raw, scale: float, coarse: float, largest: float) -> "Resolution":
        """That of numbers.

        Args:
            column: the numbers.
            scale: seconds per unit of them.
            coarse: the rounding error of single precision.
            largest: the largest of their absolute values.
        """
        if column.dtype.kind in "iub":
            return cls.of_step(scale)
        rounding = 4.0 * float(np.spacing(largest))
        some = np.asarray(column[:: max(1, len(column) // _SAMPLED)], np.float64)
        decimals = _fewest(some, rounding, 0)

        def of_all() -> float:
            return scale * max(_step(_fewest(column, rounding, decimals), rounding), coarse)

        return cls(scale * max(_step(decimals, rounding), coarse), of_all)

    @cached_property
    def step(self) -> float:
        """The step by all times, s."""
        return self.find()

    def explains(self, difference: float, rounding: float) -> bool:
        """Whether steps can differ by so much for their digits alone, and for a rounding error."""
        if difference > _MARGIN * (self.most + rounding):
            return False
        return difference <= _MARGIN * (self.step + rounding)


def _step(decimals: int, rounding: float) -> float:
    """The step of the last of some decimals, or that of rounding if larger."""
    return max(10.0**-decimals, rounding) if decimals <= _DIGITS else rounding


def _fewest(column: Raw, rounding: float, least: int) -> int:
    """The fewest decimals with which all numbers are written; one more than nine where none do."""
    tried = range(least, _DIGITS + 1)
    return next((d for d in tried if _written_with(column, d, rounding)), _DIGITS + 1)


def _written_with(column: Raw, decimals: int, rounding: float) -> bool:
    def part(starts: range) -> bool:
        memory = np.empty(min(BLOCK, len(column)))
        blocks = (np.asarray(column[at : at + BLOCK], np.float64) for at in starts)
        return all(_furthest(block, decimals, memory) <= rounding for block in blocks)

    return all(in_parts(part, len(column)))


def _furthest(block: Floats, decimals: int, memory: Floats) -> float:
    """The largest distance of numbers from the nearest ones with so many decimals."""
    away = np.round(block, decimals, out=memory[: len(block)])
    np.subtract(block, away, out=away)
    return float(max(away.max(), -away.min()))
