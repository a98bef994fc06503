"""What a fit tunes: what a filter's facts suggest in the data's own scale, and what a user decides."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

import numpy as np

from filters.declared import (
    OWN,
    Param,
    channel_facts,
    in_unit,
    optional_groups,
    parameter_facts,
)
from tuner.data.merge import Timeline
from tuner.names import unknown
from tuner.problem.parameters import Bounded, Fixed, Parameter, Positive
from tuner.problem.space import Space

_PER_TIME = re.compile(r"/s(?:\^(\d+))?$")
"""A power of time below the line, at the end of a declared unit."""
DEVIATION = "sigma"
"""The input that brings each measurement's own deviation: a declared variance of the measurement is
then a factor on its square, without unit."""
LARGEST = 1e60
"""Data beyond this, or whose noise is below its inverse, are refused: a search takes squares of
squares of it."""


@dataclass(frozen=True)
class Wishes:
    """What a user decides of a fit; the filter's facts and the data decide the rest.

    Attributes:
        start: where the search begins, by parameter.
        fix: parameters that are held, and at what.
        bound: the ends of the search, by parameter.
        options: fields of the filter's class, such as ``law``.
        objective: name of the objective; None chooses by what there is.
    """

    start: Mapping[str, float] = field(default_factory=dict)
    fix: Mapping[str, float] = field(default_factory=dict)
    bound: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)
    objective: str | None = None


def space_of(cls: type[Any], timeline: Timeline, wishes: Wishes) -> Space:
    """The parameters: what the facts suggest in the data's own scale, and what the user decides.

    Raises:
        ValueError: for an unknown parameter, and values that do not go together.
    """
    facts = parameter_facts(cls)
    for given in (*wishes.start, *wishes.fix, *wishes.bound):
        if given not in facts:
            raise unknown("parameter", given, facts)
    scale, own = scale_of(cls, timeline), own_unit(cls, timeline)
    asked = wishes.start.keys() | wishes.fix.keys() | wishes.bound.keys()
    without = {name for group in optional_groups(cls) if not group & asked for name in group}
    chosen = {
        name: _parameter(name, fact, scale, in_unit(fact.unit, own), wishes)
        for name, fact in facts.items()
        if name not in without
    }
    return Space(tuple(chosen.items()))


@dataclass(frozen=True)
class Scale:
    """What is large in data of any unit: the noise of its steps, and a step of its clock, s."""

    size: float
    step: float

    def of(self, unit: str) -> float:
        """What 1 in a declared unit stands for; 1 for a unit in SI."""
        own = OWN.search(unit)
        if own is None:
            return 1.0
        per_time = _PER_TIME.search(unit)
        power = int(per_time[1] or 1) if per_time else 0
        return float(self.size ** int(own[1] or 1) / self.step**power)


def scale_of(cls: type[Any], timeline: Timeline) -> Scale:
    """Of the first channel that may have any unit; 1 without one."""
    facts = channel_facts(cls, "inputs")
    free = [name for name in timeline.channels if OWN.search(facts[name].unit)]
    step = float(np.nanmedian(timeline.dt))
    if not free:
        return Scale(1.0, step)
    columns = np.asarray(timeline.channels[free[0]], float).reshape(len(timeline.dt), -1).T
    steps = np.concatenate([np.diff(column[np.isfinite(column)]) for column in columns])
    # The median is not moved by outliers; that of squares of normal numbers is 0.455.
    size = float(np.sqrt(np.median(steps**2) / 0.455 / 2)) if len(steps) else 0.0
    return Scale(size or float(np.nanstd(columns)) or 1.0, step)


def own_unit(cls: type[Any], timeline: Timeline) -> str:
    """Unit of the first channel that may have any; "" without one, or where nobody told."""
    facts = channel_facts(cls, "inputs")
    units = (timeline.units.get(n, "") for n in timeline.channels if OWN.search(facts[n].unit))
    return next(units, "")


def _parameter(name: str, fact: Param, scale: Scale, unit: str, wishes: Wishes) -> Parameter:
    if name in wishes.fix:
        return Fixed(wishes.fix[name], unit, meaning=fact.meaning)
    factor = scale.of(fact.unit)
    if name not in wishes.bound and (fact.low is None or fact.high is None):
        held = wishes.start.get(name, fact.typical)
        return Fixed(held, unit, meaning=fact.meaning)
    typical = float(np.asarray(fact.typical).flat[0]) * factor
    low, high = wishes.bound.get(name, _range(fact, factor))
    init = wishes.start.get(name, min(max(typical, low), high))
    if name not in wishes.bound:
        low, high = min(low, init), max(high, init)
    try:
        kind = Positive if low > 0 else Bounded
        return kind(init, low, high, unit, meaning=fact.meaning)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def _range(fact: Param, factor: float) -> tuple[float, float]:
    low, high = fact.low, fact.high
    if low is None or high is None:
        raise ValueError("the parameter has no range")
    return low * factor, high * factor
