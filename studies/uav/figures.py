"""Innovations in their band, attitude beside the autopilot's, and the glitch."""

from collections.abc import Iterator

import numpy as np

from studies.uav.flights import Flight
from studies.uav.judging import Field, Outcome
from studies.uav.prediction import AHEAD, predicted
from studies.uav.problems import LAWS
from studies.uav.settings import ANGLES
from tuner.run.figure import Chart, Figure, Line
from tuner.run.study import Solutions

NAMES = {"phi": "roll", "theta": "pitch", "psi": "heading"}


def figures(field: Field, solutions: Solutions) -> Iterator[Figure]:
    """All figures."""
    calm = [flight for flight in field.judged if not flight.jumps]
    for flight in calm or field.flights[-1:]:
        outcome = field.tuned_outcome(flight, "constant", solutions)
        for i, name in enumerate(ANGLES):
            if name in field.measured:
                yield _innovations(flight, outcome, i)
            yield _attitude(flight, outcome, i)
    for flight in field.flights:
        if flight.jumps:
            yield _glitch(field, flight, solutions)
    for flight in field.flights:
        found = predicted(flight, field.tuned_outcome(flight, "constant", solutions))
        believed = ~found.glitch
        if not believed.any():
            continue
        ahead = np.arange(1.0, AHEAD + 1)
        curves = {"filter": found.horizontal, "straight on": found.straight}
        if found.reference is not None:
            curves["autopilot's attitude"] = found.reference
        yield Chart(
            name=f"prediction_{flight.name}",
            title=f"Horizontal GPS prediction error on {flight.name}",
            x_label="ahead, s",
            y_label="mean error, m",
            lines=tuple(Line(k, ahead, v[believed].mean(axis=0)) for k, v in curves.items()),
        )


def _innovations(flight: Flight, outcome: Outcome, i: int) -> Chart:
    seen = ~np.isnan(outcome.innovation[:, i])
    t, band = flight.t[seen], 2 * np.degrees(np.sqrt(outcome.variance[seen, i]))
    y = np.degrees(outcome.innovation[seen, i])
    # After minutes without a measurement the band would hide the rest.
    highest = max(2.0 * float(np.abs(y).max(initial=1.0)), 1.5 * float(np.median(band)))
    cut = f", cut at {highest:.0f} deg" if band.max(initial=0.0) > highest else ""
    t, y, band = _with_gaps(t, flight.every * flight.dt, y, np.minimum(band, highest))
    return Chart(
        name=f"innovations_{ANGLES[i]}_{flight.name}",
        title=f"Innovations of the {NAMES[ANGLES[i]]} on {flight.name}, constant process noise",
        x_label="t, s",
        y_label="innovation, deg",
        lines=(
            Line(f"95 % expected{cut}", t, -band, drawn="band", upper=band),
            Line("innovation", t, y),
        ),
    )


def _with_gaps(t: np.ndarray, step: float, *values: np.ndarray) -> tuple[np.ndarray, ...]:
    """Curves with gaps where measurements are missing."""
    at = np.flatnonzero(np.diff(t) > 1.5 * step) + 1
    return tuple(np.insert(column, at, np.nan) for column in (t, *values))


def _attitude(flight: Flight, outcome: Outcome, i: int) -> Chart:
    step = max(round(0.2 / flight.dt), 1)
    lines = [Line("estimate", flight.t[::step], _degrees(outcome.angles[::step, i]))]
    if flight.reference is not None:
        lines.append(Line("autopilot", flight.t[::step], _degrees(flight.reference[::step, i])))
    seen = ~np.isnan(flight.z[:, i])
    t, z = _with_gaps(flight.t[seen], flight.every * flight.dt, np.degrees(flight.z[seen, i]))
    lines.append(Line("constructed", t, _without_wraps(z)))
    return Chart(
        name=f"attitude_{ANGLES[i]}_{flight.name}",
        title=f"{NAMES[ANGLES[i]].capitalize()} on {flight.name}, constant process noise",
        x_label="t, s",
        y_label=f"{NAMES[ANGLES[i]]}, deg",
        lines=tuple(lines),
    )


def _degrees(angle: np.ndarray) -> np.ndarray:
    return _without_wraps(np.degrees((angle + np.pi) % (2 * np.pi) - np.pi))


def _without_wraps(degrees: np.ndarray) -> np.ndarray:
    """Angles with gaps where they wrap around."""
    found = degrees.copy()
    found[1:][np.abs(np.diff(degrees)) > 180] = np.nan
    return found


def _glitch(field: Field, flight: Flight, solutions: Solutions) -> Chart:
    lines = []
    for law in LAWS:
        nis = field.tuned_outcome(flight, law, solutions).nis
        seen = ~np.isnan(nis).all(axis=1)
        t, mean = flight.t[seen], np.nanmean(nis[seen], axis=1)
        x, y = _with_gaps(t, flight.every * flight.dt, mean)
        lines.append(Line(law, x, y))
    at = flight.t[flight.glitch]
    if len(at):
        known = np.concatenate([line.y[~np.isnan(line.y)] for line in lines])
        ends = np.array([known.min(), known.max(), np.nan])
        edges = np.repeat(at[[0, -1]], len(ends))
        lines.append(Line("glitch and 5 s around", edges, np.tile(ends, 2), drawn="limit"))
    return Chart(
        name=f"glitch_{flight.name}",
        title=f"Innovations on {flight.name}, whose GPS speed jumps",
        x_label="t, s",
        y_label="innovation^2 / variance, mean of an update",
        lines=tuple(lines),
        log="y",
    )
