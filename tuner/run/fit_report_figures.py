"""The figures of a fit's report: the signal, the innovations, and the cost around the optimum."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from filters.declared import bare, channel_facts
from tuner.certificate.solution import Status
from tuner.diagnostics import Innovations
from tuner.run.estimate_figures import estimates
from tuner.run.figure import Chart, Line
from tuner.run.fit_figures import figures
from tuner.run.fit_plot import estimate_of
from tuner.run.fit_problem import Posed
from tuner.run.fit_surface import surface
from tuner.run.front import Against, picture_of, trade
from tuner.run.innovation_diagnostics import innovations_of
from tuner.run.innovation_figures import drawn_innovations
from tuner.run.report_figure import ReportFigure
from tuner.run.spectrum_figure import spectra
from tuner.run.study import Solutions, best

MOST = 4
"""Parts of a measurement or a truth that are drawn."""


def report_figures(
    posed: Posed, solutions: Solutions, against: Against | None
) -> Iterator[ReportFigure]:
    """The figures of a fit's report, in their order."""
    solution = best(posed.problem.name, solutions)
    if solution.status is Status.FAILED:
        return
    tuned = {name: parameter.value for name, parameter in solution.parameters.items()}
    if posed.output:
        note = "The first recording of several." if np.ndim(posed.timeline.dt) == 2 else ""
        for figure in [*figures(posed, solutions)][:MOST]:
            yield ReportFigure("signal", figure, note)
    if "innovation" in channel_facts(bare(posed.problem.filter), "outputs"):
        begun = posed.problem.parameters(posed.problem.space.start())
        before, now = innovations_of(posed, begun), innovations_of(posed, tuned)
        if now.levels is None and not posed.output:
            yield from estimates(posed, begun, tuned, MOST)
        yield from _signals(posed, begun, tuned, now)
        yield from drawn_innovations(before, now)
    yield from surface(posed.problem, solution)
    if against is not None:
        note = "No other point is better in both objectives. The knee is the best compromise."
        yield from (
            ReportFigure("search", each, note) for each in picture_of(posed, trade(against))
        )


def _signals(
    posed: Posed, begun: Mapping[str, Any], tuned: Mapping[str, Any], now: Innovations
) -> Iterator[ReportFigure]:
    """Each part of what was measured, with what was predicted and the estimate before and after."""
    if now.levels is None:
        return
    estimates = {
        when: found[1]
        for when, values in (("before", begun), ("tuned", tuned))
        if (found := estimate_of(posed, values, now)) is not None
    }
    rejected = getattr(posed.run(tuned), "rejected", None)
    rate = posed.timeline.rate_hz
    for part, name in list(enumerate(now.names))[:MOST]:
        each = {when: estimate[:, part] for when, estimate in estimates.items()}
        channel, values = _channel(posed, now, part)
        called = name or channel
        wrong = np.zeros(len(values), bool) if rejected is None else _part(rejected, now, part)
        yield _signal(now, part, called, each, np.where(wrong, values, np.nan))
        if rate is not None and "tuned" in each and not wrong.any():
            yield from spectra(called, now.unit, rate, measured=values, tuned=each["tuned"])


def _part(array: Any, now: Innovations, part: int) -> np.ndarray:
    """A part of the first recording, ``(N,)``."""
    found = np.asarray(array).reshape(now.value.shape[0], -1, now.value.shape[2])[:, 0, part]
    return np.asarray(found > 0)


def _channel(posed: Posed, now: Innovations, part: int) -> tuple[str, np.ndarray]:
    """Name and values of the channel of a measurement, found by its numbers; "" for none."""
    assert now.levels is not None
    measured, seen = (now.levels + now.value)[:, 0, part], now.counted[:, 0, part]
    for name, values in posed.timeline.channels.items():
        own = values[:, 0] if np.ndim(posed.timeline.dt) == 2 else values
        for each in own.reshape(len(own), -1).T:
            if np.allclose(each[seen], measured[seen]):
                return name, each
    return "", np.full(len(measured), np.nan)


def _signal(
    now: Innovations,
    part: int,
    name: str,
    estimates: Mapping[str, np.ndarray],
    rejected: np.ndarray,
) -> ReportFigure:
    """One measurement.

    Args:
        now: the innovations of the tuned filter.
        part: which of its measurements.
        name: what that is called.
        estimates: of it, ``(N,)``, before and after.
        rejected: measurements that a gate rejected, ``(N,)``; NaN elsewhere.
    """
    assert now.levels is not None
    t, level = now.times[:, 0], now.levels[:, 0, part]
    y, s = now.value[:, 0, part], now.variance[:, 0, part]
    seen = now.counted[:, 0, part] & np.isfinite(level)
    t_seen, predicted, spread = t[seen], level[seen], 1.96 * np.sqrt(s[seen])
    lines = [
        Line("95 % expected", t_seen, predicted - spread, drawn="band", upper=predicted + spread),
        Line("measured", t_seen, predicted + y[seen], drawn="points"),
    ]
    for when, values in estimates.items():
        there = np.isfinite(values) & np.isfinite(t)
        lines.append(Line(when, t[there], values[there]))
    if not estimates:
        lines.append(Line("predicted", t_seen, predicted))
    wrong = np.isfinite(rejected) & np.isfinite(t)
    if wrong.any():
        lines.append(Line("rejected", t[wrong], rejected[wrong], drawn="points"))
    inside = float(np.mean(np.abs(y[seen]) <= spread)) if seen.any() else 0.0
    called = name or "measurement"
    title = f"{100 * inside:.1f} % of the measurements{f' of {name}' if name else ''} lie in the "
    note = "The band is what the tuned filter predicts of each measurement, before it is seen."
    if now.value.shape[1] > 1:
        note += f" The first of {now.value.shape[1]} recordings."
    chart = Chart(
        name=f"signal_{part}",
        title=f"{title}band where 95 % are expected",
        x_label="time, s",
        y_label=f"{called}, {now.unit}" if now.unit else called,
        lines=tuple(lines),
    )
    return ReportFigure("signal", chart, note)
