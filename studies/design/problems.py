"""The two designs, each with its proof."""

from dataclasses import dataclass, replace

import numpy as np

from objectives import LinearSystem, without_undriven
from studies.design.designed import Designed
from studies.design.settings import Settings, error_of, system_of
from tuner import observers
from tuner.observers.gains import Variance
from tuner.observers.lmi import Attempt, FastestDecayTask, MinimumVarianceTask
from tuner.problem.problem import Problem
from tuner.run.study import Task
from tuner.solvers import Convex, Ipopt


@dataclass(frozen=True, eq=False)
class Posed:
    """A design as a problem.

    Attributes:
        designed: the model, and the part of it that is designed for.
        problem: the search.
        tasks: the problem and its proof, with their solvers.
        undriven: undriven modes, in words.
    """

    designed: Designed
    problem: Problem
    tasks: tuple[Task, ...]
    undriven: tuple[str, ...] = ()


def pose(settings: Settings, seed: int) -> Posed:
    """The fastest observer that meets the bound, or that of least variance, which settles in time.

    Raises:
        ValueError: for a model or a requirement that no observer meets.
    """
    full = system_of(settings)
    error = Variance.of(full, error_of(settings, full)).error
    if settings.settles_s is not None:
        return _settled(settings, full, error, settings.settles_s, seed)
    if settings.bound is None:
        return _minimum_variance(settings, full, error, seed)
    return _fastest_decay(settings, full, error, settings.bound, seed)


def _minimum_variance(
    settings: Settings, full: LinearSystem, error: np.ndarray, seed: int
) -> Posed:
    T, driven, modes = without_undriven(full)
    undriven = tuple(mode.words(full.states) for mode in modes)
    if not (error @ T).any():
        raise ValueError(
            f"nothing drives {' and '.join(undriven)}, so this error falls to zero as 1/t without "
            "a gain; let Q drive it, name another error, or give a bound"
        )
    designed = Designed(full, error, driven, T, settings.unit, seed)
    posed = observers.minimum_variance("minimum_variance", driven, error @ T)
    problem = replace(posed, exported=designed.exported)
    M = (error @ T)[None]
    proof = MinimumVarianceTask("minimum_variance_lmi", driven, M, ("error",))
    tasks = (
        Task(problem, observers.riccati(driven)),
        # One start: gains far from those of the Riccati equation are mostly unstable.
        Task(problem, Ipopt(seed=seed, starts=1)),
        Task(proof, Convex("sdp")),
    )
    return Posed(designed, problem, tasks, undriven)


def _settled(
    settings: Settings, full: LinearSystem, error: np.ndarray, within_s: float, seed: int
) -> Posed:
    designed = Designed(full, error, full, np.eye(len(full.A)), settings.unit, seed)
    posed = observers.settled("settled", full, error, within_s)
    problem = replace(posed, exported=designed.exported)
    return Posed(designed, problem, (Task(problem, Ipopt(seed=seed, starts=settings.starts)),))


def _fastest_decay(
    settings: Settings, full: LinearSystem, error: np.ndarray, bound: float, seed: int
) -> Posed:
    designed = Designed(full, error, full, np.eye(len(full.A)), settings.unit, seed)
    posed = observers.fastest_decay("fastest_decay", full, error, bound, designed.squared)
    problem = replace(posed, exported=designed.exported)
    proof = FastestDecayTask("fastest_decay_lmi", full, error[None], [bound], ("error",))
    tasks = (
        Task(problem, Ipopt(seed=seed, starts=settings.starts)),
        Task(Attempt(proof), Convex("sdp")),
    )
    return Posed(designed, problem, tasks)
