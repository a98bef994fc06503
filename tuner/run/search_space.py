"""The parameters that a fit tunes: scaled to the data by the facts, or as a user decides."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
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
from objectives import Data, Objective
from tuner.data.merge import Timeline
from tuner.identifiability.noise import NoModelError
from tuner.identifiability.sizes import NoiseSize, noise_sizes
from tuner.names import unknown
from tuner.problem.parameters import Bounded, Fixed, Parameter, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space

_PER_TIME = re.compile(r"/s(?:\^(\d+))?$")
"""A power of time below the line, at the end of a declared unit."""
DEVIATION = "sigma"
"""The input that brings each measurement's own deviation: a declared variance of the measurement is
then a factor on its square, without unit."""
FAR = 1e4
"""Factor between what differences say of a noise and where nobody looks for it."""
LARGEST = 1e60
"""Data beyond this, or whose noise is below its inverse, are refused: a search takes squares of
squares of it."""


@dataclass(frozen=True)
class Wishes:
    """The choices of a user for a fit; the filter's facts and the data decide the rest.

    Attributes:
        start: where the search begins, by parameter.
        fix: parameters that are held, and at what.
        bound: the ends of the search, by parameter.
        options: fields of the filter's class, such as ``law``.
        objective: name of the objective; None chooses by what there is.
        held: whether all parameters may be held: values are tried, not tuned.
    """

    start: Mapping[str, float] = field(default_factory=dict)
    fix: Mapping[str, float] = field(default_factory=dict)
    bound: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)
    objective: str | None = None
    held: bool = False


def sizes_of(
    cls: type[Any], filter: Any, objective: Objective, data: Data
) -> Mapping[str, NoiseSize]:
    """How large the noise is, by parameter; nothing for a filter whose model is not known.

    Args:
        cls: the filter's class.
        filter: the filter, set up for the data.
        objective: what it is judged by.
        data: its inputs and what they are held against.
    """
    if not hasattr(cls, "linear"):
        return {}
    try:
        return noise_sizes(Problem("noise", Space.of_filter(cls), filter, None, objective, data))
    except NoModelError:
        return {}


def space_of(
    cls: type[Any],
    timeline: Timeline,
    wishes: Wishes,
    sizes: Mapping[str, NoiseSize] = MappingProxyType({}),
) -> Space:
    """The parameters: what the facts suggest in the data's own scale, and what the user decides.

    Args:
        cls: the filter's class.
        timeline: the data.
        wishes: what the user decides.
        sizes: of the noise, by parameter, as :func:`sizes_of` tells.

    Raises:
        ValueError: for an unknown parameter, and values that do not go together.
    """
    facts = parameter_facts(cls)
    for given in (*wishes.start, *wishes.fix, *wishes.bound):
        if given not in facts:
            raise unknown("parameter", given, facts)
    scale, own = scale_of(cls, timeline), own_unit(cls, timeline)
    named = wishes.start.keys() | wishes.fix.keys() | wishes.bound.keys()
    without = {name for group in optional_groups(cls) if not group & named for name in group}
    chosen = {
        name: _parameter(
            name, _sized(_in_data(fact, scale, own, timeline, cls), fact, sizes.get(name)), wishes
        )
        for name, fact in facts.items()
        if name not in without
    }
    if not wishes.held and all(isinstance(parameter, Fixed) for parameter in chosen.values()):
        held = ", ".join(chosen)
        raise ValueError(f"nothing is left to tune: {held} are held; fix one parameter less")
    return Space(tuple(chosen.items()))


@dataclass(frozen=True)
class Scale:
    """The scale of data in any unit: the noise of its steps, and a step of its clock, s."""

    size: float
    step: float

    def of(self, unit: str) -> float:
        """The value of 1 in a declared unit; 1 for a unit in SI.

        >>> Scale(size=10.0, step=0.5).of("unit^2/s"), Scale(10.0, 0.5).of("rad/s")
        (200.0, 1.0)
        """
        own = OWN.search(unit)
        if own is None:
            return 1.0
        per_time = _PER_TIME.search(unit)
        power = int(per_time[1] or 1) if per_time else 0
        return float(self.size ** int(own[1] or 1) / self.step**power)


def scale_of(cls: type[Any], timeline: Timeline) -> Scale:
    """Of the first channel that may have any unit; 1 without one.

    Raises:
        ValueError: for data too large, or too small, to be squared.
    """
    step, name = timeline.step, _of_any_unit(cls, timeline)
    if not name:
        return Scale(1.0, step)
    columns = np.asarray(timeline.channels[name], float).reshape(len(timeline.dt), -1).T
    steps = np.concatenate([np.diff(column[np.isfinite(column)]) for column in columns])
    largest = float(np.nanmax(np.abs(columns)))
    if largest > LARGEST or 0 < largest < 1 / LARGEST:
        raise ValueError(
            f"{name} reaches {largest:.3g}, too extreme to compute with; give it in another "
            f"unit, or a factor, as in {name}=COLUMN*1e-30"
        )
    # The median is not moved by outliers; that of squares of normal numbers is 0.455.
    size = float(np.sqrt(np.median(steps**2) / 0.455 / 2)) if len(steps) else 0.0
    return Scale(size or float(np.nanstd(columns)) or 1.0, step)


def own_unit(cls: type[Any], timeline: Timeline) -> str:
    """Unit of the first channel that may have any; "" without one, or where nobody told."""
    return timeline.units.get(_of_any_unit(cls, timeline), "")


def _of_any_unit(cls: type[Any], timeline: Timeline) -> str:
    """The first of the channels that a filter takes in any unit, as it declares them."""
    facts = channel_facts(cls, "inputs")
    free = (n for n, fact in facts.items() if n in timeline.channels and OWN.search(fact.unit))
    return next(free, "")


def _in_data(fact: Param, scale: Scale, own: str, timeline: Timeline, cls: type[Any]) -> Param:
    """A parameter's fact in the unit and scale of the data; one that idles has no range."""
    if fact.channel and fact.channel not in timeline.channels:
        fact = fact._replace(low=None, high=None)
    factor_alone = DEVIATION in timeline.channels and not getattr(cls, "absolute_noise", False)
    if factor_alone and fact.unit == "unit^2":
        return fact._replace(unit="")
    factor = scale.of(fact.unit)
    low, high = (None if end is None else end * factor for end in (fact.low, fact.high))
    typical = fact.typical if isinstance(fact.typical, tuple) else fact.typical * factor
    return fact._replace(unit=in_unit(fact.unit, own), typical=typical, low=low, high=high)


