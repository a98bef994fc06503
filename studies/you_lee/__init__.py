"""You and Lee: a mixing filter for roll and pitch, and a velocity filter that aids it in turns.

Equation numbers are the paper's; docs/you_lee.md tells what was found.
"""

from functools import partial

import jax
import numpy as np

from filters import MixingFilter
from studies.you_lee.cases import Bench, deterministic, gains
from studies.you_lee.checks import refuse
from studies.you_lee.figures import figures
from studies.you_lee.rows import compare
from studies.you_lee.settings import Settings
from studies.you_lee.tuning import AIDS, problems, with_gains
from tuner.export.tuned import Quantity
from tuner.logs import Log
from tuner.problem import Problem
from tuner.single import Part, SinglePrecision, single_precision
from tuner.solution import Solution
from tuner.solvers import Gradient
from tuner.study import Plan, Source, Study, Target, Task, tuned_values

SCALE = float(np.radians(30.0))
"""Size of the angles that the single-precision check goes by, rad."""
MEANINGS = {
    "K1": ("1/s", "how fast the angles follow the accelerometers"),
    "K2": ("1/s", "K1 K2 is how fast the bias is taken off"),
    "damping": ("", "of the filter's poles"),
    "natural_frequency": ("rad/s", "of the filter's poles"),
}


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """All problems tuned on the same runs by the same means, judged on others."""
    bench = Bench(settings, seed)
    posed = problems(bench)
    solver = Gradient("l-bfgs-b", seed=seed, starts=settings.starts)
    inputs = posed["free"].data.inputs
    refuse(bench, inputs)
    name = f"{settings.train} simulated flights on {settings.trajectory}, seeds from {seed}"
    return Plan(
        source=Source.simulated(name, [np.asarray(leaf) for leaf in inputs], settings.rate_hz),
        tasks=tuple(Task(problem, solver, solver.name) for problem in posed.values()),
        targets=tuple(_target(bench, problem) for problem in posed.values()),
        compare=partial(compare, bench),
        figures=partial(figures, bench),
    )


def _target(bench: Bench, problem: Problem) -> Target:
    return Target(
        problem=problem,
        filter="MixingFilter",
        states=("roll", "pitch"),
        dt=bench.settings.dt,
        quantities=partial(_quantities, bench.settings),
        single=partial(_single, bench),
    )


def _quantities(settings: Settings, solution: Solution) -> tuple[Quantity, ...]:
    found = [
        Quantity(name, np.array(solution.derived[name]), *words)
        for name, words in MEANINGS.items()
        if name not in solution.parameters
    ]
    if AIDS[solution.problem] == "velocity":
        words = ("R_k", "(ft/s)^2", "variance of the airspeed"), ("threshold", "rad/s", "switch")
        found += [Quantity(n, np.array(getattr(settings, n)), u, m) for n, u, m in words]
    return tuple(found)


def _single(bench: Bench, solution: Solution) -> tuple[SinglePrecision, ...]:
    """On the flight with table 1's deviations as constant errors."""
    settings = bench.settings
    flight, aid = bench.flights[settings.trajectory], AIDS[solution.problem]
    inputs = jax.tree.map(lambda leaf: leaf[:, 0], deterministic(settings, flight, (0, 1, 2, 3, 4)))
    params = gains(settings, flight, settings.start, with_gains(tuned_values(solution)))
    form = "mixing" if aid == "airspeed" else "mixing with velocity"
    filter = Part(MixingFilter(settings.dt, aid), "angles")
    return (single_precision(form, filter, params, inputs, scale=SCALE),)


STUDY = Study(
    name="you_lee",
    title="Roll and pitch in a turn: a mixing filter aided by airspeed or velocity, tuned",
    paper="J. J. You and J. G. Lee, An accelerometer Aided Mixing Algorithm for Strapdown "
    "Attitude (Roll, Pitch) Reference System (in Korean)",
    settings=Settings,
    channels={},
    plan=plan,
)
