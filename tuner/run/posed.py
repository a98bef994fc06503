"""From a filter and a recording to the problem that tunes the one on the other."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import jax.numpy as jnp
import numpy as np

from filters import Lanes, Timed, TimedSample
from filters.declared import (
    OWN,
    Channel,
    Param,
    channel_facts,
    in_unit,
    inputs_of,
    optional,
    optional_groups,
    parameter_facts,
)
from objectives import Data, Objective
from tuner.catalogue import find
from tuner.data.merge import Timeline
from tuner.data.source import Source
from tuner.names import unknown
from tuner.problem.exported import exported_of
from tuner.problem.parameters import Bounded, Fixed, Parameter, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space

_PER_TIME = re.compile(r"/s(?:\^(\d+))?$")
"""A power of time below the line, at the end of a declared unit."""
NO_TRUTH = ("likelihood", "prediction")
"""Objectives that need no truth."""


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


@dataclass(frozen=True, eq=False)
class Posed:
    """A problem, and what it is judged by.

    Attributes:
        problem: the problem.
        objective: name of the objective.
        output: the output that is compared with the truth; "" without a truth.
        unit: of the objective's value.
        timeline: the data.
        source: where they come from.
        notes: what looks strange in them, and what was left out, a sentence each.
    """

    problem: Problem
    objective: str
    output: str
    unit: str
    timeline: Timeline
    source: Source
    notes: tuple[str, ...] = ()


def pose(name: str, cls: type[Any], timeline: Timeline, wishes: Wishes, source: Source) -> Posed:
    """The problem of tuning a filter on a recording.

    Args:
        name: what it is called.
        cls: the filter's class, which declares its facts.
        timeline: the data.
        wishes: what the user decides.
        source: where the data come from.

    Raises:
        ValueError: for a channel that is needed and missing, an unknown parameter, option or
            objective, and where nothing says how good a run is.
    """
    check_channels(name, cls, timeline)
    filter = set_up(name, cls, timeline, wishes.options)
    objective, judged, output = choose_objective(name, cls, timeline, wishes.objective)
    unit = _unit_of(cls, timeline, objective, output)
    outputs = channel_facts(cls, "outputs")
    problem = Problem(
        name=name.replace("-", "_"),
        space=space_of(cls, timeline, wishes),
        filter=filter,
        build=None,
        objective=judged,
        data=Data(_inputs(cls, timeline), truth_of(timeline, outputs.get(output), output)),
        source=source,
        exported=exported_of(filter, own_unit(cls, timeline)),
    )
    return Posed(problem, objective, output, unit, timeline, source)


def check_channels(name: str, cls: type[Any], timeline: Timeline) -> None:
    """Refuse channels that are missing, or that the filter does not know.

    Raises:
        ValueError: with what the filter needs.
    """
    facts = channel_facts(cls, "inputs")
    for given in timeline.channels:
        if given not in facts:
            raise unknown("channel", given, facts)
    for needed, fact in facts.items():
        if needed not in timeline.channels and needed not in optional(cls):
            inside = f" in {fact.unit}" if fact.unit else ""
            columns = ",".join(["COLUMN"] * max(len(fact.axes), 1))
            raise ValueError(
                f"{name} needs {needed} ({fact.meaning}{inside}), which is not mapped; give it "
                f"with --map {needed}={columns}[:UNIT]"
            )


def set_up(name: str, cls: type[Any], timeline: Timeline, options: Mapping[str, Any]) -> Any:
    """The filter for a timeline: of its rate, or taking the times as they come; k side by side.

    Raises:
        ValueError: for an unknown option, and varying times that the filter cannot take.
    """
    known = {each.name: each for each in fields(cls)}
    for option in options:
        if option not in known or option == "dt":
            raise unknown(f"option of {name}", option, [n for n in known if n != "dt"])
    dt = np.asarray(timeline.dt)
    step = {"dt": float(np.nanmedian(dt) if timeline.rate_hz is None else 1 / timeline.rate_hz)}
    filter = cls(**({} if "dt" not in known else step), **options)
    if hasattr(filter, "given"):
        filter = filter.given(frozenset(timeline.channels))
    if timeline.rate_hz is None:
        filter = Timed(filter)
    return Lanes(filter, dt.shape[1]) if dt.ndim == 2 else filter


def _inputs(cls: type[Any], timeline: Timeline) -> Any:
    inputs = inputs_of(cls, timeline.channels)
    if timeline.rate_hz is not None:
        return inputs
    return TimedSample(jnp.asarray(timeline.dt), inputs)


def choose_objective(
    name: str, cls: type[Any], timeline: Timeline, wished: str | None
) -> tuple[str, Objective, str]:
    """Name of the objective, the objective, and the output that it compares with the truth.

    Raises:
        ValueError: for an unknown objective or output, several truths, and where there is neither
            a truth nor a likelihood.
    """
    outputs = channel_facts(cls, "outputs")
    for given in timeline.truth:
        if given not in outputs:
            raise unknown(f"output of {name}", given, outputs)
    if len(timeline.truth) > 1:
        raise ValueError(
            f"there are truths for {' and '.join(timeline.truth)}, and a fit has one; give one, "
            "for errors of different units do not add up"
        )
    output = next(iter(timeline.truth), "")
    chosen = wished or _by_what_there_is(name, cls, outputs.get(output), timeline)
    made: Objective = find("tuner.objectives", chosen)(output, _as_given(outputs, output, timeline))
    if chosen in NO_TRUTH:
        _needs(name, chosen, outputs)
        output = ""
    return chosen, made, output


def _as_given(outputs: Mapping[str, Channel], output: str, timeline: Timeline) -> Channel | None:
    """The output's facts, with the axes that its truth has: the first of those declared."""
    fact = outputs.get(output)
    if fact is None or not fact.axes:
        return fact
    return fact._replace(axes=fact.axes[: np.shape(truth_of(timeline, fact, output))[-1]])


