"""Errors by trial, and one trial in time."""

from collections.abc import Iterator

import numpy as np

from studies.broad.contest import Contest
from studies.broad.problems import Case
from studies.broad.rivals import judged_at, left_out
from tuner.run.figure import Chart, Figure, Line
from tuner.run.study import Solutions

WINDOW = 1.0
"""Errors in time are root mean squares over so many seconds: single samples only blacken."""


def figures(case: Case, solutions: Solutions) -> Iterator[Figure]:
    """All of them."""
    contest, folds = case.contest, case.folds
    found = {name: judged_at(name, contest, solutions) for name in case.tuned}
    at, label = _numbers(contest)
    lines = [Line(name, at, one.inclination) for name, one in found.items()]
    if folds:
        errors = left_out(case, solutions)
        lines.insert(0, Line("room, trial left out", at[list(folds)], errors))
    yield Chart(
        name="by_trial",
        title="Inclination error in motion by trial",
        x_label=label,
        y_label="RMSE, deg",
        lines=tuple(lines),
        log="y",
        numbered=True,
    )
    yield Chart(
        name="in_time",
        title=f"Inclination error in motion of {contest.trials[-1].name}",
        x_label="t, s",
        y_label=f"RMS over {WINDOW:g} s, deg",
        lines=tuple(Line(name, *_in_time(contest, one.last)) for name, one in found.items()),
        log="y",
    )


def _numbers(contest: Contest) -> tuple[np.ndarray, str]:
    """Where trials stand along the axis: at the numbers that their names begin with, if all do."""
    heads = [trial.name.split("_")[0] for trial in contest.trials]
    if len(set(heads)) == len(heads) and all(head.isdecimal() for head in heads):
        return np.array(heads, float), "number of the trial"
    return 1.0 + np.arange(len(heads)), "trial, in the order of their names"


def _in_time(contest: Contest, error: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middles of windows in motion, s, and errors, deg; NaN where no truth is known."""
    step = round(len(contest.data("mahony").truth) / len(error))  # some filters thin the samples
    rate_hz = contest.rate_hz / step
    width = max(round(WINDOW * rate_hz), 1)
    cut = error[: len(error) // width * width].reshape(-1, width)
    known = ~np.isnan(cut)
    mean = np.where(known, cut**2, 0.0).sum(axis=1) / np.maximum(known.sum(axis=1), 1)
    at = (np.arange(len(cut)) + 0.5) * width / rate_hz
    seen = known.any(axis=1)
    span = slice(int(np.argmax(seen)), len(seen) - int(np.argmax(seen[::-1])))
    return at[span], np.where(seen, np.sqrt(mean), np.nan)[span]
