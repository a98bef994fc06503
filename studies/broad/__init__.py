"""BROAD: inclination of a moving inertial sensor, on real recordings with optical truth.

The benchmark is that of Laidig, Caruso, Cereatti and Seel, Data 6(7):72, 2021; its files stay where
the user has them. docs/broad.md tells what was found.
"""

import hashlib
from dataclasses import replace
from functools import partial
from typing import Any, get_args

import numpy as np
from pydantic import Field

from studies.broad.contest import Contest
from studies.broad.contestants import SPEED, Contestant, takes_field
from studies.broad.figures import figures
from studies.broad.rows import compare, fold_name
from studies.broad.trials import AccUnit, GyrUnit, Trial, halved, read
from tuner.certificate.solution import Solution
from tuner.data.logs import Log
from tuner.export.tuned import Quantity
from tuner.problem.problem import Problem
from tuner.run.settings import StudySettings
from tuner.run.study import Plan, Source, Study, Target, Task
from tuner.solvers import Alternating, Gradient

ROOM_STATES = (
    *(f"turn_{axis}" for axis in "xyz"),
    *(f"bias_{axis}" for axis in "xyz"),
    *(f"speed_{axis}" for axis in "xyz"),
    *(f"place_{axis}" for axis in "xyz"),
    *(f"matrix_{row}{column}" for row in "xyz" for column in "xyz"),
)
ENOUGH = 3e-4
"""Slope of ln error at which a search may end: a tenth of a factor e more changes nothing."""


class Settings(StudySettings):
    """Where the recordings are, and what is tuned on them."""

    folder: str = Field("", description="folder of the benchmark's .mat files")
    acc_unit: AccUnit = Field("m/s^2", description="unit of imu_acc")
    gyr_unit: GyrUnit = Field("rad/s", description="unit of imu_gyr")
    contestants: tuple[Contestant, ...] | None = Field(
        None,
        description="filters that are tuned on all trials; the room filter always is; unset: all "
        "that the trials allow",
    )
    folds: int | None = Field(
        None, ge=0, description="trials to leave out in turn, the first so many; all if unset"
    )
    seconds: float | None = Field(None, gt=0, description="only so much of each trial, s")


MEANINGS = {
    "place": "of the measurement that the sensor stays where it is",
    "accelerometer": "of the white noise of the accelerometers",
    "turning": "of the gyroscopes' noise in proportion to the rate",
    "bias": "of the drift of the gyroscopes' bias",
    "matrix0": "deviation of the gyroscopes' scales and misalignments at the start",
    "lead": "how far ahead of the last sample the attitude is wanted",
}


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """Every filter tuned on all trials; the room filter also without each of them in turn.

    Those folds are tuned at half the sample rate, in half the time, and judged at the whole one.
    """
    trials = read(settings.folder, settings.acc_unit, settings.gyr_unit, settings.seconds)
    contest = Contest(tuple(trials), whole=settings.seconds is None)
    tuned = _contestants(settings, trials)
    count = len(trials) if settings.folds is None else min(settings.folds, len(trials))
    folds = range(count if len(trials) > 1 else 0)
    gradient = Gradient("l-bfgs-b", seed=seed, starts=1, gradient=ENOUGH, iterations=40)
    quick = replace(gradient, curvature=False)
    alternating = Alternating(
        seed=seed, starts=1, rounds=2, progress=1e-3, gradient=ENOUGH, iterations=40
    )
    tasks = []
    posed = {name: contest.problem(name, name) for name in tuned}
    for name, each in posed.items():
        solver = alternating if name == "two_step" else gradient if name == "room" else quick
        tasks.append(Task(each, solver, solver.name))
    for at in folds:
        others = contest.of([halved(trial) for i, trial in enumerate(trials) if i != at])
        tasks.append(Task(others.problem(fold_name(trials[at]), "room"), quick, quick.name))
    tasks += _transfer(contest, quick)
    return Plan(
        source=_source(trials),
        tasks=tuple(tasks),
        targets=(_target(posed["room"], contest.rate_hz),),
        compare=partial(compare, contest, folds, tuned),
        figures=partial(figures, contest, folds, tuned),
    )


def _contestants(settings: Settings, trials: list[Trial]) -> tuple[str, ...]:
    """The filters to tune: those that are asked for, or all that the trials allow."""
    silent = [trial.name for trial in trials if trial.start is None]
    if settings.contestants is None:
        return tuple(name for name in get_args(Contestant) if not (silent and takes_field(name)))
    asked = [name for name in settings.contestants if takes_field(name)]
    if asked and silent:
        raise ValueError(
            f"{' and '.join(asked)} need a magnetic field (imu_mag) before the movement, and "
            f"{', '.join(silent)} has none; leave them out of contestants"
        )
    return tuple(dict.fromkeys(("room", *settings.contestants)))


def _transfer(contest: Contest, gradient: Gradient) -> list[Task]:
    calm = [trial for trial in contest.trials if not trial.disturbed]
    if not calm or len(calm) == len(contest.trials):
        return []
    posed = contest.of([halved(trial) for trial in calm]).problem("undisturbed", "room")
    return [Task(posed, gradient, gradient.name)]


def _source(trials: list[Trial]) -> Source:
    digest = hashlib.sha256("".join(trial.sha256 for trial in trials).encode()).hexdigest()
    samples = sum(len(trial.rate) for trial in trials)
    return Source(f"{len(trials)} trials of BROAD", digest, samples, trials[0].rate_hz)


def _target(posed: Problem, rate_hz: float) -> Target:
    return Target(
        problem=posed,
        filter="BoundedMotionKalman",
        states=ROOM_STATES,
        dt=1 / rate_hz,
        quantities=_quantities,
        single=lambda _: (),
        meanings=MEANINGS,
    )


def _quantities(solution: Solution) -> tuple[Quantity, ...]:
    fixed: dict[str, tuple[Any, str, str]] = {
        "speed": (SPEED, "m/s^0.5", "of the measurement that the sensor stands still, held"),
        "bias0": (0.02, "rad/s", "deviation of the gyroscopes' bias at the start"),
        "tilt0": (0.03, "rad", "deviation of the attitude at the start"),
    }
    return tuple(
        Quantity(name, np.array(value), unit, meaning)
        for name, (value, unit, meaning) in fixed.items()
    )


STUDY = Study(
    name="broad",
    title="Inclination of a moving inertial sensor, on the BROAD recordings",
    paper="D. Laidig, M. Caruso, A. Cereatti and T. Seel, BROAD - A Benchmark for Robust Inertial "
    "Orientation Estimation, Data 6(7):72, 2021",
    settings=Settings,
    channels={},
    plan=plan,
)
