"""The innovations of a filter over a recording, and what they say about it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from filters.declared import Channel, bare, channel_facts, in_unit, parameter_facts
from tuner.data.merge import Timeline
from tuner.diagnostics import Diagnostics, Innovations, Remedies, diagnose
from tuner.problem.problem import Problem
from tuner.problem.programs import run_filter
from tuner.run.fit_problem import Posed
from tuner.run.search_space import DEVIATION, own_unit

TURNS = {"rad": (2 * np.pi,), "unit": (2 * np.pi, 360.0)}
"""A full turn by the unit of a measurement; one of which nobody told the unit may be an angle."""


def diagnose_innovations(
    posed: Posed, values: Mapping[str, Any], *, fitted: int = 0
) -> Diagnostics | None:
    """The diagnosis of some parameters' innovations; None for a filter without innovations.

    Args:
        posed: the problem and its data.
        values: all parameters, by name.
        fitted: how many of them were tuned on these innovations.
    """
    cls = type(bare(posed.problem.filter))
    if "innovation" not in channel_facts(cls, "outputs"):
        return None
    found, remedies = innovations_of(posed, values), remedies_of(cls, posed.timeline)
    return diagnose(found, remedies, fitted=fitted)


def innovations(problem: Problem, values: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Innovations and their variances, ``(N, ..., m)``; variances of 0 where nothing counts.

    Of a filter that predicts no variance it is the mean square of those that are not 0.
    """
    if problem.filter is None:
        raise ValueError(f"{problem.name} runs no filter")
    params = problem.made(values)
    outputs = run_filter(problem.filter, params, problem.data.inputs)
    y = np.asarray(outputs.innovation)
    if hasattr(outputs, "variance"):
        return y, np.asarray(outputs.variance)
    square = np.where(y == 0, np.nan, y**2)
    axes = tuple(range(y.ndim - 1))
    there = np.isfinite(square).sum(axis=axes)
    mean = np.nansum(square, axis=axes) / np.maximum(there, 1)
    return y, np.where(y == 0, 0.0, np.broadcast_to(mean, y.shape))


def innovations_of(posed: Posed, values: Mapping[str, Any]) -> Innovations:
    """The innovations with their times, and with what was predicted where that is known."""
    y, s = innovations(posed.problem, values)
    cls, line = type(bare(posed.problem.filter)), posed.timeline
    facts = channel_facts(cls, "outputs")
    fact = facts["innovation"]
    unit = in_unit(fact.unit, own_unit(cls, line))
    measured = _measured(channel_facts(cls, "inputs"), fact, line, y.shape)
    names = fact.axes[: y.shape[-1]] if len(fact.axes) >= y.shape[-1] > 1 else ()
    several = np.ndim(line.dt) == 2
    wide = y if several or y.ndim < 3 else y.reshape(len(y), -1)
    return Innovations.of(
        wide,
        s.reshape(wide.shape),
        times=line.times,
        levels=None if measured is None else np.where(s > 0, measured - y, np.nan),
        names=names,
        unit="" if unit == "unit" else unit,
        turns=TURNS.get(unit, ()),
        predicted="variance" in facts,
    )


def _measured(
    inputs: Mapping[str, Channel], fact: Channel, line: Timeline, shape: tuple[int, ...]
) -> np.ndarray | None:
    """The measurements in the order of the innovations; None where their channel is not clear."""
    given = {n: f for n, f in inputs.items() if n in line.channels and n != DEVIATION}
    alike = {n: f for n, f in given.items() if f.unit == fact.unit}
    axes, columns = fact.axes[: shape[-1]], None
    if axes and all(axis in alike and not alike[axis].axes for axis in axes):
        columns = np.stack([line.channels[axis] for axis in axes], axis=-1)
    elif axes:
        same = [n for n, f in alike.items() if f.axes == axes]
        columns = line.channels[same[0]] if len(same) == 1 else None
    elif len(single := [n for n, f in alike.items() if not f.axes]) == 1:
        columns = line.channels[single[0]][..., None]
    return columns if columns is not None and np.shape(columns) == shape else None


def remedies_of(cls: type[Any], line: Timeline) -> Remedies:
    """The remedies that a filter offers."""
    known = Remedies()
    deviation = DEVIATION in channel_facts(cls, "inputs") and DEVIATION not in line.channels
    way = f"give each measurement's own deviation (--map {DEVIATION}=COLUMN)"
    starts = [
        name
        for name, fact in parameter_facts(cls).items()
        if fact.low is None and "at the start" in fact.meaning and fact.meaning[0] in "dv"
    ]
    wider = f"begin with a larger {' or '.join(starts)} (--start {starts[0]}=...)" if starts else ""
    return Remedies(
        start=wider or known.start,
        level=way if deviation else known.level,
        time=f"{known.time}, or {way}" if deviation else known.time,
    )
