"""What a solver is."""

from typing import Any, Protocol

from tuner.certificate.solution import Solution


class Solver(Protocol):
    """A frozen dataclass that is called with a problem, or with a convex program."""

    @property
    def name(self) -> str:
        """What it is called in results."""
        ...

    def __call__(self, problem: Any, /) -> Solution:
        """A certified solution."""
        ...
