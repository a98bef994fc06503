"""Innovations in their band, attitude beside the autopilot's, and the glitch."""

from collections.abc import Iterator

import numpy as np

from studies.uav.flights import AROUND, Flight
from studies.uav.judging import Field, Outcome, spread, turned
from studies.uav.prediction import AHEAD, Predicted, predicted
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
        if not found.glitch.all():
            yield _predictions(flight, found)


def _predictions(flight: Flight, found: Predicted) -> Chart:
    """Mean errors of predicted positions, while the GPS is trusted."""
    ahead, believed = np.arange(1.0, AHEAD + 1), ~found.glitch
    errors = {"filter": found.horizontal, "straight on": found.straight}
    if found.reference is not None:
        errors["autopilot's attitude"] = found.reference
    means = {name: values[believed].mean(axis=0) for name, values in errors.items()}
    text = ", ".join(f"{mean[-1]:.2g} m ({name})" for name, mean in means.items())
    return Chart(
        name=f"prediction_{flight.name}",
        title=f"Error of positions {AHEAD} s ahead on {flight.name}: {text}",
        x_label="time ahead, s",
        y_label="mean horizontal error, m",
        lines=tuple(Line(name, ahead, mean) for name, mean in means.items()),
    )


def _innovations(flight: Flight, outcome: Outcome, i: int) -> Chart:
    seen = ~np.isnan(outcome.innovation[:, i])
    t, band = flight.t[seen], 2 * np.degrees(np.sqrt(outcome.variance[seen, i]))
    y = np.degrees(outcome.innovation[seen, i])
    inside = 100 * float(np.mean(np.abs(y) <= band))
    # After minutes without a measurement the band would hide the rest.
    highest = max(2.0 * float(np.abs(y).max(initial=1.0)), 1.5 * float(np.median(band)))
    cut = f", cut at {highest:.0f} deg" if band.max(initial=0.0) > highest else ""
    t, y, band = _with_gaps(t, flight.every * flight.dt, y, np.minimum(band, highest))
    name = NAMES[ANGLES[i]]
    return Chart(
        name=f"innovations_{ANGLES[i]}_{flight.name}",
        title=f"{name.capitalize()} on {flight.name}: {inside:.0f} % of the innovations lie in "
        "the band where 95 % are expected",
        x_label="time, s",
        y_label=f"innovation of the {name}, deg",
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
    name = NAMES[ANGLES[i]]
    lines = [Line("estimate", flight.t[::step], _degrees(outcome.angles[::step, i]))]
    title = f"{name.capitalize()} on {flight.name}, constant process noise"
    if flight.reference is not None:
        lines.append(Line("autopilot", flight.t[::step], _degrees(flight.reference[::step, i])))
        apart = turned(outcome.angles - flight.reference)
        title = f"{name.capitalize()} on {flight.name}: {_apart(flight, apart, i)}"
    z = np.degrees(flight.z[:, i])
    seen = ~np.isnan(z)
    lines.append(Line("constructed from GPS", flight.t[seen], z[seen], drawn="points"))
    return Chart(
        name=f"attitude_{ANGLES[i]}_{flight.name}",
        title=title,
        x_label="time, s",
        y_label=f"{name}, deg",
        lines=tuple(lines),
    )


def _apart(flight: Flight, apart: np.ndarray, i: int) -> str:
    """How far estimate and autopilot are apart, with and without measurements, in words."""
    at = flight.t[~np.isnan(flight.z[:, i])]
    if not len(at):
        return f"{spread(apart, np.ones(len(apart), bool))[i]:.2g} deg from the autopilot's"
    near = np.abs(flight.t[:, None] - at).min(axis=1) <= flight.every * flight.dt
    text = f"{spread(apart, near)[i]:.2g} deg from the autopilot's while GPS measures it"
    return text if near.all() else f"{text}, {spread(apart, ~near)[i]:.2g} deg without"


def _degrees(angle: np.ndarray) -> np.ndarray:
    return _without_wraps(np.degrees((angle + np.pi) % (2 * np.pi) - np.pi))


def _without_wraps(degrees: np.ndarray) -> np.ndarray:
    """Angles with gaps where they wrap around."""
    found = degrees.copy()
    found[1:][np.abs(np.diff(degrees)) > 180] = np.nan
    return found


def _glitch(field: Field, flight: Flight, solutions: Solutions) -> Chart:
    lines, parts = [], []
    for law in LAWS:
        nis = field.tuned_outcome(flight, law, solutions).nis
        seen = ~np.isnan(nis).all(axis=1)
        t, mean, bad = flight.t[seen], np.nanmean(nis[seen], axis=1), flight.glitch[seen]
        x, y = _with_gaps(t, flight.every * flight.dt, mean)
        lines.append(Line(law, x, y))
        if bad.any() and not bad.all():
            parts.append(f"{mean[bad].mean():.2g} within it and {mean[~bad].mean():.2g} outside")
    at = flight.t[flight.glitch]
    known = np.concatenate([line.y[np.isfinite(line.y)] for line in lines])
    if len(at):
        low, high = np.full(2, known.min()), np.full(2, known.max())
        name = f"glitch, and {AROUND:g} s around"
        lines.append(Line(name, at[[0, -1]], low, drawn="band", upper=high))
    ends = flight.t[[0, -1]]
    lines.append(Line("consistent: 1", ends, np.ones(2), drawn="limit"))
    means = " and ".join(f"{part} ({law})" for part, law in zip(parts, LAWS, strict=False))
    return Chart(
        name=f"glitch_{flight.name}",
        title=f"The NIS shows the glitch of {flight.name}: {means}"
        if parts
        else f"NIS on {flight.name}, whose GPS speed jumps",
        x_label="time, s",
        y_label="NIS, mean of an update",
        lines=tuple(lines),
        log="y",
    )
