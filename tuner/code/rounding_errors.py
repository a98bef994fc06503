"""Random rounding errors of the operations of a step."""

from collections.abc import Iterator
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

    def errors(self, width: int) -> Iterator[np.ndarray]:
        """Factors of the results of one operation after another, ``(repeats, width)``.

        Each is a part of a long row: to draw them all takes longer than the operations.
        """
        size = self.repeats * width
        row = 1 + self.size * self.draw.uniform(-1, 1, size + _PLACES)
        while True:
            for begin in self.draw.integers(_PLACES, size=1000).tolist():
                yield row[begin : begin + size].reshape(self.repeats, width)
