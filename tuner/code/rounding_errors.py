"""Random rounding errors of the operations of a step."""

from typing import NamedTuple

import numpy as np

_PLACES = 2**15
"""Places of a row of errors at which those of an operation may begin."""


class Noise(NamedTuple):
    """Random errors of every operation.

    Attributes:
        draw: a generator.
        size: of an error, over the result.
        repeats: number of times that each step is worked out with errors of its own.
    """

    draw: np.random.Generator
    size: float
    repeats: int

    def row(self, width: int, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Factors, and where those of each of so many operations begin, ``(repeats, width)``.

        Each operation has a part of a long row: to draw them all takes longer than the operations.
        """
        size = self.repeats * width
        row = 1 + self.size * self.draw.uniform(-1, 1, size + _PLACES)
        return row, self.draw.integers(_PLACES, size=-(-count // 1000) * 1000)[:count]
