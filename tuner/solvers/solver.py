"""The protocol of a solver."""

from typing import Any, Protocol

from tuner.certificate.solution import Solution


class Solver(Protocol):
    """A frozen dataclass that is called with a problem, or with a convex program."""

    @property
    def name(self) -> str:
        """Its name in results."""
        ...

    def __call__(self, problem: Any, /) -> Solution:
        """A certified solution."""
        ...
