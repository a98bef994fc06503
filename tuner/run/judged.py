"""How good a fit is: before and after, on data that was not used, and whether it is consistent."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import jax.numpy as jnp
import numpy as np

from filters.declared import bare
from tuner.certificate.solution import Solution
from tuner.problem.problem import Problem
from tuner.run.posed import Posed

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
class Consistency:
    """Whether the innovations are as large, and as independent, as the filter says.

    Attributes:
        nis: mean of y^2 / s over the numbers that count; 1 where the filter is consistent.
        low, high: the range in which 95 of 100 consistent filters have it.
        lag_one: correlation of each normalised innovation with the one before; 0 if white.
        numbers: how many numbers count.
    """

    nis: float
    low: float
    high: float
    lag_one: float
    numbers: int

    @property
    def verdict(self) -> str:
        """In a few words."""
        if self.low <= self.nis <= self.high:
            return "consistent"
        if not self.nis > 0:
            return "nothing that is not foretold: too little noise to judge by"
        size = "too large" if self.nis < 1 else "too small"
        return f"noise variances {size} by a factor {max(self.nis, 1 / self.nis):.3g}"


@dataclass(frozen=True)
class Judged:
    """What a fit came to.

    Attributes:
        objective: its name.
        unit: of its values.
        start: its value where the search began; of a likelihood the equivalent deviation.
        tuned: the same at the solution.
        held_out: the same on data that was not used; None where there is too little.
        consistency: of the start and of the solution; None for a filter without a variance.
    """

    objective: str
    unit: str
    start: float
    tuned: float
    held_out: HeldOut | None
    consistency: tuple[Consistency, Consistency] | None


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
    consistency = None
    if posed.objective == "likelihood":
        consistency = (_consistent(posed.problem, begun), _consistent(posed.problem, _of(solution)))
    return Judged(
        posed.objective,
        posed.unit,
        shown(posed.problem, posed.problem.score(begun)),
        shown(posed.problem, posed.problem.score(_of(solution))),
        None if part is None else _held_out(posed.problem, begun, _of(part)),
        consistency,
    )


def shown(problem: Problem, value: float) -> float:
    """A value as people read it: of a likelihood the equivalent deviation, in the unit measured."""
    objective: Any = problem.objective
    return float(objective.deviation(value)) if hasattr(objective, "deviation") else value


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
    return HeldOut(what, *(shown(rest, rest.score(values)) for values in (begun, tuned)))


def _consistent(problem: Problem, values: Mapping[str, Any]) -> Consistency:
    y, s = innovations(problem, values)
    counted = s > 0
    normalised = np.where(counted, y / np.sqrt(np.where(counted, s, 1.0)), np.nan)
    numbers = int(counted.sum())
    spread = 1.96 * np.sqrt(2 / max(numbers, 1))
    nis = float(np.nanmean(normalised**2)) if numbers else float("nan")
    return Consistency(nis, max(1 - spread, 0.0), 1 + spread, lag_one(normalised), numbers)


def innovations(problem: Problem, values: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Innovations and their variances, ``(N, ..., m)``; variances of 0 where nothing counts."""
    from tuner.problem.problem import run_filter

    if problem.filter is None:
        raise ValueError(f"{problem.name} runs no filter")
    params = problem.static.build({n: jnp.asarray(v, float) for n, v in values.items()})
    outputs = run_filter(problem.filter, params, problem.data.inputs)
    return np.asarray(outputs.innovation), np.asarray(outputs.variance)


def lag_one(normalised: np.ndarray) -> float:
    """Correlation of each number with the one before of the same measurement, over all.

    >>> round(lag_one(np.array([[1.0], [-1.0], [1.0], [-1.0], [np.nan], [1.0]])), 6)
    -1.0
    """
    columns = normalised.reshape(len(normalised), -1).T
    pairs = [column[np.isfinite(column)] for column in columns]
    products = sum(float(c[1:] @ c[:-1]) for c in pairs)
    squares = sum(float(c[1:] @ c[1:]) + float(c[:-1] @ c[:-1]) for c in pairs) / 2
    return products / squares if squares else float("nan")


def filter_name(posed: Posed) -> str:
    """Name of the filter's class."""
    return type(bare(posed.problem.filter)).__name__
