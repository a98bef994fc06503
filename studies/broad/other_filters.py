"""Other filters, each compared with the room filter that has the same freedoms."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from studies.broad.contest import Contest, Outcome
from studies.broad.contestants import LABELS, SPACES, has_lead, start, takes_field
from studies.broad.peers import vqf
from studies.broad.problems import Case, fold_name
from tuner.names import counted
from tuner.run.comparison import Comparison, claim, undecided
from tuner.run.study import Solutions, best, tuned_values

REACH = 0.70
"""The error that a filter of this project has to reach on held-out trials, deg."""
PACKAGE = "the package vqf is not installed: it comes with the extra 'peers'"


class Room(NamedTuple):
    """The room filter's errors, with which others are compared.

    Attributes:
        at: the trials, by index.
        errors: their errors, deg.
        how: how it was tuned.
    """

    at: list[int]
    errors: np.ndarray
    how: str


def room_of(name: str) -> str:
    """The room filter with the freedom that a filter has: with a lead, or without."""
    return "room" if has_lead(name) else "room_now"


def needed(case: Case, name: str) -> tuple[str, ...]:
    """The problems whose solutions :func:`room` asks for."""
    own = room_of(name)
    return (fold_name("*", own),) if case.folds else (own,)


def room(case: Case, solutions: Solutions, name: str) -> Room:
    """The errors that a filter of that name is compared with."""
    own = room_of(name)
    label = "the room filter" if has_lead(own) else "the room filter without a lead"
    if case.folds:
        errors = left_out(case, solutions, own)
        return Room(list(case.folds), errors, f"{label}, tuned without the trial")
    errors = judged_at(own, case.contest, solutions).inclination
    return Room(list(range(len(errors))), errors, f"{label}, tuned on them all")


def left_out(case: Case, solutions: Solutions, name: str = "room") -> np.ndarray:
    """The errors on trials with the parameters tuned on all others, deg."""
    return each(case, solutions, name, lambda trial: fold_name(trial, name))


def each(case: Case, solutions: Solutions, name: str, posed: Callable[[str], str]) -> np.ndarray:
    """The errors of a filter on trials that each have a problem of their own, deg.

    Args:
        case: the comparison.
        solutions: of the problems.
        name: of the filter.
        posed: the map from a trial's name to its problem's.
    """
    contest, folds = case.contest, case.folds
    names = [posed(contest.trials[at].name) for at in folds]
    found = dict(zip(folds, (tuned_values(best(n, solutions)) for n in names), strict=True))
    some = found[folds[0]]  # for trials that were never left out, and are not needed
    values = [found.get(at, some) for at in range(len(contest.trials))]
    return contest.judged_each(name, values).inclination[list(folds)]


def judged_at(name: str, contest: Contest, solutions: Solutions) -> Outcome:
    """A filter's errors with the parameters tuned on all trials."""
    return contest.judged(name, tuned_values(best(name, solutions)))


def by_trial(case: Case, own: Room) -> str:
    """Errors with the numbers of their trials."""
    names = [case.contest.trials[at].name[:2] for at in own.at]
    return ", ".join(f"{name} {error:.3f}" for name, error in zip(names, own.errors, strict=True))


def beaten(quantity: str, how: str, errors: np.ndarray, own: Room, note: str) -> Comparison:
    """The claim that the room filter is better than another on the same trials, on average."""
    theirs = errors[own.at]
    other, ours, count = float(theirs.mean()), float(own.errors.mean()), len(own.at)
    on = f"on {int((own.errors < theirs).sum())} of {count} trials" if count > 1 else ""
    return claim(
        quantity,
        f"{how}; {own.how}, is better",
        ours < other,
        ours=float(errors.mean()),
        unit="deg",
        note=f"{note}; {other:.3f} against {ours:.3f} on average"
        + (f", and the room filter is better {on}" if on else ""),
    )


VQF = {
    "": "its own parameters",
    "_tuned": "tuned on these trials",
    "_lead": "tuned on these trials with a lead",
    "_lead_loo": "tuned with a lead without the trial that is judged",
    "_lead_alone": "tuned with a lead on the very trial that is judged",
}
"""How VQF is tuned, by the end of the row's name."""


def of_vqf(case: Case, solutions: Solutions, *, state: str) -> Comparison:
    """VQF, tuned as a row's name says."""
    quantity, how = f"inclination_vqf{state}_deg", VQF[state]
    found = vqf(case.contest)
    if found is None:
        return undecided(quantity, how, unit="deg", note=PACKAGE)
    tau, lead = found.ahead_at
    errors, note = {
        "": (found.default, ""),
        "_tuned": (found.tuned, f", time constant {found.tau:.2g} s"),
        "_lead": (found.ahead, f", time constant {tau:.2g} s, lead {1e3 * lead:.2g} ms"),
        "_lead_loo": (found.left_out, ""),
        "_lead_alone": (found.alone, ""),
    }[state]
    own = room(case, solutions, vqf_name(state))
    return beaten(quantity, how, errors, own, f"VQF{note}")


def vqf_name(state: str) -> str:
    """The name of VQF, with or without a lead."""
    return "vqf_lead" if "lead" in state else "vqf"


def default(case: Case, solutions: Solutions, *, name: str) -> Comparison:
    """A filter with the start values of its search."""
    gains = "published gains" if name.startswith(("mahony", "madgwick")) else "start values"
    found = case.contest.judged(name, start(name))
    return _state(f"inclination_{name}_default_deg", name, gains, found, case, solutions)


def tuned(case: Case, solutions: Solutions, *, name: str) -> Comparison:
    """A filter tuned on all trials."""
    how = "tuned by the total error" if takes_field(name) else "tuned by this error"
    found = judged_at(name, case.contest, solutions)
    return _state(f"inclination_{name}_deg", name, how, found, case, solutions)


def _state(
    quantity: str, name: str, how: str, found: Outcome, case: Case, solutions: Solutions
) -> Comparison:
    note = f"{LABELS[name]}, {counted(SPACES[name].size, 'parameter')}"
    if takes_field(name):
        total, heading = (found.errors[part].mean() for part in ("total", "heading"))
        note += f"; total {total:.3f}, heading {heading:.3f}"
    if name.startswith("room"):
        error = float(found.inclination.mean())
        where = f"{how}; the aim of {REACH} is reached"
        return claim(quantity, where, error <= REACH, ours=error, unit="deg", note=note)
    return beaten(quantity, how, found.inclination, room(case, solutions, name), note)
