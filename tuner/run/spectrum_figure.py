"""The spectra of a measurement and of its estimate."""

from collections.abc import Iterator

import numpy as np

from tuner.run.figure import Chart, Line
from tuner.run.report_figure import ReportFigure

FEW = 256
"""Samples at least; fewer have no spectrum worth a look."""
SEGMENT = 1024
LINES = 300
"""Of a curve, at equal distances of the frequency's logarithm."""


def spectra(
    name: str, unit: str, rate_hz: float, *, measured: np.ndarray, tuned: np.ndarray
) -> Iterator[ReportFigure]:
    """The spectra of both; nothing where samples are missing or few.

    Args:
        name: of the measurement.
        unit: of both.
        rate_hz: samples per second.
        measured: the measurement, ``(N,)``.
        tuned: its estimate.
    """
    there = np.isfinite(measured) & np.isfinite(tuned)
    if len(measured) < FEW or not there.all() or not np.ptp(measured) > 0:
        return
    length = min(SEGMENT, len(measured) // 4)
    f = np.fft.rfftfreq(length, 1 / rate_hz)[1:]
    before, after = (density(each, rate_hz, length)[1:] for each in (measured, tuned))
    if not (before > 0).all() or not (after > 0).all():
        return
    passed = _smooth(after) / _smooth(before)
    below = np.flatnonzero(passed < 0.5)
    title = "The filter follows all that is measured"
    if len(below):
        title = f"The filter follows up to {f[below[0]]:.2g} Hz and smooths what is faster"
    rows = np.unique(np.searchsorted(f, np.geomspace(f[0], f[-1], LINES)).clip(0, len(f) - 1))
    called = name or "measurement"
    whole = f"({unit})" if set(unit) & set("/*^ ") else unit
    squared = f", {whole}^2/Hz" if unit else ""
    chart = Chart(
        name=f"spectrum_{called}",
        title=title,
        x_label="frequency, Hz",
        y_label=f"density of {called}{squared}",
        lines=(Line("measured", f[rows], before[rows]), Line("tuned", f[rows], after[rows])),
        log="xy",
    )
    note = "Power densities by Welch's method. At that frequency half of the power passes."
    yield ReportFigure("signal", chart, note)


def density(values: np.ndarray, rate_hz: float, length: int) -> np.ndarray:
    """One-sided power density by Welch's method, ``(length // 2 + 1,)``, in unit^2/Hz.

    Segments of Hann's window that overlap by half, each without its mean. Source: Welch, IEEE
    Transactions on Audio and Electroacoustics 15, 1967. As ``scipy.signal.welch``, which takes
    half a second to import.

    Args:
        values: ``(N,)``, without a missing one.
        rate_hz: samples per second.
        length: of a segment.
    """
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(length) / length)
    parts = np.lib.stride_tricks.sliding_window_view(values, length)[:: length - length // 2]
    parts = parts - parts.mean(axis=1, keepdims=True)
    power = (np.abs(np.fft.rfft(parts * window)) ** 2).mean(axis=0)
    power[1 : (length + 1) // 2] *= 2  # of both signs; the last one, of an even length, has none
    return np.asarray(power / (rate_hz * (window @ window)))


def _smooth(values: np.ndarray) -> np.ndarray:
    """Means over five neighbours."""
    wide = np.pad(values, 2, mode="edge")
    return np.convolve(wide, np.full(5, 0.2), mode="valid")
