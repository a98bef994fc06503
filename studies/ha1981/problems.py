"""The problems and their solvers."""

from dataclasses import replace

import numpy as np

from studies.ha1981 import conventional, machine, scheme
from studies.ha1981.channel import Channel
from studies.ha1981.paper import TS
from studies.ha1981.settings import Settings
from tuner.observers.lmi import FastestDecayTask
from tuner.run.study import Task
from tuner.solvers import Convex, Gradient, Ipopt, NelderMead


def tasks(channel: Channel, settings: Settings, seed: int) -> tuple[Task, ...]:
    """The designs of both schemes, and of the values that the paper leaves open."""
    return (*_conventional(channel, settings, seed), *_kalman(channel, settings, seed))


def _conventional(channel: Channel, settings: Settings, seed: int) -> list[Task]:
    loop = replace(conventional.fastest_decay(channel), exported=machine.loop(channel))
    end = scheme.reaches(channel, TS)
    gradient = Gradient("l-bfgs-b", seed=seed, starts=2)
    return [
        Task(loop, Ipopt(seed=seed, starts=settings.starts)),
        Task(loop, conventional.closed_form(channel)),
        Task(one_lyapunov_matrix(channel), Convex("sdp")),
        Task(conventional.least_ise(channel), Ipopt(seed=seed, starts=2)),
        *(Task(conventional.staged(channel, end, stages), gradient) for stages in (1, 2)),
    ]


def one_lyapunov_matrix(channel: Channel) -> FastestDecayTask:
    """The conventional design as a matrix inequality, without altimeter noise as in the paper."""
    bias = np.array([[1.0, 0.0, 0.0]])
    return FastestDecayTask(
        "conventional_lmi", channel.system(0.0), bias, [channel.bound], ("A_B",)
    )


def _kalman(channel: Channel, settings: Settings, seed: int) -> list[Task]:
    storage = scheme.Storage.of(channel, settings.Ts, settings.segments)
    stored = replace(storage.problem(), exported=machine.stored_gains(channel, storage))
    steady = scheme.steady(channel, TS)
    known = scheme.riccati_gains(channel, TS), scheme.printed_gains(channel, TS)
    searches = Gradient("l-bfgs-b", seed=seed, starts=1), NelderMead(seed=seed, starts=1)
    return [
        *(Task(steady, solver) for solver in (*known, *searches)),
        # Far from the mean gains the filter is unstable: more starts find nothing.
        Task(stored, searches[0]),
    ]
