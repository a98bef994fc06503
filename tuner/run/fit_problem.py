"""From a filter and a recording to the problem that tunes the one on the other."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from typing import Any

import jax.numpy as jnp
import numpy as np

from filters import Lanes, Timed, TimedSample
from filters.declared import Channel, channel_facts, declaration, in_unit, inputs_of, optional
from objectives import Data, Objective
from tuner.catalogue import find
from tuner.data.merge import Timeline
from tuner.data.source import Source
from tuner.data.units import change
from tuner.identifiability.determined import Determined
from tuner.names import unknown
from tuner.problem.exported import exported_of
from tuner.problem.problem import Problem
from tuner.problem.programs import run_filter
from tuner.problem.space import Space
from tuner.run.excluded_stretches import ExcludedStretches, without_stretches
from tuner.run.gate import NAMES, care_of, guarded, with_noise
from tuner.run.search_space import Wishes, own_unit, sizes_of, space_of

HEADING = frozenset(("mag", "gps", "gps_vel"))
"""Inputs that show a heading; without one an attitude is judged by its inclination."""
NO_TRUTH = ("likelihood", "prediction")
"""Objectives that need no truth."""


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
        undetermined: what of the noise no such measurements tell, a sentence each.
        left_out: stretches that contradict the rest; None where none were looked for.
        known: the noise that differences of its measurements tell; None where none is looked for,
            or they tell none.
    """

    problem: Problem
    objective: str
    output: str
    unit: str
    timeline: Timeline
    source: Source
    notes: tuple[str, ...] = ()
    undetermined: tuple[str, ...] = ()
    left_out: ExcludedStretches | None = None
    known: Determined | None = None

    def run(self, values: Mapping[str, Any]) -> Any:
        """The filter's outputs for parameters given by name, over all data."""
        params = self.problem.made(values)
        assert self.problem.filter is not None
        return run_filter(self.problem.filter, params, self.problem.data.inputs)


def pose(name: str, cls: type[Any], timeline: Timeline, wishes: Wishes, source: Source) -> Posed:
    """The problem of tuning a filter on a recording.

    Args:
        name: what it is called.
        cls: the filter's class, which declares its facts.
        timeline: the data.
        wishes: what the user decides.
        source: where the data come from.

    Raises:
        ValueError: for an unknown parameter, option or objective, and where nothing says how good
            a run is.
    """
    cls, options = with_noise(cls, wishes.options, timeline.step)
    care, options = care_of(cls, options)
    filter = set_up(name, cls, timeline, options)
    objective, judged, output = choose_objective(name, cls, timeline, wishes.objective)
    unit = _unit_of(cls, timeline, objective, output)
    outputs = channel_facts(cls, "outputs")
    data = Data(_inputs(cls, timeline), truth_of(timeline, outputs.get(output), output))
    left_out = None
    if care.stretches is not None:
        whole = Problem(name, Space.of_filter(cls), filter, None, judged, data)
        data, left_out = without_stretches(whole, care.stretches, timeline.times)
    sizes = sizes_of(cls, filter, judged, data)
    typical = space_of(cls, timeline, replace(wishes, start={}), sizes)
    filter, judged = guarded(care, filter, judged, typical, data.inputs)
    problem = Problem(
        name=name.replace("-", "_"),
        space=space_of(cls, timeline, wishes, sizes),
        filter=filter,
        build=None,
        objective=judged,
        data=data,
        source=source,
        exported=exported_of(filter, own_unit(cls, timeline)),
    )
    return Posed(problem, objective, output, unit, timeline, source, left_out=left_out)


def check_channels(name: str, cls: type[Any], timeline: Timeline) -> None:
    """Refuse channels that are missing, that the filter does not know, or that do not fit it.

    Raises:
        ValueError: with what the filter needs.
    """
    facts = channel_facts(cls, "inputs")
    for given in timeline.channels:
        if given not in facts:
            raise unknown("channel", given, facts)
        _check_parts(given, facts[given], timeline.channels[given], timeline)
        _check_unit(given, facts[given], timeline.units.get(given, ""))
    for needed, fact in facts.items():
        if needed not in timeline.channels and needed not in optional(cls):
            inside = f" in {fact.unit}" if fact.unit else ""
            raise ValueError(
                f"{name} needs {needed} ({fact.meaning}{inside}), which is not mapped; give it "
                f"with --map {needed}={_columns(fact)}[:UNIT]"
            )


def _columns(fact: Channel) -> str:
    return ",".join(["COLUMN"] * max(len(fact.axes), 1))


def _check_parts(name: str, fact: Channel, values: np.ndarray, timeline: Timeline) -> None:
    """Refuse a channel that has not the parts that the filter takes."""
    parts = np.shape(values)[np.ndim(timeline.dt) :]
    if parts != ((len(fact.axes),) if fact.axes else ()):
        has = f"{parts[0]} parts" if parts else "one part"
        needs = (
            f"{len(fact.axes)}: {', '.join(fact.axes)}" if fact.axes else "one number per sample"
        )
        raise ValueError(f"{name} has {has}, and the filter takes {needs}")


