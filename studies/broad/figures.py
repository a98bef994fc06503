"""Errors by trial, and one trial in time."""

from collections.abc import Iterator, Sequence

import numpy as np

from studies.broad.contest import Contest
from studies.broad.contestants import has_lead
from studies.broad.other_filters import judged_at, left_out
from studies.broad.problems import Case
from tuner.run.figure import Chart, Figure, Line
from tuner.run.study import Solutions

WINDOW = 1.0
"""Window of the root mean squares in time, s: single samples would fill the figure."""


def figures(case: Case, solutions: Solutions) -> Iterator[Figure]:
    """All of them: filters with a lead, and without one where any is tuned."""
    for end, lead in (("", True), ("_now", False)):
        names = [name for name in case.tuned if has_lead(name) is lead]
        if names:
            yield from _figures(case, solutions, names, end)


def _figures(case: Case, solutions: Solutions, names: Sequence[str], end: str) -> Iterator[Figure]:
    contest, folds, room = case.contest, case.folds, names[0]
    found = {name: judged_at(name, contest, solutions) for name in names}
    at, label = _numbers(contest)
    lines = [Line(name, at, one.inclination) for name, one in found.items()]
    if folds:
        errors = left_out(case, solutions, room)
        lines.insert(0, Line(f"{room}, trial left out", at[list(folds)], errors))
    said = ", without a lead" if end else ""
    yield Chart(
        name=f"by_trial{end}",
        title=f"Inclination error in motion by trial{said}",
        x_label=label,
        y_label="RMSE, deg",
        lines=tuple(lines),
        log="y",
        numbered=True,
    )
    yield Chart(
        name=f"in_time{end}",
        title=f"Inclination error of {contest.trials[-1].name}{said}",
        x_label="t, s",
        y_label=f"RMS over {WINDOW:g} s, deg",
        lines=tuple(Line(name, *_in_time(contest, one.last)) for name, one in found.items()),
        log="y",
    )


def _numbers(contest: Contest) -> tuple[np.ndarray, str]:
    """Positions of the trials: the numbers that their names begin with, if all do."""
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
