"""The paper's claims about the driving noise, over lambda: never at one of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from filters.gps_aided import GpsAidedOutputs
from studies.chauhan2009.behaviour import Behaviour, behaviour
from studies.chauhan2009.data import MOTIONS, Records, Step, records
from studies.chauhan2009.paper import DRIVEN, MAGNIFIED
from studies.chauhan2009.problems import (
    FUZZY,
    by_hand,
    estimated,
    posed,
    randomly,
    tuning_records,
)
from studies.chauhan2009.settings import Settings
from tuner.problem.problem import Problem

Holds: TypeAlias = Callable[[Behaviour, Behaviour], np.ndarray]
"""A claim that compares the fuzzy and the random law: the records where it holds, ``(k,)``."""
MOST = 0.5
"""Share of the records above which a claim holds at a lambda."""


SHOWN = (0.1, 1.0, 10.0)
"""The lambdas whose errors are drawn."""


class Case(NamedTuple):
    """One step with all seeds under the fuzzy law, and the random one at every lambda."""

    step: Step
    records: Records
    fuzzy: Behaviour
    random: tuple[Behaviour, ...]


@dataclass(frozen=True, eq=False)
class Sweep:
    """Every driven step, sensed by gyroscopes or not, with fuzzy and random noise over lambda.

    Every lambda and seed of a step run side by side, and steps share one compilation.

    Attributes:
        settings: of the records.
        seed: of their noise.
    """

    settings: Settings
    seed: int
    _fuzzy: dict[Step, GpsAidedOutputs] = field(default_factory=dict, init=False, repr=False)
    _random: dict[Step, dict[float, np.ndarray]] = field(
        default_factory=dict, init=False, repr=False
    )

    @cached_property
    def tuned_on(self) -> Records:
        """The records that every law is tuned on."""
        return tuning_records(self.settings, self.settings.train, self.seed)

    @cached_property
    def posed(self) -> dict[str, Problem]:
        """The problem of each law, by name."""
        return posed(self.settings, self.tuned_on)

    @cached_property
    def cases(self) -> tuple[Case, ...]:
        """All cases."""
        steps = [Step(angle, motion) for motion in MOTIONS for angle in (*DRIVEN, MAGNIFIED)]
        return tuple(self._case(step) for step in steps)

    def made(self, step: Step) -> Records:
        """The records of a step."""
        seeds = [self.seed + i for i in range(self.settings.records)]
        return records(self.settings, [step], seeds)

    def fuzzy(self, step: Step) -> GpsAidedOutputs:
        """Outputs of the fuzzy law as published on a step's records."""
        if step not in self._fuzzy:
            inputs = self.made(step).inputs
            self._fuzzy[step] = estimated(FUZZY, inputs, by_hand(self.settings))
        return self._fuzzy[step]

    def random(self, step: Step) -> dict[float, np.ndarray]:
        """Angles by the random law at each lambda, rad, ``(N, k, 3)``."""
        if step not in self._random:
            factors = sorted({*self.settings.factors, *SHOWN})
            Q = np.asarray(self.fuzzy(step).Q)
            found = randomly(self.settings, self.made(step), Q, factors, self.seed)
            self._random[step] = dict(zip(factors, found, strict=True))
        return self._random[step]

    def _case(self, step: Step) -> Case:
        made = self.made(step)

        def judged(angles: np.ndarray) -> Behaviour:
            return behaviour(angles[:, :, 1], made, self.settings, step.pitch)

        by_factor = self.random(step)
        random = tuple(judged(by_factor[factor]) for factor in self.settings.factors)
        return Case(step, made, judged(np.asarray(self.fuzzy(step).angles)), random)

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
