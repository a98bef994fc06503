"""From a run of the solver to a checked answer."""

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from tuner.certificate.solution import Status
from tuner.convex.answer import Answer
from tuner.convex.clarabel import Descent

if TYPE_CHECKING:
    import cvxpy as cp

ADMISSIBLE = 1e-6
"""The largest violation of a trusted point, as a share of the constraint's terms."""

_WITHOUT_POINT = {Status.INFEASIBLE: np.inf, Status.UNBOUNDED: -np.inf}


class Readable(Protocol):
    """A program's name, its variables and its constraints."""

    @property
    def name(self) -> str:
        """The program's name."""
        ...

    @property
    def problem(self) -> "cp.Problem":
        """The cvxpy problem that was solved."""
        ...

    @property
    def variables(self) -> Mapping[str, "cp.Variable"]:
        """The variables to be read."""
        ...

    @property
    def constraints(self) -> Mapping[str, "cp.Constraint"]:
        """The constraints whose dual variables are read."""
        ...


def read(program: Readable, run: Descent, begun: float) -> Answer:
    """The answer of a run, checked by the constraints themselves.

    Args:
        program: the solved one.
        run: of the solver.
        begun: when it began, by :func:`time.perf_counter`.
    """
    problem, status = program.problem, run.status
    value, violation = _WITHOUT_POINT.get(status, np.nan), np.inf
    variables: dict[str, np.ndarray] = {}
    duals: dict[str, np.ndarray] = {}
    if run.present and _whole(run.solution):
        problem.unpack(run.solution)
        value = float(problem.objective.value)
        violation = max(map(_violation, problem.constraints), default=0.0)
        variables = {name: np.array(v.value, float) for name, v in program.variables.items()}
        duals = {name: _dual(c) for name, c in program.constraints.items()}
        if status is Status.CONVERGED and not violation <= ADMISSIBLE:
            status = Status.STALLED
    elif run.present:
        status = Status.FAILED
    gap = np.inf if run.proved is None else value - run.proved
    return Answer(
        status=status,
        message=_message(program.name, run, status, gap, violation),
        value=value,
        variables=variables,
        duals=duals,
        multipliers=_multipliers(program, duals, value),
        lower_bound=run.proved,
        gap=float(gap),
        violation=float(violation),
        iterations=run.iterations,
        seconds=time.perf_counter() - begun,
    )


def _whole(solution: Any) -> bool:
    """Whether there is a point, all of it finite."""
    points = [np.asarray(part, float) for part in solution.primal_vars.values() if part is not None]
    return bool(points) and all(np.isfinite(point).all() for point in points)


def _dual(constraint: "cp.Constraint") -> np.ndarray:
    value = constraint.dual_value
    return np.zeros(0) if value is None else np.array(value, float)


def _violation(constraint: "cp.Constraint") -> float:
    """Largest violation, over one plus the largest entry of the constraint's terms."""
    terms = [np.max(np.abs(arg.value), initial=0.0) for arg in constraint.args]
    return float(np.max(constraint.violation(), initial=0.0) / (1.0 + max(terms, default=0.0)))


def _multipliers(program: Readable, duals: dict[str, np.ndarray], value: float) -> dict[str, float]:
    from cvxpy.constraints.nonpos import Inequality
    from cvxpy.constraints.zero import Equality

    found = {}
    for name, dual in duals.items():
        constraint = program.constraints[name]
        sides = [arg.value for arg in constraint.args if not arg.variables()]
        equal = isinstance(constraint, Equality)
        if equal or isinstance(constraint, Inequality):
            for side in sides[:1]:
                bound = np.broadcast_to(side, dual.shape)
                share = np.sum(dual * (bound if equal else np.abs(bound)))
                found[name] = float(share / (abs(value) or 1.0))
    return found


def _message(name: str, run: Descent, status: Status, gap: float, violation: float) -> str:
    looser = f", at a tolerance of {run.tolerance:g} only" if run.looser else ""
    reached = f"gap {gap:.1e}, largest violation {violation:.1e}"
    match status:
        case Status.CONVERGED:
            return f"{name} is solved{looser}: {reached}"
        case Status.INFEASIBLE:
            return f"no point keeps every constraint of {name}, as a dual ray proves{looser}"
        case Status.UNBOUNDED:
            return f"the objective of {name} falls without limit{looser}"
        case Status.STALLED | Status.LIMIT:
            return f"Clarabel ended {name} by {run.ended} short of {run.tolerance:g}: {reached}"
        case _:
            return f"Clarabel ended {name} by {run.ended} without a usable point"
