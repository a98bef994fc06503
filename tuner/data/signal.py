"""One channel of a recording."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.clock import Clock, judged

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Signal:
    """The samples of one channel.

    Attributes:
        values: in ``unit``, ``(N,)`` or ``(N, k)``, float64; NaN is a missing sample.
        times: since the record's start, s, ``(N,)``, rising.
        unit: in SI.
        source: the columns that it was read from.
        clock: how the times run; None where nothing but the times is known.
        written: the unit in which the values were given; "" for none, or several.
    """

    values: Floats
    times: Floats
    unit: str
    source: str
    clock: Clock | None = None
    written: str = ""

    @property
    def running(self) -> Clock:
        """The clock, judged from the times where none is known."""
        return self.clock or judged(self.times)

    @property
    def present(self) -> NDArray[np.bool_]:
        """Which samples hold a number, ``(N,)``."""
        filled: NDArray[np.bool_] = ~np.isnan(self.values)
        return filled if filled.ndim == 1 else np.asarray(filled.any(axis=1))

    @property
    def rate_hz(self) -> float:
        """Samples that hold a number, per second; 0 where there is only one."""
        times = self.times[self.present]
        if len(times) == len(self.times):
            return self.running.rate_hz
        return float((len(times) - 1) / np.ptp(times)) if len(times) > 1 else 0.0
