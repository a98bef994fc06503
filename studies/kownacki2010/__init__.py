"""Kownacki 2010: Q and R of an accelerometer's and a gyroscope's Kalman filter by optimisation.

Equation and table numbers are the paper's; docs/kownacki2010.md tells what was found.
"""

import hashlib
from functools import partial

import numpy as np

from filters import FixedGainFilter, FixedGains
from studies.kownacki2010.bench import Bench, Settings, benches, noise
from studies.kownacki2010.figures import figures
from studies.kownacki2010.rows import compare
from tuner.certificate.single_precision import SinglePrecision, single_precision
from tuner.certificate.solution import Solution
from tuner.data.logs import Log
from tuner.export.tuned import Quantity
from tuner.problem.problem import Problem
from tuner.run.study import Plan, Source, Study, Target, Task, tuned_values
from tuner.solvers import NelderMead, make_solver

MEANINGS = {
    "Q": "process noise",
    "R": "variance of the measurement",
    "P0": "covariance at the start",
}


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """The paper's procedure on both built-in records, or on the channels of a log.

    Each sensor gives three problems: Q with R as measured, which is well posed; Q and R together,
    as the paper has it ("NAME.paper"); and Q under the literal reading of (10) ("NAME.literal").
    """
    tested = benches(settings, log, seed)
    solvers = [
        (make_solver(name, seed=seed, starts=settings.starts, storage=storage), name)
        for name in settings.solvers
    ]
    posed = [(bench, bench.problem()) for bench in tested]
    problems = [problem for _, problem in posed] + [bench.paper() for bench in tested]
    tasks = [Task(problem, *solver) for problem in problems for solver in solvers]
    # The literal cost has jumps, which no gradient sees.
    simplex = NelderMead(seed=seed, starts=settings.starts)
    tasks += [Task(bench.literal(), simplex, simplex.name) for bench in tested]
    return Plan(
        source=_source(tested[0], log, seed),
        tasks=tuple(tasks),
        targets=tuple(_target(bench, problem) for bench, problem in posed),
        compare=partial(compare, tested, log is None),
        figures=partial(figures, tested),
    )


def _source(bench: Bench, log: Log | None, seed: int) -> Source:
    if log is not None:
        return Source(log.name, log.sha256, log.findings.samples, log.rate_hz)
    digest = hashlib.sha256(bench.record.tobytes()).hexdigest()
    name = f"white noise with Table 1's R, seed {seed}"
    return Source(name, digest, len(bench.record), 1 / bench.dt)


def _target(bench: Bench, problem: Problem) -> Target:
    return Target(
        problem=problem,
        filter=type(bench.filter).__name__,
        states=bench.sensor.states,
        dt=bench.dt,
        quantities=partial(_quantities, bench),
        single=partial(_single, bench),
        meanings=MEANINGS,
    )


def _quantities(bench: Bench, solution: Solution) -> tuple[Quantity, ...]:
    k1, k2, bandwidth = bench.steady(solution.derived["q_over_r"])
    quantities = (
        Quantity("K1", np.array(k1), "1", "steady gain on the measured quantity"),
        Quantity("K2", np.array(k2), "1/s", "steady gain on its derivative"),
    )
    if not np.isfinite(bandwidth):  # a filter that is nearly none has no such frequency
        return quantities
    meaning = "where the response has fallen by 3 dB"
    return (*quantities, Quantity("bandwidth", np.array(bandwidth), "Hz", meaning))


def _single(bench: Bench, solution: Solution) -> tuple[SinglePrecision, ...]:
    parameters = noise(tuned_values(solution))
    k1, k2, _ = bench.steady(solution.derived["q_over_r"])
    fixed = FixedGainFilter(bench.dt, (2,)), FixedGains(np.array(k1), np.array(k2))
    check = partial(single_precision, inputs=bench.signals, scale=bench.settings.step)
    return (
        check("full covariance", bench.filter, parameters),
        check("fixed gain", *fixed),
    )


STUDY = Study(
    name="kownacki2010",
    title="Q and R of an accelerometer's and a gyroscope's Kalman filter by optimisation",
    paper="C. Kownacki, Optimization approach to adapt Kalman filters for the real-time "
    "application of accelerometer and gyroscope signals' filtering, "
    "Digital Signal Processing, 2010",
    settings=Settings,
    channels={"omega": "gyroscope: angular rate", "a": "accelerometer: acceleration"},
    plan=plan,
)
