"""A barometer's port errors, rejected or masked: ``python -m benchmarks.rocket_outliers FILE``.

The file is a rocket's recording (NPZ with ``t_baro``, s, and ``press_pa``, Pa). A constant velocity
is tuned on its heights at 25 Hz three times: on all of them; on those that a person keeps who looks
at the plot, without the intervals in which pressure at the port is not that of the air; and on all
of them behind a gate, or with Student's t. Its two numbers should be those of the second.
"""

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

import tuner

THINNED = 10
"""Every tenth height is taken: about 25 Hz."""
STANDARD = (44330.77, 0.190263)
"""Of the height, m, in the standard atmosphere by the pressure over that on the ground."""


class Span(NamedTuple):
    """A part of the flight, and the intervals that a person masks in it, s."""

    name: str
    start: float
    end: float
    masked: tuple[tuple[float, float], ...]


SPANS = (
    Span("descent", 31.3, 132.5, ((31.8, 43.4),)),
    Span("whole recording", 0.0, 200.0, ((15.6, 43.4), (132.9, 137.0))),
)
"""Of jackpot_2: port errors to 46 m from the ejection on, to 575 m from burnout on."""
WAYS: Mapping[str, Mapping[str, Any]] = {
    "stretches 4": {"stretches": 4},
    "gate 4, patience 2": {"gate": 4, "patience": 2},
    "gate 4, patience 3": {"gate": 4, "patience": 3},
    "gate 4, patience 10": {"gate": 4},
    "Student 2, patience 3": {"student": 2, "patience": 3},
    "Student 1, patience 3": {"student": 1, "patience": 3},
}


class Row(NamedTuple):
    """The result of a fit."""

    span: str
    way: str
    q: float
    R: float
    status: str
    said: str


def heights(t: np.ndarray, pressure: np.ndarray, span: Span) -> tuple[np.ndarray, np.ndarray]:
    """Times and heights over the ground of a span, thinned.

    >>> t = np.arange(400.0)
    >>> heights(t, np.full(400, 101325.0), Span("all", 0.0, 1e3, ()))[1].max().item()
    0.0
    """
    scale, power = STANDARD
    h = scale * (1 - (pressure / np.median(pressure[:200])) ** power)
    inside = (t > span.start) & (t < span.end)
    return t[inside][::THINNED], h[inside][::THINNED]


def masked(t: np.ndarray, h: np.ndarray, span: Span) -> np.ndarray:
    """The heights without those of the span's intervals.

    >>> masked(np.arange(4.0), np.ones(4), Span("", 0, 9, ((0.5, 2.5),))).tolist()
    [1.0, nan, nan, 1.0]
    """
    gone = np.any([(t > a) & (t < b) for a, b in span.masked], axis=0)
    return np.where(gone, np.nan, h)


def rows(t: np.ndarray, pressure: np.ndarray, starts: int) -> Iterator[Row]:
    """Every span in every way."""
    for span in SPANS:
        times, h = heights(t, pressure, span)
        yield fitted(span.name, "all", times, h, {}, starts)
        yield fitted(span.name, "masked by hand", times, masked(times, h, span), {}, starts)
        for way, options in WAYS.items():
            yield fitted(span.name, way, times, h, options, starts)


def fitted(
    span: str, way: str, t: np.ndarray, h: np.ndarray, options: Mapping[str, Any], starts: int
) -> Row:
    """One fit; a gate is not smooth, so a search without derivatives does better."""
    fit = tuner.fit(
        "constant-velocity",
        tuner.Record.of({"x": h}, times=t, units={"x": "m"}),
        options=options,
        starts=starts,
        hold_out=False,
        solver="nelder-mead",
    )
    q, R = (float(fit.solution.parameters[name].value) for name in ("q", "R"))
    told = [each.words for each in (fit.judged.left_out, fit.judged.rejected) if each is not None]
    return Row(span, way, q, R, fit.solution.status.value, "; ".join(told))


def main(arguments: list[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rocket_outliers")
    parser.add_argument("file", type=Path, help="the recording, NPZ")
    parser.add_argument("--starts", type=int, default=3)
    asked = parser.parse_args(arguments)
    data = np.load(asked.file)
    table = Table("span", "way", "q m^2/s^3", "R m^2", "q / masked", "R / masked", "status", "said")
    right: Row | None = None
    for row in rows(data["t_baro"], data["press_pa"].astype(float), asked.starts):
        right = row if row.way == "masked by hand" else right
        known = right if right is not None and right.span == row.span else None
        over = [f"{row.q / known.q:.3g}", f"{row.R / known.R:.3g}"] if known else ["", ""]
        table.add_row(row.span, row.way, f"{row.q:.4g}", f"{row.R:.4g}", *over, *row[4:])
    Console(width=180, file=sys.stdout).print(table)


if __name__ == "__main__":
    main()
