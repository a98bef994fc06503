"""Errors by trial, and one trial in time."""

from collections.abc import Iterator, Sequence

import numpy as np

from studies.broad.contest import Contest
from studies.broad.contestants import has_lead
from studies.broad.other_filters import judged_at, left_out
from studies.broad.problems import Case
from tuner.names import counted
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
    lines = [Line(_words(name), at, one.inclination) for name, one in found.items()]
    if folds:
        apart = left_out(case, solutions, room)
        lines.append(Line(f"{_words(room)}, trial left out", at[list(folds)], apart))
    lead = "without a lead" if end else "with a lead"
    errors = {name: float(np.mean(one.inclination)) for name, one in found.items()}
    yield Chart(
        name=f"by_trial{end}",
        title=f"Mean inclination error of {counted(len(at), 'trial')}, {lead}: {_ranked(errors)}",
        x_label=label,
        y_label="inclination, RMSE in motion, deg",
        lines=tuple(lines),
        log="y",
        numbered=True,
    )
    last = {name: float(one.inclination[-1]) for name, one in found.items()}
    yield Chart(
        name=f"in_time{end}",
        title=f"Inclination error in {contest.trials[-1].name}, {lead}: {_ranked(last)}",
        x_label="time, s",
        y_label=f"inclination, RMS error over {WINDOW:g} s, deg",
        lines=tuple(
            Line(_words(name), *_in_time(contest, one.last)) for name, one in found.items()
        ),
        log="y",
    )


def _words(name: str) -> str:
    """A filter as people write it; whether it has a lead is said in the title."""
    return name.removesuffix("_now").removesuffix("_lead").replace("_", " ")


def _ranked(errors: dict[str, float]) -> str:
    """The best filter and the next one, with their errors."""
    best, *others = sorted(errors, key=errors.__getitem__)
    first = f"{_words(best)} {errors[best]:.2f} deg"
    return f"{first}, next {_words(others[0])} {errors[others[0]]:.2f} deg" if others else first


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
