"""Innovations as figures: over time, their size in windows, their correlation, their spread."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tuner.diagnostics import Innovations
from tuner.run.figure import Chart, Line
from tuner.run.report_figure import ReportFigure

WINDOWS = 50
"""Of the NIS over time, at most."""
SMALLEST = 15
"""Numbers of a window at least: the mean of fewer says little."""
LAGS = 25
FEW = 40
"""Of fewer numbers nothing is drawn but they themselves."""


class Windows(NamedTuple):
    """Mean squares of innovations over their variances, window by window, each ``(w,)``.

    Attributes:
        times: of the middle, s.
        nis: the mean squares.
        numbers: how many numbers each is of.
        begin, end: of all times, s.
    """

    times: np.ndarray
    nis: np.ndarray
    numbers: np.ndarray
    begin: float
    end: float


def drawn_innovations(before: Innovations, now: Innovations) -> Iterator[ReportFigure]:
    """The figures, of the values that the search began with and of the tuned ones."""
    if not now.counted.any():
        return
    yield _over_time(now)
    if int(now.counted.sum()) < FEW:
        return
    if now.predicted:
        yield _nis(windows(before) if before.counted.any() else None, windows(now))
    yield _correlation(before, now)
    yield _spread(now)


def _over_time(now: Innovations) -> ReportFigure:
    e, t = now.normalised[:, 0], now.times[:, 0]
    beyond = float(np.mean(np.abs(now.normalised[now.counted]) > 1.96))
    ends = np.array([np.nanmin(t), np.nanmax(t)])
    lines = [Line("95 % expected", ends, np.full(2, -1.96), drawn="band", upper=np.full(2, 1.96))]
    for part, name in enumerate(now.names):
        there = np.isfinite(e[:, part])
        label = name or "innovation"
        lines.append(Line(label, t[there], e[there, part], drawn="points"))
    several = now.value.shape[1] > 1
    return ReportFigure(
        "innovations",
        Chart(
            name="innovations",
            title=f"{100 * beyond:.1f} % of the innovations lie outside the band; 5 % expected",
            x_label="time, s",
            y_label="innovation / its deviation",
            lines=tuple(lines),
        ),
        "Measured less predicted by the tuned filter, over the predicted deviation."
        + (
            f" The first of {now.value.shape[1]} recordings; the share is of all."
            if several
            else ""
        ),
    )


def windows(found: Innovations) -> Windows:
    """The NIS in windows of time, of all recordings one after another by their own clocks."""
    counted = found.counted
    t = np.broadcast_to(found.times[:, :, None], counted.shape)[counted]
    with np.errstate(over="ignore"):
        square = found.normalised[counted] ** 2
    order = np.argsort(t, kind="stable")
    count = int(np.clip(len(t) // SMALLEST, 1, WINDOWS))
    parts = np.array_split(order, count)
    return Windows(
        np.array([t[part].mean() for part in parts]),
        np.array([square[part].mean() for part in parts]),
        np.array([len(part) for part in parts]),
        float(t.min()),
        float(t.max()),
    )


def _nis(before: Windows | None, now: Windows) -> ReportFigure:
    from tuner.distributions import chi_square_at

    low, high = (chi_square_at(q, now.numbers) / now.numbers for q in (0.025, 0.975))
    inside = int(((now.nis >= low) & (now.nis <= high)).sum())
    lines = [Line("95 % expected", _to_ends(now), low, drawn="band", upper=high)]
    lines += [] if before is None else [Line("before", before.times, before.nis)]
    lines.append(Line("tuned", now.times, now.nis))
    values = np.concatenate([line.y for line in lines])
    values = values[np.isfinite(values)]
    wide = bool((values > 0).all() and values.max() / values.min() > 30)
    chart = Chart(
        name="nis",
        title=f"The NIS lies in its band in {inside} of {len(now.nis)} windows; "
        f"{0.95 * len(now.nis):.0f} are expected",
        x_label="time, s",
        y_label="NIS",
        lines=tuple(lines),
        log="y" if wide else "",
    )
    numbers = int(np.median(now.numbers))
    return ReportFigure(
        "innovations",
        chart,
        f"Mean square of the normalised innovations in windows of {numbers}: 1 where the filter's "
        "variances are right, above where they are too small.",
    )


def _to_ends(found: Windows) -> np.ndarray:
    """The times, the first and the last moved to the ends of the recording."""
    times = found.times.copy()
    times[0], times[-1] = found.begin, found.end
    return times


def _correlation(before: Innovations, now: Innovations) -> ReportFigure:
    lags = max(1, min(LAGS, min(len(column) for column in now.columns) // 4))
    at, numbers = np.arange(1, lags + 1), sum(map(len, now.columns))
    r, r_before = (_correlations(each, lags) for each in (now, before))
    band = 1.96 / np.sqrt(numbers)
    outside = int((np.abs(r) > band).sum())
    largest = int(np.argmax(np.abs(r)))
    title = (
        f"{outside} of {lags} correlations lie outside the band; {0.05 * lags:.0f} would by chance"
    )
    ends = np.array([0.5, lags + 0.5])
    lines = (
        Line("95 % of white noise", ends, np.full(2, -band), drawn="band", upper=np.full(2, band)),
        Line("before", at.astype(float), r_before, drawn="points"),
        Line("tuned", at.astype(float), r, drawn="points"),
    )
    chart = Chart("whiteness", title, "lag, samples", "correlation", lines)
    return ReportFigure(
        "innovations",
        chart,
        "Innovations of a consistent filter are white: uncorrelated. The largest correlation is "
        f"{r[largest]:+.2f} at lag {largest + 1}.",
    )


def _correlations(found: Innovations, lags: int) -> np.ndarray:
    """Over all measurements, by their numbers; ``(lags,)``."""
    if not found.columns:
        return np.full(lags, np.nan)
    weights = np.array([len(column) for column in found.columns], float)
    each = [[column.correlation(lag + 1) for lag in range(lags)] for column in found.columns]
    return np.asarray(weights @ np.array(each) / weights.sum())


def _spread(now: Innovations) -> ReportFigure:
    e = now.normalised[now.counted]
    count = int(np.clip(np.sqrt(len(e)), 9, 41))
    edges = np.linspace(-4.0, 4.0, count + 1)
    found, _ = np.histogram(np.clip(e, -4.0, 4.0), edges)
    density = found / (len(e) * np.diff(edges))
    steps = np.repeat(edges, 2)[1:-1]
    x = np.linspace(-4.0, 4.0, 121)
    lines = (
        Line("innovations", steps, np.zeros(len(steps)), drawn="band", upper=np.repeat(density, 2)),
        Line("normal", x, np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi)),
    )
    beyond = int((np.abs(e) > 4).sum())
    expected = 6.33e-5 * len(e)
    title = f"{beyond} of {len(e)} innovations lie beyond four deviations; {expected:.2g} expected"
    chart = Chart("spread", title, "innovation / its deviation", "density", lines)
    note = "Distribution of the innovations, and the normal one of a consistent filter. "
    return ReportFigure(
        "innovations", chart, note + "Values beyond the axis are counted at its ends."
    )
