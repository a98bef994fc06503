"""Pictures of a fit: the signal before and after, and what the filter did not foretell."""

from collections.abc import Iterator

import jax.numpy as jnp
import numpy as np

from filters.declared import output
from tuner.problem.problem import run_filter
from tuner.run.figure import Chart, Figure, Line
from tuner.run.judged import innovations
from tuner.run.posed import Posed
from tuner.run.study import Solutions, best

POINTS = 2000
"""Samples of a curve; a picture shows no more."""


def figures(posed: Posed, solutions: Solutions) -> Iterator[Figure]:
    """The output that was judged beside its truth, or the innovations with their band."""
    problem, solution = posed.problem, best(posed.problem.name, solutions)
    begun = problem.parameters(problem.space.start())
    tuned = {name: parameter.value for name, parameter in solution.parameters.items()}
    if posed.output:
        yield _error(posed, begun, tuned)
    elif posed.objective == "likelihood":
        yield _innovations(posed, tuned)


def _error(posed: Posed, begun: dict[str, np.ndarray], tuned: dict[str, np.ndarray]) -> Chart:
    """Each part of the judged output, with its truth; of the first recording."""
    problem = posed.problem
    truth = _first(posed, np.asarray(posed.timeline.truth[posed.output]))
    lines = []
    for label, values in (("before", begun), ("tuned", tuned)):
        params = problem.static.build({n: jnp.asarray(v, float) for n, v in values.items()})
        whole = run_filter(problem.filter, params, problem.data.inputs)
        found = _first(posed, np.asarray(output(problem.filter, whole, posed.output)))
        lines.append((label, found))
    lines.append(("truth", truth))
    shown = np.unique(np.linspace(0, len(truth) - 1, POINTS).astype(int))
    shown = shown[np.isfinite(truth.reshape(len(truth), -1)[shown]).all(axis=1)]
    t = _times(posed)[shown]
    return Chart(
        name=f"{problem.name}_{posed.output}",
        title=f"{posed.output}: before, tuned and true",
        x_label="time, s",
        y_label=posed.output,
        lines=tuple(
            Line(f"{label}{f' {i}' if width > 1 else ''}", t, column[shown])
            for label, array in lines
            for width in (array.reshape(len(array), -1).shape[1],)
            for i, column in enumerate(array.reshape(len(array), -1).T)
        ),
    )


def _innovations(posed: Posed, tuned: dict[str, np.ndarray]) -> Chart:
    """Normalised innovations: 95 of 100 lie within two deviations of a consistent filter."""
    y, s = innovations(posed.problem, tuned)
    normalised = np.where(s > 0, y / np.sqrt(np.where(s > 0, s, 1.0)), np.nan)
    first = _first(posed, normalised)
    first = first.reshape(len(first), -1)
    t = _times(posed)
    lines = []
    for i, column in enumerate(first.T):
        seen = np.flatnonzero(np.isfinite(column))
        shown = (
            seen[np.unique(np.linspace(0, len(seen) - 1, POINTS).astype(int))]
            if len(seen)
            else seen
        )
        lines.append(Line(f"innovation {i + 1}", t[shown], column[shown]))
    ends = t[[0, -1]]
    lines += [Line(f"{sign:+.0f} deviations", ends, np.full(2, sign)) for sign in (2.0, -2.0)]
    return Chart(
        name=f"{posed.problem.name}_innovations",
        title="What the tuned filter did not foretell, over its own deviation",
        x_label="time, s",
        y_label="innovation / deviation",
        lines=tuple(lines),
    )


def _times(posed: Posed) -> np.ndarray:
    return _first(posed, np.asarray(posed.timeline.times))


def _first(posed: Posed, array: np.ndarray) -> np.ndarray:
    """The first recording of several."""
    return array[:, 0] if np.ndim(posed.timeline.dt) == 2 else array
