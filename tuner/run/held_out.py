"""The worth of tuning on held-out data: beside the start, no filter, and the best."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from typing import Any

import numpy as np

from tuner.certificate.solution import Solution
from tuner.problem.problem import Problem
from tuner.run.baseline import without_filter
from tuner.run.fit_problem import Posed
from tuner.run.sample_terms import (
    Improvement,
    SampleTerms,
    improvement,
    run_with,
    sample_terms,
    terms_of,
    value_of,
)
from tuner.run.split import HeldOutBy, Parting, only


@dataclass(frozen=True)
class OneHeldOut:
    """One recording, judged by the filter that was tuned on the others.

    Attributes:
        recording: its number, from 1.
        start, tuned, best: as of :class:`HeldOut`, on this recording alone.
    """

    recording: int
    start: float
    tuned: float
    best: float


@dataclass(frozen=True)
class HeldOut:
    """The filter tuned on a part of the data, judged on the rest by the fit's own objective.

    A likelihood is told as the equivalent deviation.

    Attributes:
        way: what was held out.
        what: which part judges, in words.
        start: the objective there with the values that the search began with.
        tuned: with those that were tuned on the other part.
        gain: by how much tuning is better than the start there; None where the objective is no
            sum over samples, so that nothing can be paired.
        nothing: what stands for the filter where there is none, in words; "" where nothing does.
        unfiltered: the objective of that.
        over_unfiltered: by how much the tuned filter is better than that.
        best: the objective with the values tuned on what is held out, by itself.
        gap: by which share ``tuned`` lies above ``best``.
        recordings: each recording, where each was held out in turn.
    """

    way: HeldOutBy
    what: str
    start: float
    tuned: float
    gain: Improvement | None = None
    nothing: str = ""
    unfiltered: float | None = None
    over_unfiltered: Improvement | None = None
    best: float | None = None
    gap: float | None = None
    recordings: tuple[OneHeldOut, ...] = ()


def judge_held_out(posed: Posed, parted: Parting, solved: Mapping[str, Solution]) -> HeldOut:
    """Tuned against untuned, against no filter and against the best, on what was held out.

    Args:
        posed: the problem.
        parted: what was held out.
        solved: solutions by the names of the problems in it.
    """
    problem = posed.problem
    begun = problem.parameters(problem.space.start())
    tuned = [_values(solved[part.name]) for part in parted.tuned]
    alone = [_values(solved[part.name]) for part in parted.alone]
    before = [sample_terms(problem, begun)] * len(tuned)
    if before[0] is None:
        return _of_scores(problem, parted, begun, tuned)
    three = [before, *([sample_terms(problem, v) for v in each] for each in (tuned, alone))]
    parts = [
        [a.only(judge) for a, judge in zip(each, parted.judges, strict=True) if a is not None]
        for each in three
    ]
    start, ours, own = (reduce(add, each) for each in parts)
    value, best = value_of(problem, ours.mean), value_of(problem, own.mean)
    best = min(value, best)  # a search of its own may also end higher
    found = HeldOut(
        way=parted.way,
        what=parted.words,
        start=value_of(problem, start.mean),
        tuned=value,
        gain=improvement(problem, start, ours),
        best=best,
        gap=value / best - 1 if best > 0 else None,
        recordings=_each(problem, *parts) if parted.way == "leave-one-out" else (),
    )
    return _beside_nothing(posed, parted, found, begun, ours)


def _values(solution: Solution) -> dict[str, np.ndarray]:
    return {name: parameter.value for name, parameter in solution.parameters.items()}


def _each(
    problem: Problem, start: list[SampleTerms], tuned: list[SampleTerms], own: list[SampleTerms]
) -> tuple[OneHeldOut, ...]:
    pieces = []
    for i, parts in enumerate(zip(start, tuned, own, strict=True), 1):
        before, now, best = (value_of(problem, each.mean) for each in parts)
        pieces.append(OneHeldOut(i, before, now, min(now, best)))
    return tuple(pieces)


def _of_scores(
    problem: Problem, parted: Parting, begun: Mapping[str, Any], tuned: list[dict[str, np.ndarray]]
) -> HeldOut:
    """Of an objective that is no sum over samples: the mean over the parts, and no interval."""
    parts = [only(problem, judge) for judge in parted.judges]
    before = [part.score(begun) for part in parts]
    now = [part.score(values) for part, values in zip(parts, tuned, strict=True)]
    return HeldOut(parted.way, parted.words, float(np.mean(before)), float(np.mean(now)))


def _beside_nothing(
    posed: Posed, parted: Parting, found: HeldOut, begun: Mapping[str, Any], ours: SampleTerms
) -> HeldOut:
    """Add what is to be had without a filter: what is best on what the filter was tuned on."""
    problem = posed.problem
    outputs = run_with(problem, begun)
    rest: dict[str, list[SampleTerms]] = {}
    held: dict[str, list[SampleTerms]] = {}
    for judge in parted.judges:
        for name, raw in without_filter(posed, outputs, ~judge).items():
            all_of_it = terms_of(problem, raw).finite()
            rest.setdefault(name, []).append(all_of_it.only(~judge))
            held.setdefault(name, []).append(all_of_it.only(judge))
    on_rest = {name: reduce(add, each).mean for name, each in rest.items()}
    on_held = {name: reduce(add, each) for name, each in held.items()}
    known = [name for name, each in on_held.items() if each.counts.any()]
    if not known:
        return found
    name = min(known, key=lambda each: on_rest[each])
    return replace(
        found,
        nothing=name,
        unfiltered=value_of(problem, on_held[name].mean),
        over_unfiltered=improvement(problem, on_held[name], ours),
    )