def _needs(name: str, objective: str, outputs: Mapping[str, Channel]) -> None:
    lacking = [part for part in ("innovation", "variance") if part not in outputs]
    if "innovation" in lacking or (objective == "likelihood" and lacking):
        raise ValueError(
            f"{name} outputs no {' and no '.join(lacking)}, so it has no {objective}; give a truth "
            f"for one of its outputs, such as --truth {next(iter(outputs))}=COLUMN"
        )


def _by_what_there_is(name: str, cls: type[Any], truth: Channel | None, timeline: Timeline) -> str:
    """With a truth its error; without one the likelihood of the innovations, or their size."""
    if truth is not None:
        free_heading = truth.kind == "attitude" and "mag" in channel_facts(cls, "inputs")
        return "inclination" if free_heading and "mag" not in timeline.channels else "rmse"
    return "prediction" if "variance" not in channel_facts(cls, "outputs") else "likelihood"


def truth_of(timeline: Timeline, fact: Channel | None, output: str) -> np.ndarray:
    """What outputs are held against: the truth, or zeros that say that every sample counts.

    The truth of an output with axes has them last, also where it is one alone.
    """
    if not output:
        return np.zeros((*np.shape(timeline.dt), 1))
    truth = np.asarray(timeline.truth[output], float)
    alone = fact is not None and fact.axes and truth.ndim == np.ndim(timeline.dt)
    return truth[..., None] if alone else truth


def _unit_of(cls: type[Any], timeline: Timeline, objective: str, output: str) -> str:
    if objective in ("inclination", "heading"):
        return "deg"
    fact = channel_facts(cls, "outputs").get(output or "innovation")
    if fact is None or fact.kind == "attitude":
        return "deg" if fact is not None else ""
    return in_unit(fact.unit, own_unit(cls, timeline))


# The space.


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
