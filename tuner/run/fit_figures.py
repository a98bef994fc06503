"""Pictures of a fit: an output before and after beside its truth, and what was not predicted."""

from collections.abc import Iterator, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from filters.declared import bare, channel_facts, output
from objectives import AttitudeRmse
from objectives.attitude import attitude_error
from tuner.run.figure import Chart, Drawn, Figure, Line
from tuner.run.fit_problem import Posed
from tuner.run.innovation_diagnostics import innovations
from tuner.run.study import Solutions, best

POINTS = 2000
"""Samples of a curve; a picture shows no more."""


def figures(posed: Posed, solutions: Solutions) -> Iterator[Figure]:
    """The output that was judged, before and after; without a truth the innovations."""
    problem, solution = posed.problem, best(posed.problem.name, solutions)
    tuned = {name: parameter.value for name, parameter in solution.parameters.items()}
    if posed.objective == "likelihood":
        yield normalised(posed, tuned)
        return
    name = posed.output or "innovation"
    each = {"before": problem.parameters(problem.space.start()), "tuned": tuned}
    found = {when: _output(posed, values, name) for when, values in each.items()}
    if isinstance(problem.objective, AttitudeRmse):
        yield _attitude(posed, found, problem.objective.part)
    else:
        yield from _parts(posed, name, found)


def _output(posed: Posed, values: Mapping[str, Any], name: str) -> np.ndarray:
    """An output with some parameters, of the first recording, ``(N, m)``."""
    problem = posed.problem
    return _columns(posed, np.asarray(output(problem.filter, posed.run(values), name)))


def _attitude(posed: Posed, found: Mapping[str, np.ndarray], part: str) -> Chart:
    """The angle that the objective takes, over time."""
    truth = jnp.asarray(_columns(posed, posed.timeline.truth[posed.output]))
    angle = jax.jit(jax.vmap(lambda q, true: getattr(attitude_error(q, true), part)))
    errors = {when: np.degrees(np.asarray(angle(q, truth))) for when, q in found.items()}
    words = "error of the " + ("attitude" if part == "total" else part)
    lines = [_line(posed, when, error) for when, error in errors.items()]
    known = np.isfinite(errors["tuned"]) & np.isfinite(errors["before"])
    less = float(np.mean((errors["tuned"] < errors["before"])[known])) if known.any() else 0.0
    title = f"{words} is smaller than before in {100 * less:.0f} % of the samples"
    return _chart(posed, posed.output, title, f"{words}, deg", lines)


def _parts(posed: Posed, name: str, found: Mapping[str, np.ndarray]) -> Iterator[Chart]:
    """Each part of an output, with its truth where there is one."""
    axes, shown = _axes(posed, name, found["tuned"]), dict(found)
    if posed.output:
        shown["truth"] = _columns(posed, posed.timeline.truth[posed.output])
    unit = f", {posed.unit}" if posed.unit else ""
    drawn: Drawn = "curve" if posed.output else "points"
    for i, axis in enumerate(axes):
        called = f"{name} {axis}".rstrip()
        # Where the truth is known; a curve between its samples would say more than there is.
        seen = np.isfinite(shown.get("truth", found["tuned"])[:, i])
        lines = [
            _line(posed, when, np.where(seen, columns[:, i], np.nan), drawn)
            for when, columns in shown.items()
        ]
        title = f"{called}, before and after"
        if posed.output:
            off = {when: _rms(found[when][:, i] - shown["truth"][:, i]) for when in found}
            title = f"{called}: {off['tuned']:.3g}{unit.strip(',')} rms from the truth, "
            title += f"{off['before']:.3g} before"
        yield _chart(posed, called, title, f"{called}{unit}", lines)


def _rms(error: np.ndarray) -> float:
    known = error[np.isfinite(error)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")


def normalised(posed: Posed, tuned: Mapping[str, Any]) -> Chart:
    """Innovations over their deviations: 95 % lie within two of them where both are right."""
    y, s = innovations(posed.problem, tuned)
    columns = _columns(posed, np.where(s > 0, y / np.sqrt(np.where(s > 0, s, 1.0)), np.nan))
    axes = _axes(posed, "innovation", columns)
    ends = _times(posed)[[0, -1]]
    band = Line("95 % expected", ends, np.full(2, -2.0), drawn="band", upper=np.full(2, 2.0))
    points = [
        _line(posed, axis or "innovation", columns[:, i], "points") for i, axis in enumerate(axes)
    ]
    known = columns[np.isfinite(columns)]
    share = f"{100 * np.mean(np.abs(known) <= 2):.3g}" if known.size else "none"
    title = f"{share} % of innovations lie within two of their deviations (95 % expected)"
    return _chart(posed, "innovations", title, "innovation / deviation", [band, *points])


def _chart(posed: Posed, name: str, title: str, label: str, lines: list[Line]) -> Chart:
    several = np.ndim(posed.timeline.dt) == 2
    return Chart(
        name=f"{posed.problem.name}_{name.replace(' ', '_')}",
        title=title[0].upper() + title[1:] + ("; first recording" if several else ""),
        x_label="time, s",
        y_label=label,
        lines=tuple(lines),
    )


def _line(
    posed: Posed,
    label: str,
    values: np.ndarray,
    drawn: Drawn = "curve",
) -> Line:
    """A curve of the samples that are numbers, of many every so many."""
    rows = np.flatnonzero(np.isfinite(values))
    if len(rows) > POINTS:
        rows = rows[np.linspace(0, len(rows) - 1, POINTS).astype(int)]
    return Line(label, _times(posed)[rows], values[rows], drawn=drawn)


def _axes(posed: Posed, name: str, columns: np.ndarray) -> tuple[str, ...]:
    """The names of an output's parts; none where it is one number."""
    known = channel_facts(bare(posed.problem.filter), "outputs")[name].axes
    count = columns.shape[1]
    if count == 1:
        return ("",)
    return known[:count] if len(known) >= count else tuple(str(i + 1) for i in range(count))


def _times(posed: Posed) -> np.ndarray:
    return _columns(posed, posed.timeline.times)[:, 0]


def _columns(posed: Posed, array: Any) -> np.ndarray:
    """The first recording of several, its parts side by side."""
    found = np.asarray(array, float)
    first = found[:, 0] if np.ndim(posed.timeline.dt) == 2 else found
    return first.reshape(len(first), -1)
