"""Small problems with known optima, and a study of them for the engine and the command line."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import jax.numpy as jnp
import numpy as np
from pydantic import BaseModel, ConfigDict

from filters import LocalLevel
from filters.declared import Channel
from objectives import Data
from tuner.data.source import Source
from tuner.export.tuned import Quantity
from tuner.problem.exported import Exported
from tuner.problem.parameters import Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.run.comparison import claim, number
from tuner.run.figure import Chart, Line
from tuner.run.study import Claim, Plan, Study, Task, best
from tuner.solvers import make_solver


@dataclass(frozen=True)
class OwnLevel:
    """A level's filter of a user's own, which says nothing of its model."""

    dt: float
    params, inputs, outputs = LocalLevel.params, LocalLevel.inputs, LocalLevel.outputs

    def init(self, params):
        return LocalLevel(self.dt).init(params)

    def step(self, params, state, inputs):
        return LocalLevel(self.dt).step(params, state, inputs)


@dataclass(frozen=True)
class Echo:
    """A filter that outputs its parameters, whatever goes in."""

    def init(self, params):
        return ()

    def step(self, params, state, inputs):
        return state, params


# Objectives of z = (ln a, ln b); all but the first have their lowest value, 1, at a known point.


def hollow(outputs, truth):
    """Not a number anywhere."""
    return jnp.nan * outputs[-1].sum()


def bowl(outputs, truth):
    """A quadratic: lowest at (1, -1), with the Hessian [2, 0.6; 0.6, 1]."""
    x, y = outputs[-1] - jnp.array([1.0, -1.0])
    return 1.0 + x**2 + 0.5 * y**2 + 0.6 * x * y


def valley(outputs, truth):
    """Rosenbrock's function: lowest at (1, 1)."""
    x, y = outputs[-1]
    return 1.0 + (1 - x) ** 2 + 100 * (y - x**2) ** 2


def slope(outputs, truth):
    """Falls towards the lower bound of ln a, which is -3: lowest at (-3, -1)."""
    x, y = outputs[-1]
    return 1.0 + 0.3 * (x + 3) + (y + 1) ** 2


def kink(outputs, truth):
    """Lowest at (1, -1), where it has no gradient."""
    x, y = outputs[-1] - jnp.array([1.0, -1.0])
    return 1.0 + jnp.abs(x) + jnp.abs(y)


def crater(outputs, truth):
    """The bowl, but not a number near the initial point (0, 0)."""
    return jnp.where(jnp.abs(outputs[-1]).max() < 0.5, jnp.nan, bowl(outputs, truth))


def trench(outputs, truth):
    """Depends on ln b - 2 ln a alone."""
    x, y = outputs[-1]
    return 1.0 + (y - 2 * x - 1.0) ** 2


def plain(outputs, truth):
    """The same everywhere."""
    return 1.0 + 0.0 * outputs[-1].sum()


def logarithms(values):
    """The outputs of Echo: (ln a, ln b)."""
    return jnp.log(jnp.stack([values["a"], values["b"]]))


SQUARE = Space.of(
    a=Positive(1.0, low=np.exp(-3), high=np.exp(3), unit="m", meaning="the first"),
    b=Positive(1.0, low=np.exp(-3), high=np.exp(3)),
)
ANY = Data(np.zeros(2), np.zeros(2))


def problem(objective: Callable, *, name: str = "", space: Space = SQUARE) -> Problem:
    """An objective of (ln a, ln b), -3 to 3 each, from (0, 0)."""
    return Problem(name or objective.__name__, space, Echo(), logarithms, objective, ANY, ratio)


def ratio(values):
    return {"b_over_a": values["b"] / values["a"]}


# A study of the bowl that is solved in milliseconds.


class ToySettings(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    solvers: tuple[str, ...] = ("nelder-mead", "l-bfgs-b")
    starts: int = 2
    objective: str = "bowl"
    note: str | None = None


NO_DATA = Source("nothing", "0" * 64, 2, 100.0)


def toy_plan(settings, records, seed, storage, *, solver=make_solver):
    objective = {"bowl": bowl, "slope": slope, "hollow": hollow}[settings.objective]
    main = replace(problem(objective, name="toy"), exported=TOY_EXPORTED)
    side = problem(trench, name="side")
    tasks = tuple(
        Task(posed, solver(name, seed=seed, starts=settings.starts, storage=storage))
        for posed in (main, side)
        for name in settings.solvers
    )
    (source,) = [s for record in records for s in record.sources] or [NO_DATA]
    return Plan(
        source=source,
        tasks=tasks,
        exports=("toy",),
        case="a curve",
        claims=() if records else TOY_CLAIMS,
        figures=toy_figures,
    )


def toy_quantities(params):
    """From what the filter takes, (ln a, ln b)."""
    return (Quantity("gain", np.exp(params[1] - params[0]), "1", "b over a"),)


TOY_EXPORTED = Exported("Echo", ("x",), 0.01, toy_quantities)


def toy_ratio(case, solutions):
    ours = best("toy", solutions).derived["b_over_a"]
    return number("toy.b_over_a", "Table 1", np.exp(-2.0), ours, tolerance=0.05)


def toy_lowest(case, solutions):
    ours = best("toy", solutions).value
    return number("toy.lowest", "equation (1)", 1.25, ours, tolerance=0.05, unit="m")


def toy_known(case, solutions):
    return claim("toy.known", "section 2", True, ours=None, note="a row | in words")


TOY_CLAIMS = (
    Claim("toy.b_over_a", toy_ratio, ("toy",)),
    Claim("toy.lowest", toy_lowest, ("toy",)),
    Claim("toy.known", toy_known),
)


def toy_figures(case, solutions):
    x = np.arange(3.0)
    yield Chart("curve", case, "x", "y", (Line("line", x, x**2),))


@dataclass(frozen=True)
class Solved:
    """A solver of one's own: a function of the problem, under a name."""

    name: str
    solve: Callable

    def __call__(self, problem):
        return self.solve(problem)


def toy_study(**changed):
    """The study; ``solver`` makes its solvers in place of make_solver."""
    return Study(
        name="toy",
        title="A bowl",
        paper="none",
        settings=ToySettings,
        channels=lambda settings: {"x": Channel("unit", "anything")},
        plan=partial(toy_plan, **changed),
    )


# Files.


def snapshot(folder: Path) -> dict[str, bytes | None]:
    """Every file below a folder with its bytes, and every folder."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.rglob("*"))
    }


def write_csv(path: Path, time, values, *, header: str = "t,g") -> Path:
    rows = [f"{float(t)!r},{float(v)!r}" for t, v in zip(time, values, strict=True)]
    path.write_text("\n".join([header, *rows]) + "\n")
    return path
