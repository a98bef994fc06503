"""Solvers: different methods on the same Problem, each returning a certified Solution."""

from tuner.names import unknown
from tuner.solvers.alternating import Alternating
from tuner.solvers.convex import Convex
from tuner.solvers.gradient import Gradient
from tuner.solvers.ipopt import Ipopt
from tuner.solvers.known import Known
from tuner.solvers.nelder_mead import NelderMead
from tuner.solvers.sampling import Sampler
from tuner.solvers.simplex import fminsearch, nelder_mead
from tuner.solvers.solver import Solver

SOLVERS = {
    "nelder-mead": "simplex search, no gradient; fminsearch's moves, tolerances made for z",
    "l-bfgs-b": "quasi-Newton with bounds on exact gradients (scipy)",
    "trust-constr": "Newton in a trust region on exact gradients (scipy)",
    "alternating": "gradients for what is smooth, simplex search for thresholds, in turn",
    "ipopt": "interior point with constraints (CasADi): symbolic, or calling back into JAX",
    "cma-es": "covariance matrix adaptation (Optuna), trials kept in a database",
    "tpe": "tree-structured Parzen estimator (Optuna), trials kept in a database",
}
"""The class of each solver of a :class:`Problem`, by name."""
CONVEX = {
    "lp": "linear programs (CVXPY, Clarabel), proved by their dual",
    "sdp": "convex programs with matrix inequalities (CVXPY, Clarabel), proved by their dual",
}
"""The class of each solver of a convex program, by name."""


def make_solver(name: str, *, seed: int, starts: int, storage: str) -> Solver:
    """A solver by name.

    Args:
        name: one of :data:`SOLVERS`.
        seed: where its random numbers come from.
        starts: how many starts a descent makes; samplers draw all over the box anyway.
        storage: database URL for the samplers; "" for a temporary one.

    Raises:
        ValueError: for an unknown name, with the near ones.
    """
    match name:
        case "nelder-mead":
            return NelderMead(seed=seed, starts=starts)
        case "l-bfgs-b" | "trust-constr":
            return Gradient(name, seed=seed, starts=starts)
        case "alternating":
            return Alternating(seed=seed, starts=starts)
        case "ipopt":
            return Ipopt(seed=seed, starts=starts)
        case "cma-es" | "tpe":
            return Sampler(name, seed=seed, storage=storage)
    raise unknown("solver", name, SOLVERS)


__all__ = [
    "CONVEX",
    "SOLVERS",
    "Alternating",
    "Convex",
    "Gradient",
    "Ipopt",
    "Known",
    "NelderMead",
    "Sampler",
    "Solver",
    "fminsearch",
    "make_solver",
    "nelder_mead",
]