def _check_unit(name: str, fact: Channel, unit: str) -> None:
    """Refuse a channel of another dimension; one that is told in no unit is in that declared."""
    if unit and fact.unit:
        try:
            change(unit, fact.unit)
        except ValueError as error:
            raise ValueError(f"{name!r} {error}") from None


def set_up(name: str, cls: type[Any], timeline: Timeline, options: Mapping[str, Any]) -> Any:
    """The filter for a timeline: of its rate, or taking the times as they come; k side by side.

    Raises:
        ValueError: for an unknown option, and varying times that the filter cannot take.
    """
    known = {each.name: each for each in fields(cls)}
    for option in options:
        if option not in known or option == "dt":
            raise unknown(f"option of {name}", option, [*(n for n in known if n != "dt"), *NAMES])
    given = {} if "dt" not in known else {"dt": timeline.step}
    _check_complete(name, known, {**given, **options})
    filter = cls(**given, **options)
    if hasattr(filter, "given"):
        filter = filter.given(frozenset(timeline.channels))
    if timeline.rate_hz is None:
        filter = Timed(filter)
    shape = np.shape(timeline.dt)
    return Lanes(filter, shape[1]) if len(shape) == 2 else filter


def _check_complete(name: str, known: Mapping[str, Any], given: Mapping[str, Any]) -> None:
    """Refuse a class with fields that nobody gives."""
    for field, each in known.items():
        unset = each.default is MISSING and each.default_factory is MISSING
        if unset and each.init and field not in given:
            raise ValueError(
                f"{name} needs {field}, a field without a default; give it with --set {field}=..., "
                "or a default in the class"
            )


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
        if given not in outputs or outputs[given].kind == "detail":
            known = [n for n, fact in outputs.items() if fact.kind != "detail"]
            raise unknown(f"output of {name}", given, known)
    if len(timeline.truth) > 1:
        raise ValueError(
            f"there are truths for {' and '.join(timeline.truth)}, and a fit has one; give one, "
            "since errors in different units cannot be added"
        )
    output = next(iter(timeline.truth), "")
    chosen = wished or _by_what_there_is(name, cls, outputs.get(output), timeline)
    alone = isinstance(declaration(cls, "outputs"), Mapping)  # one array has no field of a name
    of = "" if alone else output
    made: Objective = find("tuner.objectives", chosen)(of, _as_given(outputs, output, timeline))
    if chosen in NO_TRUTH:
        _needs(name, chosen, outputs)
        if output:
            raise ValueError(
                f"the objective {chosen} takes no truth, and one of {output} is given; leave out "
                "one of them"
            )
    return chosen, made, output


def _as_given(outputs: Mapping[str, Channel], output: str, timeline: Timeline) -> Channel | None:
    """The output's facts, with the axes that its truth has: the first of those declared."""
    fact = outputs.get(output)
    if fact is None:
        return None
    if not fact.axes:
        _check_parts(f"the truth of {output}", fact, timeline.truth[output], timeline)
        return fact
    parts, there = np.shape(truth_of(timeline, fact, output))[-1], len(fact.axes)
    if parts > there or (fact.kind == "attitude" and parts != there):
        raise ValueError(
            f"the truth of {output} has {parts} parts, and the filter outputs {there}: "
            f"{', '.join(fact.axes)}"
        )
    return fact._replace(axes=fact.axes[:parts])


def _needs(name: str, objective: str, outputs: Mapping[str, Channel]) -> None:
    lacking = [part for part in ("innovation", "variance") if part not in outputs]
    first = next(iter(outputs))
    if "innovation" in lacking or (objective == "likelihood" and lacking):
        raise ValueError(
            f"{name} outputs no {' and no '.join(lacking)}, so it has no {objective}; give a truth "
            f"for one of its outputs, such as --truth {first}={_columns(outputs[first])}"
        )


def _by_what_there_is(name: str, cls: type[Any], truth: Channel | None, timeline: Timeline) -> str:
    """With a truth its error; without one the likelihood of the innovations, or their size."""
    if truth is not None:
        blind = truth.kind == "attitude" and not HEADING & timeline.channels.keys()
        return "inclination" if blind else "rmse"
    return "prediction" if "variance" not in channel_facts(cls, "outputs") else "likelihood"


def truth_of(timeline: Timeline, fact: Channel | None, output: str) -> np.ndarray:
    """The reference of the outputs: the truth, or zeros where any channel was measured.

    The truth of an output with axes has them last, also where it is one alone.
    """
    if not output:
        shape = np.shape(timeline.dt)
        empty = [np.isnan(v.reshape(*shape, -1)).all(axis=-1) for v in timeline.channels.values()]
        return np.where(np.logical_and.reduce(empty), np.nan, 0.0)[..., None]
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