def _sized(fact: Param, declared: Param, size: NoiseSize | None) -> Param:
    """A parameter's fact with the default and the ends that the noise of the record suggests.

    Where the fact is declared in the data's own unit, its numbers are but a shape. Otherwise they
    are knowledge of what such sensors are like, and stay where the data do not contradict.
    """
    if size is None or fact.low is None or fact.high is None or fact.low <= 0:
        return fact
    found = size.estimate if size.estimate > size.deviation else None
    if OWN.search(declared.unit):
        low, high = size.least, FAR * size.most
        typical = size.alone / 2  # as if two noises shared it
    else:
        low, high = fact.low, fact.high
        typical = float(np.asarray(fact.typical).flat[0])
        if found is not None and not found / FAR < typical < found * FAR:
            typical = found
    if found is not None:
        low, high = min(low, found / FAR), max(high, found * FAR)
    return fact._replace(typical=typical, low=low, high=high)


def _parameter(name: str, fact: Param, wishes: Wishes) -> Parameter:
    if name in wishes.fix:
        return _held(name, fact, wishes)
    ends = _ends(name, fact, wishes)
    if ends is None:
        held = wishes.start.get(name, fact.typical)
        value = _finite(f"the start of {name}", held)
        return Fixed(value, fact.unit, meaning=fact.meaning, nominal=name not in wishes.start)
    low, high = ends
    kind = Positive if low > 0 else Bounded
    init = wishes.start.get(name)
    if init is None:
        middle = float(np.sqrt(low * high)) if low > 0 else (low + high) / 2
        typical = float(np.asarray(fact.typical).flat[0])
        init = typical if low < typical < high else middle
    if not low <= init <= high or (kind is Bounded and init in (low, high)):
        raise ValueError(
            f"{name} begins at {init:g}, which is outside its search range of {low:g} to {high:g}; "
            "move the start, or its bound"
        )
    return kind(init, low, high, fact.unit, meaning=fact.meaning)


def _held(name: str, fact: Param, wishes: Wishes) -> Fixed:
    """A parameter at the value that a user holds it at."""
    value = _finite(f"{name}, which is fixed,", wishes.fix[name])
    if name in wishes.start or name in wishes.bound:
        raise ValueError(f"{name} is fixed and has a start or a bound; give one of them")
    if fact.low is not None and fact.low > 0 > value:
        raise ValueError(f"{name} is fixed at {value:g}; {fact.meaning}: it cannot be negative")
    return Fixed(value, fact.unit, meaning=fact.meaning)


def _ends(name: str, fact: Param, wishes: Wishes) -> tuple[float, float] | None:
    """Where the search ends: as the user says, or by the facts and a start beyond; None: nowhere.

    Raises:
        ValueError: for ends that do not rise, and a start that the parameter cannot have.
    """
    if name in wishes.bound:
        low, high = wishes.bound[name]
        if not -np.inf < low < high < np.inf:
            raise ValueError(f"the bound of {name}, {low:g} to {high:g}, is no range that rises")
        return low, high
    if fact.low is None or fact.high is None:
        return None
    start = _finite(f"the start of {name}", wishes.start.get(name, fact.low))
    if fact.low > 0 >= start:
        raise ValueError(f"{name} begins at {start:g}; {fact.meaning}: it is positive")
    return (min(fact.low, start), max(fact.high, start)) if fact.low > 0 else (fact.low, fact.high)


def _finite(what: str, value: Any) -> Any:
    if not np.isfinite(value).all():
        raise ValueError(f"{what} is {value}; give a finite number")
    return value
