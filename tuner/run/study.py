"""What a study is, and how studies are found."""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from tuner.catalogue import find, names
from tuner.run.comparison import Comparison
from tuner.run.figure import Figure

if TYPE_CHECKING:
    from jax import Array
    from pydantic import BaseModel

    from tuner.certificate.single_precision import SinglePrecision
    from tuner.certificate.solution import Solution
    from tuner.data.logs import Log
    from tuner.export.tuned import Quantity
    from tuner.problem.problem import Problem
    from tuner.solvers.convex import ConvexTask

Solver: TypeAlias = "Callable[[Any], Solution]"
"""A solver of a :class:`Problem`, or of a convex program."""


@dataclass(frozen=True)
class Source:
    """Which data a run used.

    Attributes:
        name: the log's file name, or what was made up instead.
        sha256: of the log's bytes, or of the made-up samples; of the model where there are none.
        samples: how many samples; 0 for a design, which needs none.
        rate_hz: sample rate; 0 for a design.
    """

    name: str
    sha256: str
    samples: int
    rate_hz: float

    @classmethod
    def simulated(cls, name: str, made: Sequence[np.ndarray], rate_hz: float) -> "Source":
        """Made-up records side by side.

        Args:
            name: what was made up.
            made: one array ``(N, k, ...)`` or several, of k records of N samples each.
            rate_hz: sample rate.

        >>> Source.simulated("two steps", [np.zeros((500, 2, 3))], 100.0).samples
        1000
        """
        digest = hashlib.sha256(b"".join(array.tobytes() for array in made)).hexdigest()
        return cls(name, digest, made[0].shape[0] * made[0].shape[1], rate_hz)


@dataclass(frozen=True)
class Task:
    """One problem, or convex program, for one solver."""

    problem: "Problem | ConvexTask"
    solver: Solver
    solver_name: str


Solutions: TypeAlias = "Mapping[tuple[str, str], Solution]"
"""Solutions by the names of problem and solver."""


def best(problem: str, solutions: Solutions) -> "Solution":
    """The solution of a problem with the lowest value; among equals (to 1e-6) a converged one."""
    candidates = [s for (name, _), s in solutions.items() if name == problem]
    lowest = min(s.value for s in candidates)
    equals = [s for s in candidates if s.value <= lowest + 1e-6 * abs(lowest)]
    return min(equals, key=lambda s: (not s.status.trusted, s.value))


def tuned_values(solution: "Solution") -> "dict[str, Array]":
    """The parameters that a solution found, by name, as filters take them."""
    import jax.numpy as jnp

    return {name: jnp.asarray(p.value) for name, p in solution.parameters.items()}


@dataclass(frozen=True)
class Target:
    """A problem whose solution goes onto a machine.

    Attributes:
        problem: the problem.
        filter: name of the filter.
        states: the order of its states.
        dt: sample time, s; 0 where it is continuous.
        quantities: what is exported besides the parameters, given the solution.
        single: the same solution run in single precision.
        meanings: of the parameters, a short sentence by name.
    """

    problem: "Problem"
    filter: str
    states: tuple[str, ...]
    dt: float
    quantities: "Callable[[Solution], tuple[Quantity, ...]]"
    single: "Callable[[Solution], tuple[SinglePrecision, ...]]"
    meanings: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Plan:
    """What a study does with given settings, data and seed.

    Attributes:
        source: the data.
        tasks: what is solved.
        targets: what is exported.
        compare: the rows of the comparison, given all solutions.
        figures: the figures, given all solutions.
    """

    source: Source
    tasks: tuple[Task, ...]
    targets: tuple[Target, ...]
    compare: Callable[[Solutions], list[Comparison]]
    figures: Callable[[Solutions], Iterable[Figure]]


@dataclass(frozen=True)
class Study:
    """A published result to run again, or a benchmark.

    Attributes:
        name: what it is called on the command line.
        title: one line.
        paper: the citation.
        settings: the model of its options, a frozen pydantic model that forbids unknown names.
        channels: what ``--map`` may name, with a description each; empty if it takes no log.
        plan: from settings, log (or None), seed and database URL to the plan.
    """

    name: str
    title: str
    paper: str
    settings: "type[BaseModel]"
    channels: Mapping[str, str] = field(hash=False)
    plan: "Callable[[Any, Log | None, int, str], Plan]"


def study_names() -> list[str]:
    """The names of all installed studies, sorted; none of them is imported."""
    return names("tuner.studies")


def find_study(name: str) -> Study:
    """Load a study by name, from whichever installed package offers it.

    Raises:
        ValueError: for an unknown name, with the near ones, and for one that cannot be imported.

    >>> find_study("kownacki2010").paper.split(",")[0]
    'C. Kownacki'
    """
    study: Study = find("tuner.studies", name)
    return study
