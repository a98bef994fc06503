"""How good a fit is: before and after, on data that was not used, and whether it is consistent."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np

from filters.declared import bare
from tuner.certificate.solution import Solution
from tuner.problem.problem import Problem
from tuner.run.held_out import HeldOut
from tuner.run.posed import Posed
from tuner.run.rescaled import Rescaled


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
        start: its value where the search began.
        tuned: its value at the solution.
        held_out: the same on data that was not used; None where there is too little.
        consistency: of the start and of the solution; None for a filter without a variance.
        rescaled: what became of all variances after a fit against a truth; None where the filter
            has none.
    """

    objective: str
    unit: str
    start: float
    tuned: float
    held_out: HeldOut | None
    consistency: tuple[Consistency, Consistency] | None
    rescaled: Rescaled | None = None


def judge(posed: Posed, solution: Solution, held_out: HeldOut | None) -> Judged:
    """Before and after, on all data and on what was held out; and the innovations.

    Args:
        posed: the problem.
        solution: tuned on all of the data.
        held_out: what it is worth on what was not used; None where nothing was held out.
    """
    begun = posed.problem.parameters(posed.problem.space.start())
    consistency = None
    if posed.objective == "likelihood":
        consistency = (_consistent(posed.problem, begun), _consistent(posed.problem, _of(solution)))
    return Judged(
        posed.objective,
        posed.unit,
        posed.problem.score(begun),
        posed.problem.score(_of(solution)),
        held_out,
        consistency,
    )


def _of(solution: Solution) -> dict[str, np.ndarray]:
    return {name: parameter.value for name, parameter in solution.parameters.items()}


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
