"""A filter tuned for accuracy, whose variances are then scaled to what its errors are."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from filters.declared import bare, channel_facts
from tuner.certificate.solution import Solution, TunedParameter
from tuner.problem.parameters import Fixed
from tuner.problem.problem import Problem
from tuner.run.fit_problem import NO_TRUTH, Posed
from tuner.run.sample_terms import run_with
from tuner.run.variance_powers import check_powers, scaled_values, variance_powers
from tuner.solvers.solver import Solver

FACTOR = "variances_scaled_by"
"""Under this name among what is derived of a solution stands the factor of its rescaling."""


@dataclass(frozen=True)
class VarianceScaling:
    """The result of a rescaling.

    Attributes:
        factor: by which every variance was multiplied; 1 where none was.
        powers: of the factor, by parameter: 1 of a variance, 1/2 of a deviation.
        nis: mean of y^2 / s over the innovations before and after.
        nees: mean of e' P^-1 e over the numbers of e, of the error against the truth, before and
            after; None where the filter outputs no covariance ``P`` of what has a truth.
        reason: why nothing was rescaled; "" where it was.
    """

    factor: float
    powers: dict[str, float]
    nis: tuple[float, float]
    nees: tuple[float, float] | None
    reason: str = ""


def scale_variances(problem: Problem, solution: Solution) -> tuple[Solution, VarianceScaling]:
    """Scale all of a solution's noise variances by one factor, which leaves its estimates.

    An error against a truth determines a Kalman filter's gains, and so the ratios of its variances,
    but not their common factor: it is as accurate with any, and as sure of itself as that says. The
    factor that makes the NIS 1 is the NIS. Source: Bar-Shalom, Li and Kirubarajan, Estimation with
    Applications to Tracking and Navigation, 2001, 5.4.

    Args:
        problem: its filter outputs ``innovation`` and ``variance``; for the NEES ``P`` as well,
            ``(..., n, n)``, of which the first rows belong to what has a truth.
        solution: what was found for it.

    Returns:
        The solution with other values and intervals, and what was done; the solution itself, and
        why, where the estimates would move or the factor cannot be told.
    """
    values = {name: parameter.value for name, parameter in solution.parameters.items()}
    nis, nees = nis_of(problem, values), nees_of(problem, values)
    untouched = VarianceScaling(1.0, {}, (nis, nis), None if nees is None else (nees, nees))
    if not 0 < nis < np.inf:
        return solution, replace(untouched, reason="no factor makes it 1")
    try:
        found = _powers(problem, values, nis)
        z = problem.space.unconstrain(scaled_values(values, found, nis))
    except ValueError as error:
        return solution, replace(untouched, reason=str(error))
    parameters = {
        name: _scaled(parameter, nis ** found.get(name, 0.0))
        for name, parameter in solution.parameters.items()
    }
    derived = problem.derived(z) | {FACTOR: nis}
    after = None if nees is None else (nees, nees / nis)
    scaled = replace(solution, z=z, parameters=parameters, derived=derived)
    return scaled, VarianceScaling(nis, found, (nis, 1.0), after)


@dataclass(frozen=True)
class WithScaledVariances:
    """A solver whose solutions are rescaled to a NIS of 1.

    Attributes:
        solver: what solves.
    """

    solver: Solver

    @property
    def name(self) -> str:
        """That of the solver."""
        return self.solver.name

    def check(self, problem: Problem) -> None:
        """Refuse what the solver cannot begin."""
        if hasattr(self.solver, "check"):
            self.solver.check(problem)

    def __call__(self, problem: Problem) -> Solution:
        """Solve, and rescale where the estimates stay."""
        return scale_variances(problem, self.solver(problem))[0]


def can_scale_variances(posed: Posed) -> bool:
    """Whether a fit is for accuracy, of a filter whose innovations have variances."""
    outputs = channel_facts(bare(posed.problem.filter), "outputs")
    return posed.objective not in NO_TRUTH and {"innovation", "variance"} <= outputs.keys()


def scaling_of(problem: Problem, solution: Solution) -> VarianceScaling:
    """The scaling of a solution of :class:`WithScaledVariances`, or why there was none."""
    if FACTOR not in solution.derived:
        return scale_variances(problem, solution)[1]
    values = {name: parameter.value for name, parameter in solution.parameters.items()}
    factor, nis, nees = solution.derived[FACTOR], nis_of(problem, values), nees_of(problem, values)
    before = None if nees is None else (factor * nees, nees)
    return VarianceScaling(
        factor, variance_powers(problem, values, _held(problem)), (factor * nis, nis), before
    )


def _powers(problem: Problem, values: Mapping[str, Any], factor: float) -> dict[str, float]:
    """Of what is not held; where that does not do, and what is held would, that is said."""
    held = _held(problem)
    try:
        found = variance_powers(problem, values, held)
        check_powers(problem, values, found, factor)
        return found
    except ValueError:
        if not held:
            raise
    found = variance_powers(problem, values)
    check_powers(problem, values, found, factor)
    raise ValueError(
        f"{' and '.join(sorted(held & found.keys()))} is held; {', '.join(found)} scaled together "
        f"by {factor:.3g} would make it 1"
    )


def _held(problem: Problem) -> set[str]:
    """The parameters on whose value somebody insists."""
    kinds = problem.space.parameters
    return {name for name, kind in kinds if isinstance(kind, Fixed) and not kind.nominal}


def _scaled(parameter: TunedParameter, factor: float) -> TunedParameter:
    """A parameter and its ranges times a factor."""
    ranges = {
        name: tuple(factor * end for end in interval)
        for name in ("interval", "robust")
        if (interval := getattr(parameter, name)) is not None
    }
    changed: Any = ranges | {"value": parameter.value * factor}
    if parameter.deviation is not None:
        changed["deviation"] = parameter.deviation * factor
    return replace(parameter, **changed)


def nis_of(problem: Problem, values: Mapping[str, Any]) -> float:
    """Mean of y^2 / s over the numbers that count; NaN where none does."""
    outputs = run_with(problem, values)
    y, s = np.asarray(outputs.innovation), np.asarray(outputs.variance)
    s = np.broadcast_to(s, y.shape)
    return float(np.mean(y[s > 0] ** 2 / s[s > 0])) if (s > 0).any() else float("nan")


def nees_of(problem: Problem, values: Mapping[str, Any]) -> float | None:
    """Mean of e' P^-1 e over the numbers of e; None without a covariance of what has a truth."""
    outputs, truth = run_with(problem, values), np.asarray(problem.data.truth)
    estimate = getattr(outputs, getattr(problem.objective, "name", "") or "_", None)
    P = np.asarray(getattr(outputs, "P", np.zeros(0)))
    if estimate is not None and np.shape(estimate) == truth.shape and P.ndim == truth.ndim + 2:
        estimate, truth, P = _one_of_them(problem, np.asarray(estimate), truth, P)
    if estimate is None or np.shape(estimate) != truth.shape or P.ndim != truth.ndim + 1:
        return None
    error = np.asarray(estimate) - truth
    known = ~np.isnan(error).all(axis=tuple(range(error.ndim - 1)))
    error, n = error[..., known], int(known.sum())
    if not known[:n].all() or P.shape[-1] < n:
        return None
    seen = ~np.isnan(error).any(axis=-1)
    e, P = error[seen], np.broadcast_to(P, (*error.shape[:-1], *P.shape[-2:]))[seen][:, :n, :n]
    return float(np.einsum("ti,ti->t", e, np.linalg.solve(P, e[..., None])[..., 0]).mean() / n)


def _one_of_them(
    problem: Problem, estimate: np.ndarray, truth: np.ndarray, P: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One state of those whose covariance is put out, as a vector of one."""
    own, name = bare(problem.filter), getattr(problem.objective, "name", "")
    facts = channel_facts(own, "states") if hasattr(own, "states") else {}
    if name not in facts:
        return estimate, truth, P
    if facts[name].kind == "angle":
        estimate = estimate - 2 * np.pi * np.round((estimate - truth) / (2 * np.pi))
    i = [*facts].index(name)
    return estimate[..., None], truth[..., None], P[..., i : i + 1, i : i + 1]
