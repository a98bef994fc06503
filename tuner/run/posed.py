"""From a filter and a recording to the problem that tunes the one on the other."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Protocol

import numpy as np

from filters import Lanes, Timed, TimedSample
from filters.declared import (
    Channel,
    Param,
    channel_facts,
    inputs_of,
    optional,
    optional_groups,
    parameter_facts,
)
from objectives import Data, Objective
from tuner.catalogue import find
from tuner.data.source import Source
from tuner.names import unknown
from tuner.problem.parameters import Bounded, Fixed, Parameter, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space

_OWN_UNIT = re.compile(r"\bunit\b(?:\^(\d+))?")
"""What stands for the measurement's unit in a declared unit, and its power."""
NO_TRUTH = ("likelihood", "prediction")
"""Objectives that need no truth."""


class Timeline(Protocol):
    """What is tuned on: one recording on one clock, or several side by side.

    Attributes:
        dt: time since the sample before, s, ``(N,)`` or ``(N, k)``.
        rate_hz: samples a second; None where they come at any time.
        channels: by name, ``(N, ...)`` or ``(N, k, ...)``; NaN is missing.
        truth: likewise, by the names of the filter's outputs.
        units: of channels and truth, by name.
        source: where they come from.
    """

    @property
    def dt(self) -> np.ndarray: ...  # noqa: D102
    @property
    def rate_hz(self) -> float | None: ...  # noqa: D102
    @property
    def channels(self) -> Mapping[str, np.ndarray]: ...  # noqa: D102
    @property
    def truth(self) -> Mapping[str, np.ndarray]: ...  # noqa: D102
    @property
    def units(self) -> Mapping[str, str]: ...  # noqa: D102
    @property
    def source(self) -> Source: ...  # noqa: D102


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
    """

    problem: Problem
    objective: str
    output: str
    unit: str
    timeline: Timeline


def pose(name: str, cls: type[Any], timeline: Timeline, wishes: Wishes) -> Posed:
    """The problem of tuning a filter on a recording.

    Args:
        name: what it is called.
        cls: the filter's class, which declares its facts.
        timeline: the data.
        wishes: what the user decides.

    Raises:
        ValueError: for a channel that is needed and missing, an unknown parameter, option or
            objective, and where nothing says how good a run is.
    """
    check_channels(name, cls, timeline)
    filter = set_up(name, cls, timeline, wishes.options)
    objective, output, judged = choose_objective(name, cls, timeline, wishes.objective)
    unit = _unit_of(cls, timeline, objective, output)
    problem = Problem(
        name=name.replace("-", "_"),
        space=space_of(cls, timeline, wishes),
        filter=filter,
        build=None,
        objective=judged,
        data=Data(_inputs(cls, timeline), truth_of(timeline, output)),
        source=timeline.source,
    )
    return Posed(problem, objective, output, unit, timeline)


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
    if timeline.rate_hz is None:
        filter = Timed(filter)
    return Lanes(filter, dt.shape[1]) if dt.ndim == 2 else filter


def _inputs(cls: type[Any], timeline: Timeline) -> Any:
    inputs = inputs_of(cls, timeline.channels)
    return inputs if timeline.rate_hz is not None else TimedSample(timeline.dt, inputs)


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
    made: Objective = find("tuner.objectives", chosen)(output, outputs.get(output))
    if chosen in NO_TRUTH:
        _needs(name, chosen, outputs)
        output = ""
    return chosen, made, output


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


def truth_of(timeline: Timeline, output: str) -> np.ndarray:
    """What outputs are held against: the truth, or zeros that say that every sample counts."""
    if output:
        return np.asarray(timeline.truth[output], float)
    return np.zeros((*np.shape(timeline.dt), 1))


def _unit_of(cls: type[Any], timeline: Timeline, objective: str, output: str) -> str:
    if objective in ("inclination", "heading"):
        return "deg"
    fact = channel_facts(cls, "outputs").get(output or "innovation")
    if fact is None or fact.kind == "attitude":
        return "deg" if fact is not None else ""
    return own_unit(fact.unit, timeline, cls)


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
    scale = scale_of(cls, timeline)
    asked = wishes.start.keys() | wishes.fix.keys() | wishes.bound.keys()
    without = {name for group in optional_groups(cls) if not group & asked for name in group}
    chosen = {
        name: _parameter(name, fact, scale, own_unit(fact.unit, timeline, cls), wishes)
        for name, fact in facts.items()
        if name not in without
    }
    return Space(tuple(chosen.items()))


def scale_of(cls: type[Any], timeline: Timeline) -> float:
    """The noise of the first channel that may have any unit: of its steps; 1 without one."""
    facts = channel_facts(cls, "inputs")
    for name, values in timeline.channels.items():
        if _OWN_UNIT.search(facts[name].unit):
            seen = np.asarray(values, float)
            steps = np.diff(seen[np.isfinite(seen)] if seen.ndim == 1 else seen, axis=0)
            size = float(np.sqrt(np.nanmedian(steps**2)) / 0.95) or float(np.nanstd(seen))
            return size or 1.0
    return 1.0


def own_unit(unit: str, timeline: Timeline, cls: type[Any]) -> str:
    """A declared unit with the data's own in it."""
    facts = channel_facts(cls, "inputs")
    own = next(
        (timeline.units.get(n, "") for n in timeline.channels if _OWN_UNIT.search(facts[n].unit)),
        "",
    )
    if not own:
        return unit
    plain = own if own.isalpha() or ("^" not in own and "/" not in own) else f"({own})"
    return _OWN_UNIT.sub(lambda m: plain + (f"^{m[1]}" if m[1] else ""), unit)


def _parameter(name: str, fact: Param, scale: float, unit: str, wishes: Wishes) -> Parameter:
    if name in wishes.fix:
        return Fixed(wishes.fix[name], unit, meaning=fact.meaning)
    power = _OWN_UNIT.search(fact.unit)
    factor = scale ** int(power[1] or 1) if power else 1.0
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
