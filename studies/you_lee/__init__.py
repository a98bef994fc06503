"""You and Lee: a mixing filter for roll and pitch, and a velocity filter that aids it in turns.

Equation numbers are the paper's; docs/you_lee.md tells what was found.
"""

from functools import partial

import jax
import numpy as np

from filters import PiComplementary
from studies.you_lee.cases import Bench, deterministic, gains, start_velocity
from studies.you_lee.checks import refuse
from studies.you_lee.figures import figures
from studies.you_lee.rows import compare
from studies.you_lee.settings import GRAVITY, Settings
from studies.you_lee.tuning import AIDS, problems, with_gains
from tuner.certificate.single_precision import Part, SinglePrecision, single_precision
from tuner.certificate.solution import Solution
from tuner.data.logs import Log
from tuner.export.tuned import Quantity
from tuner.problem.problem import Problem
from tuner.run.study import Plan, Source, Study, Target, Task, tuned_values
from tuner.solvers import Gradient

SCALE = float(np.radians(30.0))
"""Size of the angles that the single-precision check goes by, rad."""
MEANINGS = {
    "K1": "how fast the angles follow the accelerometers",
    "K2": "K1 K2 is how fast the gyroscopes' bias is taken off",
    "tau": "time constant of both poles",
    "omega": "natural frequency of the poles",
    "zeta": "damping of the poles",
    "damping": "of the filter's poles",
    "natural_frequency": "of the filter's poles",
    "Q_k": "variance that enters each component of the velocity in a sample",
    "R_k": "variance of the airspeed",
    "P0": "variance of each component of the velocity at the start",
    "threshold": "the velocity filter runs where the length of the rates is above it",
    "x0": "(u, v, w) at the start",
    "gravity": "the length of gravity",
}
UNITS = {"K1": "1/s", "K2": "1/s", "damping": "", "natural_frequency": "rad/s"}
HELD = {"R_k": "(ft/s)^2", "P0": "(ft/s)^2", "threshold": "rad/s"}
"""What the velocity filter takes that is not tuned, with its unit."""


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """All problems tuned on the same runs by the same means, judged on others."""
    bench = Bench(settings, seed)
    posed = problems(bench)
    solver = Gradient("l-bfgs-b", seed=seed, starts=settings.starts)
    inputs = posed["free"].data.inputs
    refuse(bench)
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
        filter="PiComplementary",
        states=("roll", "pitch"),
        dt=bench.settings.dt,
        quantities=partial(_quantities, bench),
        single=partial(_single, bench),
        meanings=MEANINGS,
    )


def _quantities(bench: Bench, solution: Solution) -> tuple[Quantity, ...]:
    """What the gains stand for, and what else the filter takes."""
    settings = bench.settings
    known = [(name, np.array(solution.derived[name]), unit) for name, unit in UNITS.items()]
    known.append(("gravity", np.array(GRAVITY), "ft/s^2"))
    if AIDS[solution.problem] == "velocity":
        known += [(name, np.array(getattr(settings, name)), unit) for name, unit in HELD.items()]
        flight = bench.flights[settings.trajectory]
        known.append(("x0", np.array(start_velocity(flight, settings.start)), "ft/s"))
    return tuple(
        Quantity(name, value, unit, MEANINGS[name])
        for name, value, unit in known
        if name not in solution.parameters
    )


def _single(bench: Bench, solution: Solution) -> tuple[SinglePrecision, ...]:
    """On the flight with table 1's deviations as constant errors."""
    settings = bench.settings
    flight, aid = bench.flights[settings.trajectory], AIDS[solution.problem]
    inputs = jax.tree.map(lambda leaf: leaf[:, 0], deterministic(settings, flight, (0, 1, 2, 3, 4)))
    params = gains(settings, flight, settings.start, with_gains(tuned_values(solution)))
    form = "mixing" if aid == "airspeed" else "mixing with velocity"
    filter = Part(PiComplementary(settings.dt, aid), "angles")
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
