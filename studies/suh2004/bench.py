"""The records to tune on and to judge by, with the problems posed on them."""

from dataclasses import dataclass
from functools import cached_property

import jax
import jax.numpy as jnp
import numpy as np

from studies.suh2004.data import Recordings, experiment_2, recordings
from studies.suh2004.paper import DT
from studies.suh2004.problems import posed
from studies.suh2004.settings import Settings
from tuner.data.source import Source
from tuner.problem.problem import Problem

HELD_OUT = 1000
"""Offset of the held-out records' seeds from those that are tuned on."""


@dataclass(frozen=True, eq=False)
class Bench:
    """The records to tune on and to judge by, as a study's settings say.

    Attributes:
        settings: the study's.
        tuned_on: records of the seeds from the run's own.
        judged_on: the held-out records.
        source: of the records that are tuned on.
    """

    settings: Settings
    tuned_on: Recordings
    judged_on: Recordings
    source: Source

    @cached_property
    def problems(self) -> dict[str, Problem]:
        """The problem of each filter, by name."""
        return posed(self.tuned_on)


def bench(settings: Settings, seed: int) -> Bench:
    """The records of a run."""
    tuned_on = recordings(settings, settings.train, seed)
    if settings.tune_on == "experiment2":
        inputs = experiment_2(settings.gyro_unit)
        still = jnp.zeros((len(inputs.gyr), 1, 2))
        tuned_on = Recordings(jax.tree.map(lambda leaf: leaf[:, None], inputs), still)
    name = f"{tuned_on.count} simulated motions with accelerations and bias, seeds from {seed}"
    source = Source.simulated(name, [np.asarray(tuned_on.inputs.acc)], 1 / DT)
    judged_on = recordings(settings, settings.held_out, seed + HELD_OUT)
    return Bench(settings, tuned_on, judged_on, source)
