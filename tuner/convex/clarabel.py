"""Runs of Clarabel, an interior-point method, on a problem compiled by cvxpy."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np

from tuner.certificate.solution import Status
from tuner.convex.bound import dual_bound

if TYPE_CHECKING:
    import cvxpy as cp

TOLERANCES = (1e-10, 1e-8, 1e-6)
"""Tolerances asked of the solver, one after the other until it converges."""

NEAR = 1e3
"""Sides and costs up to this size, and down to its inverse, are not scaled."""

_FINISHED = {
    "Solved": Status.CONVERGED,
    "PrimalInfeasible": Status.INFEASIBLE,
    "DualInfeasible": Status.UNBOUNDED,
}
_UNFINISHED = {
    "AlmostSolved": Status.STALLED,
    "InsufficientProgress": Status.STALLED,
    "MaxIterations": Status.LIMIT,
    "MaxTime": Status.LIMIT,
}

_BUILDING = RLock()


@contextmanager
def building() -> Iterator[None]:
    """A lock for building cvxpy expressions, which one unguarded counter numbers."""
    with _BUILDING:
        yield


@dataclass(frozen=True)
class Descent:
    """The outcome of a run of the solver.

    Attributes:
        ended: its own status.
        tolerance: the tolerance it was asked for.
        solution: cvxpy's reading of where it ended.
        proved: the lower bound that its dual point proves, if any.
        iterations: how many it took, those of the runs before it among them.
    """

    ended: str
    tolerance: float
    solution: Any
    proved: float | None
    iterations: int

    @property
    def looser(self) -> bool:
        """Whether its tolerance was looser than usual."""
        return self.tolerance > TOLERANCES[0]

    @property
    def status(self) -> Status:
        """The status."""
        return (_FINISHED | _UNFINISHED).get(self.ended, Status.FAILED)

    @property
    def present(self) -> bool:
        """Whether a point is expected."""
        return _has_point(self.ended)


def _has_point(ended: str) -> bool:
    return ended == "Solved" or ended in _UNFINISHED


@dataclass(frozen=True, eq=False)
class Found:
    """Clarabel's solution, with the names that cvxpy reads.

    Attributes:
        status: its own status.
        x, z, s: the point, the dual point and the slacks.
        obj_val: the objective at x.
        iterations: how many it took.
        solve_time: s.
    """

    status: str
    x: np.ndarray
    z: np.ndarray
    s: np.ndarray
    obj_val: float
    iterations: int
    solve_time: float


@dataclass(frozen=True)
class Compiled:
    """A problem in the solver's form, for the present values of its parameters.

    Attributes:
        data: the solver's matrices and vectors.
        chain: how cvxpy got there.
        inverse: what it needs for the way back.
    """

    data: dict[str, Any]
    chain: Any
    inverse: Any

    def run(self, data: dict[str, Any], tolerance: float) -> "Found":
        """Clarabel's solution of some data; sides, or costs, that are all far from 1 are scaled.

        Its tolerances are absolute below 1, and its proofs of infeasibility are lost in large
        sides. Cones do not mind: of x / size the sides are b / size, and the objective, over
        size * price, is that of P size / price and c / price.
        """
        size = _scale_of(data["b"])
        price = _scale_of(np.append(data["c"], size * data["P"].data if "P" in data else 0.0))
        scaled = data | {"b": data["b"] / size, "c": data["c"] / price}
        if "P" in data:
            scaled["P"] = data["P"] * (size / price)
        options = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), tolerance)
        options |= {"max_iter": 200, "accept_unknown": True}
        raw = self.chain.solver.solve_via_data(scaled, False, False, options)
        x, z, s = (np.asarray(part) for part in (raw.x, raw.z, raw.s))
        return Found(
            status=str(raw.status),
            x=x * size,
            z=z * price,
            s=s * size,
            obj_val=raw.obj_val * size * price,
            iterations=int(raw.iterations),
            solve_time=raw.solve_time,
        )


def _scale_of(entries: np.ndarray) -> float:
    """A power of 2 near entries that are all large, or all small; 1 for all others.

    Small entries beside large ones would be lost below Clarabel's tolerances.
    """
    sizes = np.abs(entries[np.isfinite(entries) & (entries != 0)])
    if sizes.size and sizes.min() > NEAR:
        return float(2.0 ** np.floor(np.log2(sizes.min())))
    if sizes.size and sizes.max() < 1 / NEAR:
        return float(2.0 ** np.floor(np.log2(sizes.max())))
    return 1.0


def compiled(problem: "cp.Problem") -> Compiled:
    """Bring a problem into the solver's form."""
    import cvxpy as cp

    # Without this option cvxpy hides the point of a run that ended for lack of progress.
    options = {"accept_unknown": True}
    with building():
        return Compiled(*problem.get_problem_data(cp.CLARABEL, solver_opts=options))


def descend(problem: "cp.Problem") -> Descent:
    """The first run that reaches its tolerance, or the last; with the iterations of all."""
    program = compiled(problem)
    iterations = 0
    for tolerance in TOLERANCES:
        raw = program.run(program.data, tolerance)
        iterations += raw.iterations
        ended = _ended(program, raw, tolerance)
        if ended in _FINISHED:
            break
    solution = program.chain.invert(raw, program.inverse)
    proved = None
    if _has_point(ended) and np.isfinite(raw.x).all():
        bound = dual_bound(program.data, raw.x, raw.z, raw.s)
        proved = None if bound is None else float(solution.opt_val - raw.obj_val + bound)
    return Descent(ended, tolerance, solution, proved, iterations)


def _ended(program: Compiled, raw: Found, tolerance: float) -> str:
    """The solver's own status; unbounded only where there is a point to start from."""
    if raw.status != "DualInfeasible":
        return raw.status
    # It found a direction of descent, which says nothing about a point.
    level = {key: part for key, part in program.data.items() if key != "P"}
    level["c"] = np.zeros_like(program.data["c"])
    feasible = program.run(level, tolerance).status
    return {"Solved": raw.status, "PrimalInfeasible": feasible}.get(feasible, "Unsolved")
