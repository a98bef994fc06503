"""How good a fit is: before and after, on data that was not used, and what its innovations say."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from filters.declared import bare
from tuner.certificate.solution import Solution
from tuner.diagnostics import Diagnostics
from tuner.problem.problem import Problem
from tuner.run.diagnosed import diagnosed
from tuner.run.posed import NO_TRUTH, Posed

SHARE = 0.7
"""Share of the samples, or of the recordings, that a second fit is tuned on; the rest judges it."""
FEW = 3
"""From so many recordings on, whole recordings are held out instead of the end of each."""


@dataclass(frozen=True)
class HeldOut:
    """The filter tuned on a part of the data, judged on the rest by the fit's own objective.

    Attributes:
        what: which part judges, in words.
        start: the objective there with the values that the search began with.
        tuned: with those that were tuned on the other part.
    """

    what: str
    start: float
    tuned: float


@dataclass(frozen=True)
class Judged:
    """What a fit came to.

    Attributes:
        objective: its name.
        unit: of its values.
        start: its value where the search began.
        tuned: its value at the solution.
        held_out: the same on data that was not used; None where there is too little.
        diagnostics: what the innovations say of the start and of the solution; None for a filter
            without any.
    """

    objective: str
    unit: str
    start: float
    tuned: float
    held_out: HeldOut | None
    diagnostics: tuple[Diagnostics, Diagnostics] | None


def first_part(posed: Posed) -> Problem | None:
    """The same problem on a part of the data alone, to be judged on the rest; None for too little.

    The filter runs over all of it; what does not count has a truth of NaN.
    """
    mask = _counts(posed.problem)
    if mask is None:
        return None
    return replace(_only(posed.problem, mask), name=f"{posed.problem.name}_part")


def judge(posed: Posed, solution: Solution, part: Solution | None) -> Judged:
    """Before and after, on all data and on what was held out; and the innovations.

    Args:
        posed: the problem.
        solution: tuned on all of the data.
        part: tuned on :func:`first_part`; None where there is none.
    """
    begun = posed.problem.parameters(posed.problem.space.start())
    fitted = posed.problem.space.size if posed.objective in NO_TRUTH else 0
    before, now = diagnosed(posed, begun), diagnosed(posed, _of(solution), fitted=fitted)
    return Judged(
        posed.objective,
        posed.unit,
        posed.problem.score(begun),
        posed.problem.score(_of(solution)),
        None if part is None else _held_out(posed.problem, begun, _of(part)),
        None if before is None or now is None else (before, now),
    )


def _of(solution: Solution) -> dict[str, np.ndarray]:
    return {name: parameter.value for name, parameter in solution.parameters.items()}


def _counts(problem: Problem) -> np.ndarray | None:
    """What the second fit is tuned on, over samples ``(N,)`` or recordings ``(1, k)``."""
    shape = np.shape(problem.data.truth)
    lanes = getattr(problem.filter, "count", 1)
    if lanes >= FEW:
        return np.arange(lanes)[None] < round(SHARE * lanes)
    seen = ~np.isnan(np.asarray(problem.data.truth)).all(axis=tuple(range(1, len(shape))))
    rows = np.flatnonzero(seen)
    if len(rows) < 50:
        return None
    last = int(rows[int(SHARE * len(rows))])
    return np.asarray(np.arange(shape[0]) <= last)


def _only(problem: Problem, mask: np.ndarray) -> Problem:
    """The problem with the samples that count; the others have a truth of NaN."""
    truth = np.asarray(problem.data.truth)
    wide = mask.reshape(mask.shape + (1,) * (truth.ndim - mask.ndim))
    data = problem.data._replace(truth=np.where(wide, truth, np.nan))
    return replace(problem, data=data)


def _held_out(problem: Problem, begun: Mapping[str, Any], tuned: Mapping[str, Any]) -> HeldOut:
    mask = _counts(problem)
    if mask is None:
        raise ValueError("nothing is held out of so little data")
    rest = _only(problem, ~mask)
    count = int((~mask).sum())
    recordings = f"{count} recording{'' if count == 1 else 's'}"
    what = recordings if mask.ndim == 2 else f"the last {count} samples"
    return HeldOut(what, rest.score(begun), rest.score(tuned))


def filter_name(posed: Posed) -> str:
    """Name of the filter's class."""
    return type(bare(posed.problem.filter)).__name__
