"""A fit as one picture: what was measured and estimated, the innovations, and held-out data."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from filters.declared import bare, channel_facts, output
from tuner.diagnostics import Innovations
from tuner.run.drawing import COLOURS, draw, entitle, new_canvas
from tuner.run.figure import Chart, Figure, Line
from tuner.run.fit_figures import POINTS, figures, normalised
from tuner.run.fit_problem import Posed
from tuner.run.held_out import HeldOut
from tuner.run.innovation_diagnostics import innovations_of
from tuner.run.judgement import Judged
from tuner.run.study import Solutions, best

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

MOST = 3
"""Parts of a measurement that are drawn; a picture of more shows none well."""
BARS = {"before": "0.65", "tuned": COLOURS[0], "no filter": COLOURS[1], "best there": COLOURS[2]}


def plotted(posed: Posed, solutions: Solutions, judged: Judged) -> "Canvas":
    """The picture: panels below each other."""
    solution = best(posed.problem.name, solutions)
    tuned = {name: parameter.value for name, parameter in solution.parameters.items()}
    charts = [*_panels(posed, tuned), *_others(posed, solutions, tuned)]
    held = judged.held_out
    heights = [3.0] * len(charts) + ([1.6] if held is not None else [])
    canvas = new_canvas((9.0, sum(heights)))
    axes = canvas.subplots(len(heights), squeeze=False, height_ratios=heights)[:, 0]
    for chart, place in zip(charts, axes, strict=False):
        draw(chart, canvas, place)
    if held is not None:
        _draw_held_out(held, judged.unit, axes[-1])
    return canvas


def _others(posed: Posed, solutions: Solutions, tuned: Mapping[str, Any]) -> Iterator[Figure]:
    """The error against a truth, and innovations over their deviations."""
    drawn = [*figures(posed, solutions)][:MOST]
    likely = posed.objective == "likelihood"
    if not likely and posed.output:
        yield from drawn
    if "innovation" not in channel_facts(bare(posed.problem.filter), "outputs"):
        return
    yield normalised(posed, tuned)


def _panels(posed: Posed, tuned: Mapping[str, Any]) -> Iterator[Chart]:
    """The measurements beside the predictions and estimates, part by part."""
    if "innovation" not in channel_facts(bare(posed.problem.filter), "outputs"):
        return
    found = innovations_of(posed, tuned)
    if found.levels is None:
        return
    estimate = estimate_of(posed, tuned, found)
    for part, name in list(enumerate(found.names))[:MOST]:
        yield _panel(posed, found, part, name, estimate)


def _panel(
    posed: Posed,
    found: Innovations,
    part: int,
    name: str,
    estimate: tuple[str, np.ndarray] | None,
) -> Chart:
    assert found.levels is not None
    t, level = found.times[:, 0], found.levels[:, 0, part]
    y, s = found.value[:, 0, part], found.variance[:, 0, part]
    seen = found.counted[:, 0, part] & np.isfinite(level)
    spread = 2 * np.sqrt(np.where(seen, s, 0.0))
    rows = _few(seen)
    lines = [
        Line(
            "expected range of 95 % of measurements",
            t[rows],
            (level - spread)[rows],
            drawn="band",
            upper=(level + spread)[rows],
        ),
        Line("measured", t[rows], (level + y)[rows], drawn="points"),
    ]
    if estimate is not None:
        label, columns = estimate
        there = _few(np.isfinite(columns[:, part]))
        lines.append(Line(label, t[there], columns[there, part]))
    else:
        lines.append(Line("predicted", t[rows], level[rows]))
    called = name or "measurement"
    inside = 100 * np.mean(np.abs(y[seen]) <= spread[seen]) if seen.any() else np.nan
    of = f" of {name}" * bool(name) + ", first recording," * (found.value.shape[1] > 1)
    return Chart(
        name=called,
        title=f"{inside:.3g} % of the measurements{of} lie in the band where 95 % are expected",
        x_label="time, s",
        y_label=f"{called}, {found.unit}" if found.unit else called,
        lines=tuple(lines),
    )


def estimate_of(
    posed: Posed, tuned: Mapping[str, Any], found: Innovations
) -> tuple[str, np.ndarray] | None:
    """The output, ``(N, m)``, that estimates what is measured: the first of its unit and parts."""
    problem = posed.problem
    facts = channel_facts(bare(problem.filter), "outputs")
    unit, parts = facts["innovation"].unit, found.value.shape[2]
    outputs = posed.run(tuned)
    for name, fact in facts.items():
        if fact.kind in ("detail", "attitude") or fact.unit != unit:
            continue
        whole = np.asarray(output(problem.filter, outputs, name), float)  # NaN of an output that
        first = whole[:, 0] if whole.ndim and found.value.shape[1] > 1 else whole  # is left out
        columns = first.reshape(len(found.times), -1) if first.size > 1 else first
        if columns.ndim == 2 and columns.shape[1] == parts:
            return name, columns
    return None


def _few(there: np.ndarray) -> np.ndarray:
    """The rows that are there, of many every so many."""
    rows = np.flatnonzero(there)
    if len(rows) > POINTS:
        rows = rows[np.linspace(0, len(rows) - 1, POINTS).astype(int)]
    return rows


def _draw_held_out(held: HeldOut, unit: str, axes: "Axes") -> None:
    """Bars: the values before, the tuned filter, no filter, and the best that there is, there."""
    bars = {"before": held.start, "tuned": held.tuned}
    if held.unfiltered is not None:
        bars["no filter"] = held.unfiltered
    if held.best is not None:
        bars["best there"] = held.best
    names = [name for name, value in bars.items() if np.isfinite(value)]
    values = [bars[name] for name in names]
    drawn = axes.barh(names, values, color=[BARS[name] for name in names], height=0.6)
    axes.bar_label(drawn, fmt="%.4g", padding=3, fontsize=8)
    axes.set_xlim(0, 1.12 * max(values, default=1.0))
    axes.invert_yaxis()
    entitle(axes, _outcome(held))
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_xlabel(f"error, {unit}" if unit else "error")
    axes.grid(axis="x", alpha=0.25, lw=0.6)


def _outcome(held: HeldOut) -> str:
    """The finding of the bars, in a sentence."""
    share = held.gain.share if held.gain is not None else np.nan
    if not np.isfinite(share):
        return f"On {held.what}, tuned on the rest"
    change = f"{abs(100 * share):.2g} % {'less' if share >= 0 else 'more'} error than before"
    return f"Tuned on the rest, {change} on {held.what}"
