"""How good a fit is: before and after, on data that was not used, and what its innovations say."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from filters.declared import bare
from objectives.in_numpy import Method, in_numpy
from tuner.certificate.solution import Solution, Status
from tuner.diagnostics import Diagnostics
from tuner.problem.problem import Problem
from tuner.run.excluded_stretches import ExcludedStretches
from tuner.run.fit_problem import NO_TRUTH, Posed
from tuner.run.front import Trade
from tuner.run.gate import Rejected, rejected_of
from tuner.run.held_out import HeldOut
from tuner.run.innovation_diagnostics import diagnose_innovations
from tuner.run.variance_scaling import VarianceScaling


@dataclass(frozen=True)
class Judged:
    """The judgement of a fit.

    Attributes:
        objective: its name.
        unit: of its values.
        start: its value where the search began; of a likelihood the equivalent deviation.
        tuned: the same at the solution.
        held_out: the same on data that was not used; None where there is too little.
        diagnostics: what the innovations say of the start and of the solution; None for a filter
            without any.
        rejected: what a gate left out at the solution; None without one.
        trade: what a second objective costs; None without one.
        left_out: stretches that contradict the rest of the record; None where none were looked for.
        rescaled: what became of all variances after a fit against a truth; None where the filter
            has none.
    """

    objective: str
    unit: str
    start: float
    tuned: float
    held_out: HeldOut | None
    diagnostics: tuple[Diagnostics, Diagnostics] | None
    rejected: Rejected | None = None
    left_out: ExcludedStretches | None = None
    rescaled: VarianceScaling | None = None
    trade: Trade | None = None


def judge(posed: Posed, solution: Solution, held_out: HeldOut | None) -> Judged:
    """Before and after, on all data and on what was held out; and the innovations.

    Args:
        posed: the problem.
        solution: tuned on all of the data.
        held_out: what it is worth on what was not used; None where nothing was held out.

    Raises:
        ValueError: where a gate refuses all.
    """
    found = solution.status is not Status.FAILED
    rejected = rejected_of(posed.problem.outputs(solution)) if found else None
    begun = posed.problem.parameters(posed.problem.space.start())
    fitted = posed.problem.space.size if posed.objective in NO_TRUTH else 0
    before = diagnose_innovations(posed, begun)
    now = diagnose_innovations(posed, _of(solution), fitted=fitted)
    return Judged(
        posed.objective,
        posed.unit,
        shown(posed.problem, posed.problem.score(begun)),
        shown(posed.problem, posed.problem.score(_of(solution))),
        held_out,
        None if before is None or now is None else (before, now),
        rejected,
        posed.left_out,
    )


def shown(problem: Problem, value: float) -> float:
    """A value as people read it: of a likelihood the equivalent deviation, in the unit measured."""
    objective: Any = problem.objective
    if not hasattr(objective, "deviation"):
        return value
    return float(in_numpy(Method(objective, "deviation"), value))


def _of(solution: Solution) -> dict[str, np.ndarray]:
    return {name: parameter.value for name, parameter in solution.parameters.items()}


def filter_name(posed: Posed) -> str:
    """Name of the filter's class."""
    return type(bare(posed.problem.filter)).__name__
