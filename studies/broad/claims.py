"""What was reached, beside the field's best filter and what others publish: by claims."""

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from studies.broad import paper
from studies.broad.contest import Contest, Outcome
from studies.broad.contestants import LABELS, SPACES, start, takes_field
from studies.broad.peers import vqf
from studies.broad.problems import Case, fold_name
from tuner.run.comparison import Comparison, claim, number, undecided
from tuner.run.study import Claim, Solutions, best, tuned_values

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


WITHOUT = fold_name("*")
"""The problems that leave a trial out."""


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


def left_out(case: Case, solutions: Solutions) -> np.ndarray:
    """The errors on trials with the parameters tuned on all others, deg."""
    contest, folds = case.contest, case.folds
    names = [fold_name(contest.trials[at].name) for at in folds]
    found = dict(zip(folds, (tuned_values(best(n, solutions)) for n in names), strict=True))
    some = found[folds[0]]  # for trials that were never left out, and are not asked for
    each = [found.get(at, some) for at in range(len(contest.trials))]
    return contest.judged_each("room", each).inclination[list(folds)]


def judged_at(name: str, contest: Contest, solutions: Solutions) -> Outcome:
    """How a filter does with the parameters tuned on all trials."""
    return contest.judged(name, tuned_values(best(name, solutions)))


def _left_out(case: Case, solutions: Solutions) -> Comparison:
    """The error on trials that the filter was not tuned on."""
    contest, own = case.contest, _room(case, solutions)
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
        note=f"{LABELS['room']}, {SPACES['room'].size} parameters; aim {REACH}; by trial {each}",
    )


def _room(case: Case, solutions: Solutions) -> Room:
    if case.folds:
        errors = left_out(case, solutions)
        return Room(list(case.folds), errors, "tuned without the trial")
    errors = judged_at("room", case.contest, solutions).inclination
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


def _vqf(case: Case, solutions: Solutions) -> Iterator[Comparison]:
    """VQF with its own parameters, and tuned."""
    found, own = vqf(case.contest), _room(case, solutions)
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


def _default(case: Case, solutions: Solutions, *, name: str) -> Comparison:
    """A filter where its search began."""
    gains = "published gains" if name.startswith(("mahony", "madgwick")) else "start values"
    found = case.contest.judged(name, start(name))
    return _state(f"inclination_{name}_default_deg", name, gains, found, case, solutions)


def _tuned(case: Case, solutions: Solutions, *, name: str) -> Comparison:
    """A filter tuned on all trials."""
    how = "tuned by the total error" if takes_field(name) else "tuned by this error"
    found = judged_at(name, case.contest, solutions)
    return _state(f"inclination_{name}_deg", name, how, found, case, solutions)


def _state(
    quantity: str, name: str, how: str, found: Outcome, case: Case, solutions: Solutions
) -> Comparison:
    note = f"{LABELS[name]}, {SPACES[name].size} parameters"
    if takes_field(name):
        total, heading = (found.errors[part].mean() for part in ("total", "heading"))
        note += f"; total {total:.3f}, heading {heading:.3f}"
    if name.startswith("room"):
        error = float(found.inclination.mean())
        where = f"{how}; the aim of {REACH} is reached"
        return claim(quantity, where, error <= REACH, ours=error, unit="deg", note=note)
    return _beaten(quantity, how, found.inclination, _room(case, solutions), note)


def _published(case: Case, solutions: Solutions, *, name: str) -> Iterator[Comparison]:
    """A filter with a magnetometer at the published gains, beside what is published."""
    contest = case.contest
    names = [trial.name for trial in contest.trials]
    why = _incomparable(contest)
    where = f"the authors' results, mean over these {len(names)} of {len(paper.NAMES)} trials"
    for part in paper.PARTS:
        quantity = f"{name}_published_{part}_deg"
        if why:
            yield undecided(quantity, "the authors' results by trial", unit="deg", note=why)
            continue
        found = contest.judged(f"{name}_field", start(f"{name}_field"))
        yield number(
            quantity,
            where,
            paper.means(name, names)[part],
            float(found.errors[part].mean()),
            tolerance=CLOSE,
            unit="deg",
            note=f"{paper.means(name, paper.NAMES)[part]:.2f} over all; {PUBLISHED[name]}",
        )


def _incomparable(contest: Contest) -> str:
    """Why published errors say nothing about these trials; "" where they do."""
    foreign = [trial.name for trial in contest.trials if trial.name not in paper.NAMES]
    if foreign:
        return f"nothing is published of {', '.join(foreign)}"
    if not contest.whole:
        return "only a part of each trial is taken, and whole ones are published"
    silent = [trial.name for trial in contest.trials if trial.start is None]
    return f"no imu_mag at rest in {', '.join(silent)}" if silent else ""


def _transferred(case: Case, solutions: Solutions) -> Comparison:
    """The room filter tuned on calm trials and judged on the others."""
    contest = case.contest
    disturbed = [i for i, trial in enumerate(contest.trials) if trial.disturbed]
    values = tuned_values(best("undisturbed", solutions))
    elsewhere = float(contest.judged("room", values).inclination[disturbed].mean())
    own = float(judged_at("room", contest, solutions).inclination[disturbed].mean())
    return claim(
        "inclination_transfer_deg",
        "tuned on the undisturbed trials, judged on the disturbed ones",
        elsewhere <= REACH,
        ours=elsewhere,
        unit="deg",
        note=f"with the parameters tuned on all trials {own:.3f}",
    )


def claims_of(case: Case) -> tuple[Claim, ...]:
    """What these trials can decide."""
    found = [Claim("inclination_loo_deg", _left_out, (WITHOUT,))] if case.folds else []
    own = (WITHOUT,) if case.folds else ("room",)
    found.append(Claim("inclination_vqf*_deg", _vqf, own))
    for name in case.tuned:
        held = () if name.startswith("room") else own
        default, tuned = partial(_default, name=name), partial(_tuned, name=name)
        found.append(Claim(f"inclination_{name}_default_deg", default, held))
        found.append(Claim(f"inclination_{name}_deg", tuned, (name, *held)))
    for name in ("madgwick", "mahony"):
        found.append(Claim(f"{name}_published_*_deg", partial(_published, name=name)))
    if len({trial.disturbed for trial in case.contest.trials}) == 2:
        needs = ("undisturbed", "room")
        found.append(Claim("inclination_transfer_deg", _transferred, needs))
    return tuple(found)
