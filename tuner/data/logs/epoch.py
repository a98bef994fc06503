"""The unit of a time column that names none: known by its size, or proposed by the rate."""

import numpy as np

# The years 2001 to 2096, in seconds since 1970.
_FIRST, _LAST = 978_307_200, 3_976_214_400
_TIMES = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}
_USUAL_HZ = 100.0


def since_1970(low: float, high: float) -> str | None:
    """The unit in which numbers count the time since 1970; None where that is unlikely.

    No two units fit, for the years 2001 to 2096 are within a factor of 4.1.

    >>> since_1970(1_700_000_000_000, 1_700_000_000_020), since_1970(0, 4)
    ('ms', None)
    """
    for unit, times in _TIMES.items():
        if _FIRST * times <= low <= high <= _LAST * times:
            return unit
    return None


def proposed(step: float) -> tuple[str, float]:
    """The unit that makes the most usual rate of a step, and that rate in Hz.

    >>> [proposed(step)[0] for step in (10, 20_000, 5e7)]
    ['ms', 'us', 'ns']
    """
    rates = {unit: _TIMES[unit] / step for unit in ("ms", "us", "ns")}
    unit = min(rates, key=lambda name: abs(np.log(rates[name] / _USUAL_HZ)))
    return unit, rates[unit]
