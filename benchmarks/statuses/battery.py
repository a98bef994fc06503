"""All cases, all solvers, all verdicts."""

import warnings
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks.statuses import families, likelihoods, rough, valleys
from benchmarks.statuses.case import Case
from benchmarks.statuses.judge import Verdict, is_threshold_refusal, judge, raised
from tuner.solvers import make_solver

SOLVERS = ("l-bfgs-b", "nelder-mead", "trust-constr", "ipopt", "alternating")
SLOW = 3
"""Of the slow solvers, trust-constr and ipopt, every third case is solved."""


def cases(seed: int, share: float = 1.0, family: str | None = None) -> Iterator[Case]:
    """The cases, in order; a share below 1 takes the first ones of every kind, at least one."""
    plans = [*families.plan(), *rough.plan(), *valleys.plan(), *likelihoods.plan()]
    for kind, (make, count) in enumerate(plans):
        for number in range(max(1, round(share * count))):
            case = make(np.random.default_rng([seed, kind, number]), number)
            if family not in (None, case.family):
                break
            yield case


def solvers(case: Case, *, slow: int) -> Iterator[str]:
    """The solvers of a case: the slow ones in turn."""
    for name in SOLVERS:
        if is_threshold_refusal(case, name):
            continue
        if name == "alternating" and not case.problem.space.thresholds().any():
            continue
        if name == "ipopt" and not case.smooth:
            continue
        if name in ("trust-constr", "ipopt") and case.number % slow:
            continue
        yield name


def verdicts(
    chosen: Sequence[Case], *, slow: int = SLOW, only: Sequence[str] = SOLVERS
) -> Iterator[Verdict]:
    """Solve and judge, by some of the solvers."""
    for case in chosen:
        for name in solvers(case, slow=slow):
            if name not in only:
                continue
            solver = make_solver(name, seed=case.number, starts=case.starts, storage="")
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    solution = solver(case.problem)
            except Exception as error:  # an error is a verdict as well
                yield raised(case, name, error)
                continue
            yield judge(case, name, solution)


class Part(NamedTuple):
    """The part of one of several processes: every ``step``-th kind of cases."""

    seed: int
    share: float
    slow: int
    family: str | None
    first: int
    step: int


def solved(part: Part) -> list[Verdict]:
    """The verdicts of a part; cases of one kind stay together, as they share compilations."""
    kinds: dict[str, int] = {}
    chosen = [
        case
        for case in cases(part.seed, part.share, part.family)
        if kinds.setdefault(case.kind, len(kinds)) % part.step == part.first
    ]
    return list(verdicts(chosen, slow=part.slow))
