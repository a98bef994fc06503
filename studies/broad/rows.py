"""What was reached, beside the field's best filter and what others publish."""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from studies.broad import published
from studies.broad.contest import Contest, Outcome
from studies.broad.contestants import FREE, LABELS, start, takes_field
from studies.broad.peers import vqf
from studies.broad.trials import Trial
from tuner.run.comparison import Comparison, claim, number, undecided
from tuner.run.study import Solutions, best, tuned_values

REACH = 0.70
"""What a filter of this project has to reach on trials that it was not tuned on, deg."""
CLOSE = 0.02
"""How closely a filter has to repeat what is published of it, relative."""
PUBLISHED = {
    "madgwick": "their code takes the reference field at half its length, and the length of its "
    "gradient depends on which earth axis is north",
    "mahony": "their code begins some degrees off, which the integral remembers",
}
"""Why the authors' implementations differ from ours."""


class Room(NamedTuple):
    """The room filter's errors that others are held against.

    Attributes:
        at: the trials, by index.
        errors: their errors, deg.
        how: how it was tuned.
    """

    at: list[int]
    errors: np.ndarray
    how: str


def compare(
    contest: Contest, folds: Sequence[int], tuned: Sequence[str], solutions: Solutions
) -> list[Comparison]:
    """All rows."""
    own = _room(contest, folds, solutions)
    rows = [_left_out(contest, own)] if folds else []
    rows += _vqf(contest, own)
    for name in tuned:
        rows += _states(name, contest, own, solutions)
    rows += _published(contest)
    return [*rows, *_transferred(contest, solutions)]


def fold_name(trial: Trial) -> str:
    """What the problem is called that leaves a trial out."""
    return f"without_{trial.name}"


def left_out(contest: Contest, folds: Sequence[int], solutions: Solutions) -> np.ndarray:
    """The errors on trials with the parameters tuned on all others, deg."""
    names = [fold_name(contest.trials[at]) for at in folds]
    found = dict(zip(folds, (tuned_values(best(n, solutions)) for n in names), strict=True))
    some = found[folds[0]]  # for trials that were never left out, and are not asked for
    each = [found.get(at, some) for at in range(len(contest.trials))]
    return contest.judged_each("room", each).inclination[list(folds)]


def judged_at(name: str, contest: Contest, solutions: Solutions) -> Outcome:
    """How a filter does with the parameters tuned on all trials."""
    return contest.judged(name, tuned_values(best(name, solutions)))


def _left_out(contest: Contest, own: Room) -> Comparison:
    each = ", ".join(
        f"{contest.trials[at].name[:2]} {error:.3f}"
        for at, error in zip(own.at, own.errors, strict=True)
    )
    return claim(
        "inclination_loo_deg",
        "leave one trial out, mean of the trials' RMSE in motion",
        float(own.errors.mean()) <= REACH,
        ours=float(own.errors.mean()),
        unit="deg",
        note=f"{LABELS['room']}, {len(FREE['room'])} parameters; aim {REACH}; by trial {each}",
    )


def _room(contest: Contest, folds: Sequence[int], solutions: Solutions) -> Room:
    if folds:
        errors = left_out(contest, folds, solutions)
        return Room(list(folds), errors, "tuned without the trial")
    errors = judged_at("room", contest, solutions).inclination
    return Room(list(range(len(errors))), errors, "tuned on them all")


def _beaten(quantity: str, how: str, errors: np.ndarray, own: Room, note: str) -> Comparison:
    """The claim that the room filter is better than another on the same trials."""
    other, room = float(errors[own.at].mean()), float(own.errors.mean())
    return claim(
        quantity,
        f"{how}; the room filter, {own.how}, is better",
        room < other,
        ours=float(errors.mean()),
        unit="deg",
        note=f"{note}; {other:.3f} against the room filter's {room:.3f} on {len(own.at)} trials",
    )


def _vqf(contest: Contest, own: Room) -> Iterator[Comparison]:
    found = vqf(contest)
    if found is None:
        for quantity in ("inclination_vqf_deg", "inclination_vqf_tuned_deg"):
            yield undecided(
                quantity,
                "the same trials",
                unit="deg",
                note="the package vqf is not installed: it comes with the extra 'peers'",
            )
        return
    yield _beaten("inclination_vqf_deg", "its own parameters", found.default, own, "VQF")
    note = f"VQF, time constant {found.tau:.2g} s"
    yield _beaten("inclination_vqf_tuned_deg", "tuned on these trials", found.tuned, own, note)


def _states(name: str, contest: Contest, own: Room, solutions: Solutions) -> Iterator[Comparison]:
    """A filter where its search began, and tuned on all trials."""
    gains = "published gains" if name.startswith(("mahony", "madgwick")) else "start values"
    by = "by the total error" if takes_field(name) else "by this error"
    states = (
        (f"inclination_{name}_default_deg", gains, contest.judged(name, start(name))),
        (f"inclination_{name}_deg", f"tuned {by}", judged_at(name, contest, solutions)),
    )
    for quantity, how, found in states:
        note = f"{LABELS[name]}, {len(FREE[name])} parameters"
        if takes_field(name):
            total, heading = (found.errors[part].mean() for part in ("total", "heading"))
            note += f"; total {total:.3f}, heading {heading:.3f}"
        if name.startswith("room"):
            error = float(found.inclination.mean())
            where = f"{how}; the aim of {REACH} is reached"
            yield claim(quantity, where, error <= REACH, ours=error, unit="deg", note=note)
        else:
            yield _beaten(quantity, how, found.inclination, own, note)


def _published(contest: Contest) -> Iterator[Comparison]:
    """Both filters with a magnetometer at the published gains, beside what is published."""
    names = [trial.name for trial in contest.trials]
    why = _incomparable(contest)
    where = f"the authors' results, mean over these {len(names)} of {len(published.NAMES)} trials"
    for name, part in product(("madgwick", "mahony"), published.PARTS):
        quantity = f"{name}_published_{part}_deg"
        if why:
            yield undecided(quantity, "the authors' results by trial", unit="deg", note=why)
            continue
        found = contest.judged(f"{name}_field", start(f"{name}_field"))
        yield number(
            quantity,
            where,
            published.means(name, names)[part],
            float(found.errors[part].mean()),
            tolerance=CLOSE,
            unit="deg",
            note=f"{published.means(name, published.NAMES)[part]:.2f} over all; {PUBLISHED[name]}",
        )


def _incomparable(contest: Contest) -> str:
    """Why published errors say nothing about these trials; "" where they do."""
    foreign = [trial.name for trial in contest.trials if trial.name not in published.NAMES]
    if foreign:
        return f"nothing is published of {', '.join(foreign)}"
    if not contest.whole:
        return "only a part of each trial is taken, and whole ones are published"
    silent = [trial.name for trial in contest.trials if trial.start is None]
    return f"no imu_mag at rest in {', '.join(silent)}" if silent else ""


def _transferred(contest: Contest, solutions: Solutions) -> Iterator[Comparison]:
    disturbed = [i for i, trial in enumerate(contest.trials) if trial.disturbed]
    if not disturbed or len(disturbed) == len(contest.trials):
        return
    values = tuned_values(best("undisturbed", solutions))
    elsewhere = float(contest.judged("room", values).inclination[disturbed].mean())
    own = float(judged_at("room", contest, solutions).inclination[disturbed].mean())
    yield claim(
        "inclination_transfer_deg",
        "tuned on the undisturbed trials, judged on the disturbed ones",
        elsewhere <= REACH,
        ours=elsewhere,
        unit="deg",
        note=f"with the parameters tuned on all trials {own:.3f}",
    )
