"""The tuning problems, their trials, and their solvers."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import get_args

from studies.broad.contest import Contest, end
from studies.broad.contestants import Contestant, takes_field
from studies.broad.settings import Settings
from studies.broad.trials import Trial, halved, read
from tuner.problem.problem import Problem
from tuner.run.study import Task
from tuner.solvers import Alternating, Gradient
from tuner.solvers.solver import Solver

ROOMS = ("room", "room_now")
"""With a lead and without: others are compared with the one that has the same freedom."""
ENOUGH = 3e-4
"""Slope of ln error at which a search may end: a tenth of a factor e more changes nothing."""
STILL = 1e-4
"""The same of searches without second derivatives, where all slopes together have to be small."""


@dataclass(frozen=True, eq=False)
class Case:
    """A comparison of filters.

    Attributes:
        contest: all trials.
        folds: indices of the trials that are left out in turn.
        tuned: names of the filters that are tuned on all trials.
    """

    contest: Contest
    folds: Sequence[int]
    tuned: tuple[str, ...]


def case_of(settings: Settings) -> Case:
    """The trials of the folder, and the competing filters.

    Raises:
        ValueError: for a folder or a trial that cannot be used, and for filters that need a
            magnetic field where there is none.
    """
    trials = read(settings.folder, settings.acc_unit, settings.gyr_unit, settings.seconds)
    contest = Contest(tuple(trials), whole=settings.seconds is None)
    count = len(trials) if settings.folds is None else min(settings.folds, len(trials))
    folds = range(count if len(trials) > 1 else 0)
    return Case(contest, folds, _contestants(settings, trials))


def _contestants(settings: Settings, trials: Sequence[Trial]) -> tuple[str, ...]:
    """The filters to tune: those that are asked for, or all that the trials allow."""
    silent = [trial.name for trial in trials if trial.start is None]
    if settings.contestants is None:
        return tuple(name for name in get_args(Contestant) if not (silent and takes_field(name)))
    with_field = [name for name in settings.contestants if takes_field(name)]
    if with_field and silent:
        raise ValueError(
            f"{' and '.join(with_field)} need a magnetic field (imu_mag) before the movement, and "
            f"{', '.join(silent)} has none; leave them out of contestants"
        )
    return tuple(dict.fromkeys((*ROOMS, *settings.contestants)))


def tasks(case: Case, seed: int) -> tuple[Task, ...]:
    """Every filter tuned on all trials; the room filters also without each, and one on each alone.

    Those are tuned at half the sample rate, in half the time, and judged at the whole one.
    """
    contest = case.contest
    gradient = Gradient("l-bfgs-b", seed=seed, starts=1, gradient=ENOUGH, iterations=40)
    quick = replace(gradient, gradient=STILL, curvature=False)
    alternating = Alternating(
        seed=seed, starts=1, rounds=2, progress=1e-3, gradient=ENOUGH, iterations=40
    )
    solvers: dict[str, Solver] = {
        "two_step": alternating,
        "two_step_lead": alternating,
        "room": gradient,
    }
    found = [Task(contest.problem(name, name), solvers.get(name, quick)) for name in case.tuned]
    found += [Task(posed, quick) for posed in _folds(case)]
    return (*found, *_transfer(contest, quick))


def fold_name(trial: str, name: str = "room") -> str:
    """The name of the problem that leaves a trial out."""
    return f"without_{trial}" if name == "room" else f"{name}_without_{trial}"


def alone_name(trial: str) -> str:
    """The name of the problem that is tuned on one trial, and judged on the same."""
    return f"alone_{trial}"


def _folds(case: Case) -> Iterator[Problem]:
    slow = [halved(trial) for trial in case.contest.trials]
    for name in ROOMS:
        for at in case.folds:
            others = [trial for i, trial in enumerate(slow) if i != at]
            yield case.contest.of(others).problem(fold_name(slow[at].name, name), name)
    samples = max(end(trial) for trial in slow)
    for at in case.folds:
        yield case.contest.of([slow[at]], samples).problem(alone_name(slow[at].name), "room")


def _transfer(contest: Contest, gradient: Gradient) -> list[Task]:
    calm = [trial for trial in contest.trials if not trial.disturbed]
    if not calm or len(calm) == len(contest.trials):
        return []
    posed = contest.of([halved(trial) for trial in calm]).problem("undisturbed", "room")
    return [Task(posed, gradient)]
