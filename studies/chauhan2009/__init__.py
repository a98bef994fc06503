"""Chauhan, Patil, Sinha and Halder 2009: a process noise that follows the filter's own residuals.

Equation numbers are the paper's; docs/chauhan2009.md tells what was found.
"""

from functools import partial

import numpy as np

from studies.chauhan2009.figures import figures
from studies.chauhan2009.laws import STATES, problems
from studies.chauhan2009.rows import compare
from studies.chauhan2009.steps import DT, Settings
from studies.chauhan2009.sweep import Sweep
from tuner.certificate.solution import Solution
from tuner.data.logs import Log
from tuner.export.tuned import Quantity
from tuner.problem.problem import Problem
from tuner.run.study import Plan, Source, Study, Target, Task
from tuner.solvers import NelderMead

MEANINGS = {
    "angle": "deviation of the measured angles",
    "floor": "least spectral density of each state's noise",
    "h": "level of membership of the regression",
    "quaternion": "spectral density of the quaternion's noise",
    "bias": "spectral density of the gyroscopes' bias",
}


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """Every law tuned on the same steps by the same means, judged on others; and the sweep."""
    posed = problems(settings, seed)
    # The fuzzy law takes the largest of many lines, so its cost has kinks.
    simplex = NelderMead(seed=seed, starts=settings.starts, tolerance=1e-3)
    sweep = Sweep(settings, seed)
    chosen = [posed["constant"], posed[f"fuzzy_{settings.windows[-1]}"]]
    return Plan(
        source=_source(posed["constant"]),
        tasks=tuple(Task(problem, simplex, simplex.name) for problem in posed.values()),
        targets=tuple(_target(problem, settings) for problem in chosen),
        compare=partial(compare, settings, seed, sweep),
        figures=partial(figures, settings, seed, sweep),
    )


def _source(problem: Problem) -> Source:
    made = np.asarray(problem.data.inputs.gyr)
    return Source.simulated(f"{made.shape[1]} simulated pitch steps", [made], 1 / DT)


def _target(problem: Problem, settings: Settings) -> Target:
    return Target(
        problem=problem,
        filter="GpsAidedKalman",
        states=STATES,
        dt=DT,
        quantities=partial(_quantities, settings),
        single=lambda _: (),
        meanings=MEANINGS,
    )


def _quantities(settings: Settings, solution: Solution) -> tuple[Quantity, ...]:
    if "angle" in solution.parameters:
        return ()
    return (Quantity("angle", np.array(settings.noise), "deg", "noise of the angles, held"),)


STUDY = Study(
    name="chauhan2009",
    title="Attitude from gyroscopes and GPS with a fuzzy process noise, against tuned constants",
    paper="S. Chauhan, C. Patil, M. Sinha and A. Halder, Fuzzy state noise-driven Kalman filter "
    "for sensor fusion, Proc. IMechE Part G: J. Aerospace Engineering 223, 2009",
    settings=Settings,
    channels={},
    plan=plan,
)
