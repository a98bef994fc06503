"""What works out the nodes of a step on many states at once: compiled C, or NumPy."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np

from tuner.code.mutants import Mutant
from tuner.code.rounding_errors import Noise

Given: TypeAlias = Mapping[int, np.ndarray]
"""Values of the input nodes, a state each: ``(B,)``."""


class Values(Mapping[int, np.ndarray]):
    """Values of nodes on many states, ``(B,)`` or, where they are all one, ``(1,)`` each."""

    @abstractmethod
    def of(self, which: np.ndarray) -> "Values":
        """Those of some states."""


class Sums(NamedTuple):
    """Weighted sums of a step's results, and what moves them.

    Attributes:
        ends: the results.
        weights: of the results, ``(sums, ends, B)``.
        wanted: operands or results that are changed, each by itself; M of them.
        change: as a share.
        shift: half the distance of a difference quotient, over an operand.
    """

    ends: Sequence[int]
    weights: np.ndarray
    wanted: Sequence[Mutant]
    change: float
    shift: float


class Evaluation(Protocol):
    """Some nodes of a step, each of which follows from those before it.

    Attributes:
        inputs: the inputs among them.
    """

    inputs: list[int]

    def values(self, given: Given) -> Values:
        """Those that are wanted, from the inputs."""
        ...

    def noisy(self, given: Given, noise: Noise, ends: Sequence[int]) -> dict[int, np.ndarray]:
        """Some with random rounding errors of every operation, ``(repeats, B)`` each."""
        ...

    def changed(
        self, known: Values, ends: Sequence[int], mutants: Sequence[Mutant], by: float
    ) -> list[np.ndarray]:
        """Some, ``(M, B)`` where one of the changes moves them, or as they are.

        Args:
            known: all nodes without a change.
            ends: which are wanted.
            mutants: constants to be changed, one in each of M lanes.
            by: factor of a changed constant.
        """
        ...

    def slopes(self, known: Values, sums: Sums) -> np.ndarray:
        """Sums of squared moves of weighted sums of results, ``(M, B)``, to first order."""
        ...
