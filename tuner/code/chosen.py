"""The fewest steps that show what all steps that were found show."""

from collections.abc import Callable, Hashable, Iterable, Sequence
from typing import TypeAlias

import numpy as np

from tuner.code.states import Arrays

Also: TypeAlias = Callable[[int], list[Hashable]]
"""What a step of a batch shows, by its place there."""


_WORTH = 50
"""Least of what matters least that is worth a step."""


class Chosen:
    """Steps, and what each of them shows: constants, what matters less, and what matters least.

    Attributes:
        steps: a field each.
    """

    def __init__(self) -> None:
        self.steps = list[Arrays]()
        self._places = dict[Hashable, int]()
        self._shown = list[list[int]]()

    def take(self, step: Arrays, *shown: Iterable[Hashable]) -> None:
        """Add a step, a field each, with what it shows, the constants first."""
        self.steps.append(step)
        self._shown.append([self._bits(some) for some in shown or [()]])

    def show(self, ones: Sequence[Hashable], where: np.ndarray) -> None:
        """Add constants that show, with the steps in which each does, ``(M, C)``."""
        for one, row in zip(ones, where, strict=True):
            for at in np.flatnonzero(row).tolist():
                self._shown[at][0] |= self._bits([one])

    def _bits(self, shown: Iterable[Hashable]) -> int:
        found = 0
        for one in shown:
            found |= 1 << self._places.setdefault(one, len(self._places))
        return found

    def fewest(self, most: int, good: Sequence[bool]) -> list[int]:
        """Places of so many good steps that together show as much as can be, in order.

        The one that shows most of what is left comes first. Where there is room, all that can be
        is shown by two.
        """
        kept = list[int]()
        for _ in range(2):
            left = (1 << len(self._places)) - 1
            rest = [at for at, fits in enumerate(good) if fits and at not in kept]
            while len(kept) < most:
                best = self._best(left, rest)
                if best is None:
                    break
                kept.append(best)
                rest.remove(best)
                for bits in self._shown[best]:
                    left &= ~bits
        return sorted(kept)

    def _best(self, left: int, rest: Sequence[int]) -> int | None:
        """The step that shows most of what is left; None: no step shows what is worth one."""
        gains = [[(bits & left).bit_count() for bits in self._shown[at]] for at in rest]
        best = max(range(len(rest)), key=gains.__getitem__, default=None)
        if best is None or not (any(gains[best][:2]) or sum(gains[best]) >= _WORTH):
            return None
        return rest[best]
