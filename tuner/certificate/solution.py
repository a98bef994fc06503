"""A solver's result: the best point, how it ended, and the evidence for it."""

from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

import numpy as np

from tuner.certificate.table import as_html, as_text


class Status(Enum):
    """The ways that a solution can end, each with its sentence."""

    CONVERGED = "converged"
    KINK = "at a kink"
    STAIRCASE = "on a step"
    STARTS_DIFFER = "starts differ"
    SADDLE = "saddle"
    STALLED = "stalled"
    LIMIT = "limit"
    AT_BOUND = "at bound"
    INFEASIBLE = "infeasible"
    UNBOUNDED = "unbounded"
    UNATTAINED = "unattained"
    FAILED = "failed"

    @property
    def sentence(self) -> str:
        """The meaning of the status."""
        return _SENTENCES[self]

    @property
    def trusted(self) -> bool:
        """Whether a solution may be exported without being forced."""
        return self in (Status.CONVERGED, Status.KINK, Status.STAIRCASE)


_SENTENCES = {
    Status.CONVERGED: "the gradient vanishes here, and no neighbour that was tried is lower",
    Status.KINK: "the objective has a kink here, from which it rises in all directions tried",
    Status.STAIRCASE: "the objective changes in steps, and no neighbour that was tried is lower",
    Status.STARTS_DIFFER: "a local minimum that most starts did not reach",
    Status.SADDLE: "the gradient vanishes here, but the value falls in some direction",
    Status.STALLED: "the method stopped by its own tolerance, but lower values were seen",
    Status.LIMIT: "the allowed number of evaluations was used up before the gradient vanished",
    Status.AT_BOUND: "the solution lies on a bound of the search box; the optimum lies beyond it",
    Status.INFEASIBLE: "no point was found that satisfies every constraint",
    Status.UNBOUNDED: "the objective falls without limit",
    Status.UNATTAINED: "the objective falls towards a limit that no point reaches",
    Status.FAILED: "the objective is not a number at the start, or the method failed",
}


class Interval(NamedTuple):
    """A range for a parameter, and its kind.

    Attributes:
        ends: lowest and highest value; the farthest that there is (0 or infinite for a positive
            parameter) where the data set no limit to that side.
        kind: "95 %, likelihood ratio", "95 %, sandwich", or "1 % of the cost".
    """

    ends: tuple[float, float]
    kind: str


@dataclass(frozen=True)
class TunedParameter:
    """One tuned parameter.

    Attributes:
        value: number ``()`` or matrix.
        unit: its unit.
        interval: lowest and highest value; None where the data do not determine it, or it is not
            a free single number. Of a likelihood: where twice the log likelihood, the other
            parameters following, has fallen by 3.84, which holds the true value in 95 of 100
            records; where the data set a limit to one side alone the other end is 0 or infinite,
            and the limit is one of 95 % to that side. Of a mean square: 95 % by the scatter of
            the errors over time. Of any other cost: where it has risen by 1 %, which is no
            statement about the true value.
        interval_kind: which of the three, in words; "" without an interval.
        robust: of a likelihood, the interval that holds as well where the innovations are
            correlated or not Gaussian; None where the record is too short.
        deviation: of a matrix, the standard deviation of each entry, to first order; None for a
            number, a plain cost, and where the data do not determine it.
    """

    value: np.ndarray
    unit: str
    interval: tuple[float, float] | None
    interval_kind: str = ""
    robust: tuple[float, float] | None = None
    deviation: np.ndarray | None = None


@dataclass(frozen=True)
class Starts:
    """Agreement of several starts.

    Attributes:
        count: how many starts led to a point that meets every constraint.
        agreeing: how many ended as low as the best, itself included: within 0.1 % of its value, or
            within 0.05 nats of a likelihood.
        worst: by how much the worst end lies above the best, as a share of its value or in nats; 0
            where all agree.
    """

    count: int
    agreeing: int
    worst: float


@dataclass(frozen=True)
class Certificate:
    """The evidence for a solution, in unconstrained coordinates z.

    A likelihood is counted in nats of the whole record, everything else in shares of the value.

    Attributes:
        gradient: derivative by each coordinate.
        active_bounds: coordinates that lie on their bound.
        curvatures: eigenvalues of the Hessian, ascending.
        flat_directions: a sentence for each direction in which nothing is determined, which was
            tried: a tenfold change either way cannot be told from the best.
        starts: agreement of the starts.
        methods: the value that every other solver reached on the same problem.
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
    """The best point that a solver found; it shows itself as a table.

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
        certificate: the evidence for it.
        gradient_by: how gradients were taken: "C, compiled by ...", or "XLA, backwards: " or "XLA,
            forwards: " and why; "" where none was asked for.
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
    gradient_by: str = ""

    def __repr__(self) -> str:
        return as_text(self)

    def _repr_html_(self) -> str:
        return as_html(self)
