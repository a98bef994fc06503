"""What a solver returns: the best point, how it ended, and what speaks for it."""

from dataclasses import dataclass, field
from enum import Enum

import numpy as np


class Status(Enum):
    """How a solution ended, each with its sentence."""

    CONVERGED = "converged"
    STALLED = "stalled"
    LIMIT = "limit"
    AT_BOUND = "at bound"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    UNATTAINED = "unattained"
    FAILED = "failed"

    @property
    def sentence(self) -> str:
        """What the status means."""
        return _SENTENCES[self]

    @property
    def trusted(self) -> bool:
        """Whether a solution may be exported without being forced."""
        return self is Status.CONVERGED


_SENTENCES = {
    Status.CONVERGED: "the gradient vanishes here",
    Status.STALLED: "the method stopped by its own tolerance, but the gradient does not vanish",
    Status.LIMIT: "the allowed number of evaluations was used up before the gradient vanished",
    Status.AT_BOUND: "a bound of the search box holds the solution; the optimum lies beyond it",
    Status.INFEASIBLE: "no point was found that keeps every constraint",
    Status.UNBOUNDED: "the objective falls without limit",
    Status.UNATTAINED: "the objective falls towards a limit that no point reaches",
    Status.FAILED: "the objective is not a number at the start, or the method broke off",
}


@dataclass(frozen=True)
class TunedParameter:
    """One tuned parameter.

    Attributes:
        value: number ``()`` or matrix.
        unit: its unit.
        interval: the range over which the objective stays within 1 % of its best, the other
            parameters following (quadratic model); None where the data does not determine it
            or it is not a free positive or bounded number.
    """

    value: np.ndarray
    unit: str
    interval: tuple[float, float] | None


@dataclass(frozen=True)
class Starts:
    """Whether several starts came to the same end.

    Attributes:
        count: how many starts there were.
        agreeing: how many ended within 0.1 % of the best value, the best included.
        worst: the worst end over the best one, 1 where all agree.
    """

    count: int
    agreeing: int
    worst: float


@dataclass(frozen=True)
class Certificate:
    """What speaks for a solution, in unconstrained coordinates z and relative to the value.

    Attributes:
        gradient: derivative of ln value by each coordinate.
        active_bounds: coordinates that lie on their bound.
        curvatures: eigenvalues of the Hessian over the value, ascending.
        flat_directions: a sentence for each direction in which nothing is determined.
        starts: agreement of the starts.
        methods: best value of every other solver on the same problem over this one's value.
        multipliers: by constraint, by how many per cent the value falls where the bound is 1 %
            wider; the gradient is then what is left of it after the constraints' share.
        lower_bound: no admissible point has a lower value: a dual solution proves it. None where
            nothing is proved.
    """

    gradient: dict[str, float]
    active_bounds: tuple[str, ...]
    curvatures: tuple[float, ...]
    flat_directions: tuple[str, ...]
    starts: Starts
    methods: dict[str, float]
    multipliers: dict[str, float] = field(default_factory=dict)
    lower_bound: float | None = None


@dataclass(frozen=True)
class Solution:
    """The best point that a solver found.

    Attributes:
        problem, solver: the names of both.
        status: how it ended.
        message: that, in a sentence.
        value: the objective there.
        z: the point, ``(n,)``.
        parameters: the parameters there, by name.
        derived: the derived quantities there, by name.
        evaluations: how often the objective was evaluated, over all starts.
        seconds: how long it took, compilation included.
        certificate: what speaks for it.
    """

    problem: str
    solver: str
    status: Status
    message: str
    value: float
    z: np.ndarray
    parameters: dict[str, TunedParameter]
    derived: dict[str, float]
    evaluations: int
    seconds: float
    certificate: Certificate
