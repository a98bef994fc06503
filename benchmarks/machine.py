"""The machine in neutral words: its relevant properties, and nothing that names it."""

import os
import platform
from dataclasses import dataclass

from benchmarks.baseline import Baseline
from tuner.run.environment import installed

PACKAGES = ("jax", "numpy", "scipy", "statsmodels", "dynamax", "filterpy")


@dataclass(frozen=True)
class Machine:
    """The machine on which the numbers were measured.

    Attributes:
        processors: their number.
        architecture: their kind.
        vectors: width of their vectors and the compiler, in words.
        software: versions, in words.
    """

    processors: int
    architecture: str
    vectors: str
    software: str

    @property
    def words(self) -> str:
        """All of it in one line."""
        plural = "s" if self.processors > 1 else ""
        return (
            f"{self.processors} {self.architecture} processor{plural}, {self.vectors}; "
            f"{self.software}"
        )


def machine(limit: Baseline | None) -> Machine:
    """This machine."""
    versions = [f"{name} {found}" for name in PACKAGES if (found := installed(name))]
    python = f"Python {platform.python_version()}"
    return Machine(
        processors=os.cpu_count() or 1,
        architecture=platform.machine(),
        vectors=f"vectors of {limit.vector_bits} bits, {limit.compiler}" if limit else "no C",
        software=", ".join([python, *versions]),
    )
