"""The estimates before and after tuning that no measurement stands beside."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from filters.declared import bare, channel_facts, in_unit, output
from tuner.run.figure import Chart, Line
from tuner.run.fit_problem import Posed
from tuner.run.report_figure import ReportFigure
from tuner.run.search_space import own_unit


def estimates(
    posed: Posed, begun: Mapping[str, Any], tuned: Mapping[str, Any], most: int
) -> Iterator[ReportFigure]:
    """The first outputs of a filter over time, a chart for each part.

    Args:
        posed: the problem and its data.
        begun: the parameters that the search began with, by name.
        tuned: those that were found.
        most: so many charts at most.
    """
    filter = posed.problem.filter
    facts = channel_facts(bare(filter), "outputs")
    runs = {"before": posed.run(begun), "tuned": posed.run(tuned)}
    several = np.ndim(posed.timeline.dt) == 2
    t = posed.timeline.times[:, 0] if several else posed.timeline.times
    left = most
    for name, fact in facts.items():
        if fact.kind == "detail":
            continue
        whole = {w: np.asarray(output(filter, run, name), float) for w, run in runs.items()}
        if any(each.ndim == 0 for each in whole.values()):  # an output that is left out
            continue
        first = {when: each[:, 0] if several else each for when, each in whole.items()}
        columns = {when: each.reshape(len(each), -1) for when, each in first.items()}
        parts = columns["tuned"].shape[1]
        axes = fact.axes if len(fact.axes) >= parts > 1 else [""] * parts
        unit = in_unit(fact.unit, own_unit(type(bare(filter)), posed.timeline))
        for part in range(min(parts, left)):
            called = f"{name} {axes[part]}".rstrip()
            lines = [_line(when, t, each[:, part]) for when, each in columns.items()]
            label = f"{called}, {unit}" if unit and unit != "unit" else called
            title = f"The filter's {called}, before and tuned"
            chart = Chart(f"estimate_{name}_{part}", title, "time, s", label, tuple(lines))
            yield ReportFigure(
                "signal", chart, "The first recording of several." if several else ""
            )
        left -= min(parts, left)


def _line(when: str, t: np.ndarray, values: np.ndarray) -> Line:
    there = np.isfinite(values) & np.isfinite(t)
    return Line(when, t[there], values[there])
