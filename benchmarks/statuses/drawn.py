"""Random numbers that cases are made of."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from benchmarks.statuses.case import Case

Make: TypeAlias = Callable[[np.random.Generator, int], Case]
"""Makes a case from random numbers and its number."""


def power_of_ten(rng: np.random.Generator, low: float, high: float) -> float:
    """A number whose size is drawn evenly between two powers of ten."""
    return float(10 ** rng.uniform(low, high))


def place(rng: np.random.Generator, reach: float = 2.5) -> np.ndarray:
    """A point of the plane, ``(2,)``."""
    return rng.uniform(-reach, reach, 2)
