"""The innovations of a run."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tuner.diagnostics.column import Column


@dataclass(frozen=True, eq=False)
class Innovations:
    """Innovations of a filter over N samples of k recordings with m measurements.

    Attributes:
        value: measured less predicted, ``(N, k, m)``.
        variance: of it, as the filter says; 0 where it does not count.
        times: of the samples, s, ``(N, k)``.
        levels: what was predicted, ``(N, k, m)``, or None.
        names: of the measurements.
        unit: of the levels.
        turns: the sizes of a full turn, where the measurements are or may be angles.
        predicted: whether the variances are the filter's, and not the innovations' own mean square.

    Raises:
        ValueError: for shapes that do not match.
    """

    value: np.ndarray
    variance: np.ndarray
    times: np.ndarray
    levels: np.ndarray | None = None
    names: tuple[str, ...] = ("",)
    unit: str = ""
    turns: tuple[float, ...] = ()
    predicted: bool = True

    def __post_init__(self) -> None:
        shape = self.value.shape
        others = {"variances": self.variance.shape}
        others |= {} if self.levels is None else {"levels": self.levels.shape}
        for what, other in others.items():
            if other != shape:
                raise ValueError(f"the innovations are {shape} and their {what} {other}; give like")
        if self.value.ndim != 3 or self.times.shape != shape[:2] or len(self.names) != shape[2]:
            raise ValueError(
                f"innovations {shape} at times {self.times.shape} of {len(self.names)} measurements"
                " do not match; give (N, k, m), (N, k) and m names"
            )

    @classmethod
    def of(
        cls,
        value: Any,
        variance: Any,
        *,
        times: Any = None,
        levels: Any = None,
        names: Sequence[str] = (),
        unit: str = "",
        turns: Sequence[float] = (),
        predicted: bool = True,
    ) -> "Innovations":
        """Innovations from arrays ``(N,)``, ``(N, m)`` or ``(N, k, m)``; without times, by sample.

        >>> Innovations.of(np.zeros((5, 2)), np.ones((5, 2))).value.shape
        (5, 1, 2)
        """
        y = _wide(value)
        when = np.arange(len(y), dtype=float) if times is None else np.asarray(times, float)
        when = np.broadcast_to(when if when.ndim == 2 else when[:, None], y.shape[:2])
        known = tuple(names) or (("",) if y.shape[2] == 1 else tuple(map(str, range(y.shape[2]))))
        above = None if levels is None else _wide(levels)
        return cls(y, _wide(variance), when, above, known, unit, tuple(turns), predicted)

    @cached_property
    def counted(self) -> np.ndarray:
        """Which numbers count."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray((self.variance > 0) & np.isfinite(self.value / self.variance))

    @cached_property
    def lost(self) -> np.ndarray:
        """Which numbers are not finite, or have no valid variance: the filter diverged."""
        known = np.isfinite(self.value) & np.isfinite(self.variance) & (self.variance >= 0)
        return np.asarray(~known)

    @cached_property
    def normalised(self) -> np.ndarray:
        """Innovations over their deviations; NaN where they do not count."""
        s = np.where(self.counted, self.variance, 1.0)
        return np.where(self.counted, self.value / np.sqrt(s), np.nan)

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The measurements of which any number counts."""
        found = (self._column(i) for i in range(self.value.shape[2]))
        return tuple(column for column in found if len(column))

    def _column(self, i: int) -> Column:
        # Recordings one after another: they come first, then time.
        counted = self.counted[:, :, i].T
        recording = np.broadcast_to(np.arange(len(counted))[:, None], counted.shape)
        levels = None if self.levels is None else self.levels[:, :, i].T[counted]
        return Column(
            self.names[i],
            self.normalised[:, :, i].T[counted],
            self.value[:, :, i].T[counted],
            self.times.T[counted],
            recording[counted],
            levels if levels is not None and np.isfinite(levels).all() else None,
        )

    def place(self, column: Column, index: int) -> str:
        """The place of a number, in words."""
        words = f"at {column.times[index]:.5g} s"
        if self.value.shape[1] > 1:
            words += f" of recording {column.recording[index] + 1}"
        return f"{words} in {column.name}" if column.name and len(self.names) > 1 else words


def _wide(array: Any) -> np.ndarray:
    whole: np.ndarray = np.asarray(array, float)
    if whole.ndim == 1:
        return whole[:, None, None]
    return whole[:, None, :] if whole.ndim == 2 else whole
