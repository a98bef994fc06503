"""The axis of a picture: where a number lies, and which numbers stand beside it."""

import math
from dataclasses import dataclass

import numpy as np

from tuner.report.words import MINUS, TIMES, raised

FULL = 10_000.0
"""Length of an axis in the units of a drawing."""
ROOM = 0.04
"""Share of the range that is left free at both ends of a linear axis of values."""
DECADES = 2.0
"""From so many decades on the numbers at a logarithmic axis are powers of ten."""


@dataclass(frozen=True)
class Tick:
    """A number at an axis.

    Attributes:
        at: where, from 0 to 1.
        text: what stands there.
    """

    at: float
    text: str


@dataclass(frozen=True)
class Axis:
    """An axis from one number to another.

    Attributes:
        low, high: its ends.
        log: whether it is logarithmic.
    """

    low: float
    high: float
    log: bool = False

    @classmethod
    def over(cls, values: np.ndarray, *, log: bool = False, room: float = 0.0) -> "Axis":
        """The axis over some numbers; those that it cannot have do not count.

        >>> Axis.over(np.array([1.0, 3.0, np.nan]))
        Axis(low=1.0, high=3.0, log=False)
        """
        there = values[np.isfinite(values) & ((values > 0) | (not log))]
        if not len(there):
            return cls(1.0, 10.0, log) if log else cls(0.0, 1.0)
        low, high = float(there.min()), float(there.max())
        if log:
            wider = max((high / low) ** room, 1.0) if high > low else 3.0
            return cls(low / wider, high * wider, log)
        if high == low:
            half = abs(low) / 10 or 0.5
            return cls(low - half, high + half)
        return cls(low - room * (high - low), high + room * (high - low))

    def at(self, values: np.ndarray) -> np.ndarray:
        """Where numbers lie, from 0 to :data:`FULL`; NaN for those that it cannot have."""
        values = np.asarray(values, float)
        if not self.log:
            return FULL * (values - self.low) / (self.high - self.low)
        with np.errstate(invalid="ignore", divide="ignore"):
            logs = np.where(values > 0, np.log10(values), np.nan)
        low, high = math.log10(self.low), math.log10(self.high)
        found: np.ndarray = FULL * (logs - low) / (high - low)
        return found

    def ticks(self, most: int = 6) -> list[Tick]:
        """The numbers beside it.

        >>> [tick.text for tick in Axis(0.0, 10.0).ticks()]
        ['0', '2', '4', '6', '8', '10']
        >>> [tick.text for tick in Axis(0.1, 1000.0, log=True).ticks()]
        ['10⁻¹', '10⁰', '10¹', '10²', '10³']
        """
        numbers = self._powers(most) if self.log else _round_steps(self.low, self.high, most)
        texts = _powers_text(numbers) if self.log else _linear_text(numbers)
        places = self.at(np.array(numbers)) / FULL
        return [Tick(float(p), t) for p, t in zip(places, texts, strict=True)]

    def _powers(self, most: int) -> list[float]:
        low, high = math.log10(self.low), math.log10(self.high)
        if high - low < DECADES:
            digits = (1, 2, 5) if high - low > 0.6 else (1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9)
            found = [
                d * 10.0**p for p in range(math.floor(low), math.ceil(high) + 1) for d in digits
            ]
            inside = [
                x for x in found if self.low <= x * (1 + 1e-9) and x <= self.high * (1 + 1e-9)
            ]
            return inside if len(inside) > 3 else _round_steps(self.low, self.high, most)
        step = max(1, math.ceil((high - low) / most))
        first = math.ceil(low / step - 1e-9) * step
        return [10.0**p for p in range(first, math.floor(high + 1e-9) + 1, step)]


def _round_steps(low: float, high: float, most: int) -> list[float]:
    """Multiples of 1, 2 or 5 between two numbers."""
    rough = (high - low) / max(most, 1)
    power = 10.0 ** math.floor(math.log10(rough))
    step = next((m * power for m in (1, 2, 5) if m * power >= rough * (1 - 1e-9)), 10 * power)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [k * step for k in range(first, last + 1)]


def _linear_text(numbers: list[float]) -> list[str]:
    """All with as many digits as the step between them needs, or all with the same power."""
    if len(numbers) < 2:
        return [f"{x:.4g}".replace("-", MINUS) for x in numbers]
    largest, step = max(map(abs, numbers)), numbers[1] - numbers[0]
    power = math.floor(math.log10(largest))
    scale = 10.0**power if power > 5 or power < -3 else 1.0
    digits = max(0, -math.floor(math.log10(step / scale) + 1e-9))
    tail = f"{TIMES}10{raised(str(power))}" if scale != 1.0 else ""
    texts = [f"{x / scale:.{digits}f}" for x in numbers]
    return ["0" if float(t) == 0 else f"{t.replace('-', MINUS)}{tail}" for t in texts]


def _powers_text(numbers: list[float]) -> list[str]:
    logs = [math.log10(x) for x in numbers]
    if len(logs) > 1 and all(abs(x - round(x)) < 1e-9 for x in logs):
        return [f"10{raised(str(round(x)))}" for x in logs]
    if numbers and (max(numbers) >= 1e5 or min(numbers) < 1e-3):
        parts = [f"{x:.2e}".partition("e") for x in numbers]
        return [f"{float(m):g}{TIMES}10{raised(str(int(p)))}" for m, _, p in parts]
    return [f"{x:g}" for x in numbers]
