"""Suh, Park, Kang and Ro 2004: a two-step Kalman filter that distrusts a disturbed accelerometer.

Equation numbers are the paper's; docs/suh2004.md tells what was found.
"""

from functools import partial

import jax
import numpy as np

from studies.suh2004.figures import figures
from studies.suh2004.mixed import Recordings, problems, recordings
from studies.suh2004.paper import DT, STATES, TWO_STEP, Settings, experiment_2, noise
from studies.suh2004.rows import compare
from tuner.certificate.single_precision import Part, SinglePrecision, single_precision
from tuner.certificate.solution import Solution
from tuner.data.logs import Log
from tuner.export.tuned import Quantity
from tuner.problem.problem import Problem
from tuner.run.study import Plan, Source, Study, Target, Task, tuned_values
from tuner.solvers import Alternating, Gradient, NelderMead

HELD_OUT = 1000
"""Seeds of held-out records lie this far above those that are tuned on."""
SCALE = float(np.radians(15.0))
"""Size of the angles that the single-precision check goes by, rad."""

MEANINGS = {
    "q1": "spectral density of the angular acceleration",
    "r_nom": "variance of the accelerometers at rest",
    "r_big": "variance of disturbed accelerometers",
    "alpha1": "share of r that stays from sample to sample",
    "alpha2": "what a residual of 1 g adds to r",
    "delta": "by how much the squared acceleration may differ from g^2 at rest",
}


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """All three filters tuned on the same records by the same means, judged on others."""
    tuned_on = recordings(settings, settings.train, seed)
    if settings.tune_on == "experiment2":
        inputs = experiment_2(settings.gyro_unit)
        still = jax.numpy.zeros((len(inputs.gyr), 1, 2))
        tuned_on = Recordings(jax.tree.map(lambda leaf: leaf[:, None], inputs), still)
    judged_on = recordings(settings, settings.held_out, seed + HELD_OUT)
    posed = problems(tuned_on)
    alternating = Alternating(seed=seed, starts=settings.starts)
    smooth = Gradient("l-bfgs-b", seed=seed, starts=settings.starts)
    simplex = NelderMead(seed=seed, starts=1, tolerance=1e-4)
    return Plan(
        source=_source(settings, tuned_on, seed),
        tasks=(
            Task(posed["standard"], smooth, smooth.name),
            Task(posed["simple"], alternating, alternating.name),
            Task(posed["two_step"], alternating, alternating.name),
            Task(posed["two_step"], simplex, simplex.name),
        ),
        targets=(_target(posed["two_step"], judged_on),),
        compare=partial(compare, settings, judged_on),
        figures=partial(figures, settings, judged_on),
    )


def _source(settings: Settings, tuned_on: Recordings, seed: int) -> Source:
    name = f"{tuned_on.count} simulated motions with pushes and bias, seeds from {seed}"
    return Source.simulated(name, [np.asarray(tuned_on.inputs.acc)], 1 / DT)


def _target(problem: Problem, judged_on: Recordings) -> Target:
    return Target(
        problem=problem,
        filter="TiltKalman",
        states=STATES,
        dt=DT,
        quantities=_quantities,
        single=partial(_single, judged_on),
        meanings=MEANINGS,
    )


def _quantities(solution: Solution) -> tuple[Quantity, ...]:
    return (Quantity("r3", np.array(1.0), "(rad/s)^2", "variance of the gyroscopes, held at 1"),)


def _single(judged_on: Recordings, solution: Solution) -> tuple[SinglePrecision, ...]:
    inputs = jax.tree.map(lambda leaf: leaf[:, 0], judged_on.inputs)
    parameters = noise(tuned_values(solution))
    return (
        single_precision("covariance", Part(TWO_STEP, "angles"), parameters, inputs, scale=SCALE),
    )


STUDY = Study(
    name="suh2004",
    title="Roll and pitch under external acceleration: a two-step Kalman filter, tuned",
    paper="Y.-S. Suh, S.-K. Park, H.-J. Kang and Y.-S. Ro, Attitude Estimation Adaptively "
    "Compensating External Acceleration, received 2004",
    settings=Settings,
    channels={},
    plan=plan,
)
