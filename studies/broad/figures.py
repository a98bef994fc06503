"""Errors by trial, and one trial in time."""

from collections.abc import Iterator, Sequence

import jax
import jax.numpy as jnp
import numpy as np

from filters import Several, run, shared
from objectives import attitude_error
from studies.broad.contest import PARAMETERS, filter_of, judged, side_by_side
from studies.broad.rows import LABELS, left_out
from studies.broad.trials import Trial
from tuner.figure import Chart, Figure, Line
from tuner.study import Solutions, best, tuned_values


def figures(
    trials: Sequence[Trial], folds: Sequence[int], tuned: Sequence[str], solutions: Solutions
) -> Iterator[Figure]:
    """All of them."""
    at = 1.0 + np.arange(len(trials))
    lines = [
        Line(LABELS[name], at, judged(name, tuned_values(best(name, solutions)), trials))
        for name in tuned
    ]
    if folds:
        errors = left_out(trials, folds, solutions)
        lines.insert(0, Line("room, trial left out", at[list(folds)], errors))
    names = ", ".join(f"{i + 1}: {trial.name[:2]}" for i, trial in enumerate(trials))
    yield Chart(
        name="by_trial",
        title=f"Inclination error in motion by trial ({names})",
        x_label="trial",
        y_label="RMSE, deg",
        lines=tuple(lines),
        log="y",
    )
    yield _in_time(trials[-1], tuned, solutions)


def _in_time(trial: Trial, tuned: Sequence[str], solutions: Solutions) -> Chart:
    lines = []
    for name in tuned:
        data = side_by_side(name, [trial])
        params = shared(PARAMETERS[name](tuned_values(best(name, solutions))), 1)
        found = run(Several(filter_of(name, trial.rate_hz)), params, data.inputs)[1]
        q = jnp.reshape(getattr(found, "q", found), (-1, 4))
        truth = jnp.reshape(data.truth, (-1, 4))
        error = np.degrees(np.asarray(jax.vmap(attitude_error)(q, truth).inclination))
        t = np.linspace(0, len(trial.rate) / trial.rate_hz, len(error))
        step = max(len(t) // 4000, 1)
        lines.append(Line(LABELS[name], t[::step], error[::step]))
    return Chart(
        name="in_time",
        title=f"Inclination error of {trial.name}",
        x_label="t, s",
        y_label="error, deg",
        lines=tuple(lines),
    )
