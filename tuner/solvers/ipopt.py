"""IPOPT through CasADi: smooth problems with constraints, to the last digits."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Any, Literal, get_args

import jax.numpy as jnp
import numpy as np

from objectives import kind_of
from tuner.certificate.solution import Solution
from tuner.code.casadi import expressions
from tuner.code.refused import NoCounterpartError
from tuner.names import unknown
from tuner.problem.problem import Problem
from tuner.solvers.foreign import python_function
from tuner.solvers.minimum import Descent, Minimum, best_of
from tuner.solvers.multistart import from_several, refuse
from tuner.solvers.starts import SharedStarts
from tuner.solvers.widening import widen

if TYPE_CHECKING:
    import casadi

Model = Literal["either", "symbolic", "callback"]


@dataclass(frozen=True)
class Ipopt:
    """Interior point method for problems with constraints, from several starts.

    Source: Wachter and Biegler, Mathematical Programming 106, 2006. Where a solution is held by
    its search box, the box is widened to find out whether there is an optimum at all.

    Attributes:
        seed: where the random starts come from.
        starts: how many starts.
        model: symbolic (the problem translated to CasADi, with exact second derivatives),
            callback (values and gradients from JAX, second derivatives learnt on the way), or
            either: symbolic wherever every operation has its counterpart.
        tolerance: of IPOPT's own test, on the problem scaled to 1 at the start.
        iterations: limit for each start.
        shared: where other processes make some of the descents; None: all are made here.
    """

    seed: int
    starts: int = 4
    model: Model = "either"
    tolerance: float = 1e-10
    iterations: int = 500
    shared: SharedStarts | None = field(default=None, repr=False)

    name: str = "ipopt"

    def __post_init__(self) -> None:
        if self.model not in get_args(Model):
            raise unknown("model", self.model, get_args(Model))

    def help(self, problem: Problem) -> int:
        """Make those descents of a shared search that nobody has begun; returns how many.

        Those in wider boxes are made by whoever finds that they are needed.
        """
        if self.shared is None:
            return 0
        return self.shared.help(problem, self._descent(), self.starts, self.seed)

    def check(self, problem: Problem) -> None:
        """Refuse what cannot begin; see :func:`tuner.solvers.multistart.refuse`."""
        refuse(problem, self.name, self.starts, "start", constrained=True, smooth=True)

    def __call__(self, problem: Problem) -> Solution:
        """Solve a problem."""
        return widen(problem, self._solve)

    def _solve(self, problem: Problem) -> Solution:
        return from_several(
            problem,
            self.name,
            self._descent(),
            starts=self.starts,
            seed=self.seed,
            constrained=True,
            smooth=True,
            shared=self.shared,
            threads=1,  # it holds the interpreter's lock, and its linear solver is for one thread
        )

    def _descent(self) -> Descent:
        """A descent, which states its problem to CasADi once, where one is made at all."""
        statement = cache(_statement)

        def descend(problem: Problem, z: np.ndarray) -> Minimum:
            stated = statement(problem, self.model)
            return _descend(problem, z, stated, self.tolerance, self.iterations)

        return descend


@dataclass(frozen=True)
class _Statement:
    """A problem as CasADi takes it.

    Attributes:
        x, f, g: the point, and value and excesses as expressions of it.
        hessian: of the Lagrangian, where CasADi does not work it out itself.
        keep: what must live as long as the expressions.
    """

    x: "casadi.SX | casadi.MX"
    f: "casadi.SX | casadi.MX"
    g: "casadi.SX | casadi.MX"
    hessian: "Callable[[float], casadi.Function] | None" = None
    keep: tuple[Any, ...] = ()


def _statement(problem: Problem, model: Model) -> _Statement:
    if model != "callback":
        try:
            return _symbolic(problem)
        except NoCounterpartError as error:
            if model == "symbolic":
                raise ValueError(
                    f"{problem.name} cannot be written symbolically: {error}; use model='callback'"
                ) from None
    return _callback(problem)


def _symbolic(problem: Problem) -> _Statement:
    import casadi

    symbols = [casadi.SX.sym(f"z{i}") for i in range(problem.space.size)]
    static, data = problem.static, problem.data
    found = expressions(
        lambda z: jnp.append(static.score(z, data), static.excesses(z, data)), symbols
    )
    return _Statement(casadi.vertcat(*symbols), found[0], casadi.vertcat(*found[1:]))


def _callback(problem: Problem) -> _Statement:
    import casadi

    size, count = problem.space.size, len(problem.constraints)
    x = casadi.MX.sym("z", size)

    def curvature(scale: float) -> "casadi.Function":
        def evaluate(z: np.ndarray, _: np.ndarray, f: np.ndarray, g: np.ndarray) -> np.ndarray:
            hessian = f[0] / scale * problem.hessian(z)
            return np.triu(hessian + problem.constraint_hessian(z, g) if count else hessian)

        upper = casadi.Sparsity.upper(size)
        return python_function("hessian", [size, 0, 1, count], upper, evaluate)

    value = python_function(
        "value",
        [size],
        casadi.Sparsity.dense(1, 1),
        problem.value,
        lambda z, _: problem.value_and_gradient(z)[1][None],
    )
    if not count:
        return _Statement(x, value(x), casadi.MX(0, 1), curvature, (value,))
    excess = python_function(
        "excess",
        [size],
        casadi.Sparsity.dense(count, 1),
        lambda z: problem.excesses(z)[0],
        lambda z, _: problem.excesses(z)[1],
    )
    return _Statement(x, value(x), excess(x), curvature, (value, excess))


def _descend(
    problem: Problem, z: np.ndarray, statement: _Statement, tolerance: float, iterations: int
) -> Minimum:
    """IPOPT on value / |value at the start|, and again where that has changed by much.

    Its tolerances suit values near 1; a start far away leaves digits to be found.
    """
    begun, least = problem.value(z), 1.0 if kind_of(problem.objective) == "likelihood" else 0.0
    if not np.isfinite(begun):
        return Minimum(z, begun, 1, False, "the objective at the start is not usable")
    begin = max(abs(begun), least) or 1.0
    ends = [_once(problem, z, begin, statement, tolerance, iterations)]
    reached = max(abs(ends[0].value), least)
    if ends[0].allowed and 0 < reached < REFINED * begin:
        ends.append(_once(problem, ends[0].z, reached, statement, tolerance, iterations))
    evaluations = 1 + sum(end.evaluations for end in ends)
    broken = problem.constraints and not all(end.finished for end in ends)
    if broken or best_of(ends).value - begun > WORSE * abs(begun):
        # Where it breaks off, or follows derivatives of steps, it may lose what it started from.
        excess = float(problem.excesses(z)[0].max(initial=-np.inf))
        ends.append(Minimum(z, begun, 0, ends[-1].finished, ends[-1].message, excess))
    return replace(best_of(ends), evaluations=evaluations)


WORSE = 1e-9
"""An end that is worse than its start by more than this share is not where the value is least."""
REFINED = 0.1
"""A value below this share of that at the start is worth a second run with its own scale."""


def _once(
    problem: Problem,
    z: np.ndarray,
    scale: float,
    statement: _Statement,
    tolerance: float,
    iterations: int,
) -> Minimum:
    import casadi

    options: dict[str, Any] = {
        "print_time": False,
        "show_eval_warnings": False,  # a point where the objective is not a number is stepped over
        "ipopt": {
            "tol": tolerance,
            "max_iter": iterations,
            "print_level": 0,
            "sb": "yes",
            "bound_relax_factor": 0.0,
        },
    }
    if statement.hessian is not None:
        options["hess_lag"] = statement.hessian(scale)
    stated: dict[str, Any] = {"x": statement.x, "f": statement.f / scale, "g": statement.g}
    solver = casadi.nlpsol("tuner", "ipopt", stated, options)
    low, high = problem.space.box()
    found = solver(x0=z, lbx=low, ubx=high, lbg=-np.inf, ubg=0.0)
    point = np.clip(found["x"].full().ravel(), low, high)
    stats = solver.stats()
    return Minimum(
        z=point,
        value=problem.value(point),
        evaluations=_evaluations(stats, problem, numeric=statement.hessian is not None),
        finished=bool(stats["success"]),
        message=f"ipopt: {stats['return_status'].replace('_', ' ').lower()}",
        excess=float(problem.excesses(point)[0].max(initial=-np.inf)),
    )


def _evaluations(stats: dict[str, Any], problem: Problem, *, numeric: bool) -> int:
    """How often values and gradients were asked for; second derivatives by differences count."""
    values, gradients, hessians = (
        int(stats.get(f"n_call_nlp_{name}", 0)) for name in ("f", "grad_f", "hess_l")
    )
    # CasADi's gradient brings the value along; the last value is looked at once more.
    return values + 2 * gradients + (2 * problem.space.size * hessians if numeric else 0) + 1
