"""The paper's claims about the driving noise, over lambda: never at one of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from filters.gps_aided import GpsAidedOutputs
from studies.chauhan2009.behaviour import Behaviour, behaviour
from studies.chauhan2009.data import MOTIONS, Records, Step, records
from studies.chauhan2009.paper import DRIVEN, MAGNIFIED
from studies.chauhan2009.problems import FUZZY, by_hand, estimated, randomly
from studies.chauhan2009.settings import Settings

Holds: TypeAlias = Callable[[Behaviour, Behaviour], np.ndarray]
"""A claim that compares the fuzzy and the random law: the records where it holds, ``(k,)``."""
MOST = 0.5
"""Share of the records above which a claim holds at a lambda."""


class Case(NamedTuple):
    """One step with all seeds under the fuzzy law, and the random one at every lambda."""

    step: Step
    records: Records
    fuzzy: Behaviour
    random: tuple[Behaviour, ...]


@dataclass(frozen=True, eq=False)
class Sweep:
    """Every driven step, sensed by gyroscopes or not, with fuzzy and random noise over lambda.

    Attributes:
        settings: of the records.
        seed: of their noise.
    """

    settings: Settings
    seed: int

    @cached_property
    def cases(self) -> tuple[Case, ...]:
        """All cases."""
        steps = [Step(angle, motion) for motion in MOTIONS for angle in (*DRIVEN, MAGNIFIED)]
        return tuple(self._case(step) for step in steps)

    def made(self, step: Step) -> Records:
        """The records of a step."""
        seeds = [self.seed + i for i in range(self.settings.records)]
        return records(self.settings, [step], seeds)

    def fuzzy(self, made: Records) -> GpsAidedOutputs:
        """Outputs of the fuzzy law as published."""
        return estimated(FUZZY, made.inputs, by_hand(self.settings))

    def _case(self, step: Step) -> Case:
        made = self.made(step)
        fuzzy = self.fuzzy(made)

        def judged(found: GpsAidedOutputs) -> Behaviour:
            return behaviour(np.asarray(found.angles)[:, :, 1], made, self.settings, step.pitch)

        random = tuple(
            judged(randomly(self.settings, made, fuzzy, factor, self.seed))
            for factor in self.settings.factors
        )
        return Case(step, made, judged(fuzzy), random)

    def holds(self, case: Case, claim: Holds) -> tuple[float, ...]:
        """The lambdas at which a claim about (fuzzy, random) holds for most records."""
        return tuple(
            factor
            for factor, random in zip(self.settings.factors, case.random, strict=True)
            if claim(case.fuzzy, random).mean() > MOST
        )


def ranges(kept: Sequence[float], factors: Sequence[float]) -> str:
    """The selected lambdas, in words.

    >>> ranges([0.1, 1.0, 10.0], [0.01, 0.1, 1.0, 10.0, 100.0])
    '0.1 to 10'
    """
    if not kept:
        return "none"
    runs: list[list[float]] = []
    for factor in factors:
        if factor not in kept:
            continue
        at = list(factors).index(factor)
        if runs and list(factors).index(runs[-1][-1]) == at - 1:
            runs[-1].append(factor)
        else:
            runs.append([factor])
    return ", ".join(
        f"{run[0]:g} to {run[-1]:g}" if len(run) > 1 else f"{run[0]:g}" for run in runs
    )
