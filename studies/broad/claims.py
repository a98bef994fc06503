"""The results beside other filters and published ones, by claims."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from studies.broad import other_filters, paper
from studies.broad.contest import Contest
from studies.broad.contestants import start
from studies.broad.delays import late
from studies.broad.held_out import claims_held_out, mean_left_out
from studies.broad.other_filters import REACH, judged_at, needed
from studies.broad.problems import Case, fold_name
from tuner.run.comparison import Comparison, claim, number, undecided
from tuner.run.study import Claim, Solutions, best, tuned_values

CLOSE = 0.02
"""Relative tolerance for reproducing a filter's published errors."""
NEAR = 3e-4
"""Tolerance of the tuned lead against the gyroscopes' delay, s."""
PUBLISHED = {
    "madgwick": "their code takes the reference field at half its length, and the length of its "
    "gradient depends on which earth axis is north",
    "mahony": "their code begins some degrees off, which the integral remembers",
}
"""Why the authors' implementations differ from ours."""


def _published(case: Case, solutions: Solutions, *, name: str) -> Iterator[Comparison]:
    """A filter with a magnetometer at the published gains, beside the published errors."""
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
    """The reason why published errors do not apply to these trials; "" where they do."""
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


def _sensor(case: Case, solutions: Solutions) -> Comparison:
    """The sensor's part of the delay."""
    quantity, where = "delay_sensor_ms", "gyroscopes are later than accelerometers on every trial"
    found = 1e3 * np.array([late(trial) for trial in case.contest.trials])
    found = found[~np.isnan(found).any(axis=1)]
    if not len(found):
        note = "no trial has places (opt_pos) long enough in one piece"
        return undecided(quantity, where, unit="ms", note=note)
    own = found[:, 0] - found[:, 1]
    ranges = ", ".join(
        f"{name} {column.min():.2f} to {column.max():.2f}"
        for name, column in zip(("gyroscopes", "accelerometers"), found.T, strict=True)
    )
    return claim(
        quantity,
        where,
        bool((own > 0).all()),
        ours=float(own.mean()),
        unit="ms",
        note=f"late against the truth, by trial: {ranges} ms; the difference, {own.min():.2f} to "
        f"{own.max():.2f}, is the sensor's; what both are late may be the truth's clock",
    )


def _lead(case: Case, solutions: Solutions) -> Comparison:
    """Whether the tuned lead equals the gyroscopes' delay."""
    quantity = "delay_lead_ms"
    where = f"the tuned lead and half a sample are the gyroscopes' delay, within {1e3 * NEAR:g} ms"
    found = np.array([late(trial).gyroscopes for trial in case.contest.trials])
    lead = float(tuned_values(best("room", solutions))["lead"])
    ours, seen = lead + 0.5 / case.contest.rate_hz, found[~np.isnan(found)]
    if not len(seen):
        note = "no trial has a truth that is long enough in one piece"
        return undecided(quantity, where, ours=1e3 * ours, unit="ms", note=note)
    return claim(
        quantity,
        where,
        abs(ours - float(seen.mean())) <= NEAR,
        ours=1e3 * ours,
        unit="ms",
        note=f"lead {1e3 * lead:.2f}; a step takes the rate at its end for its mean, half a "
        f"sample early; gyroscopes are {1e3 * seen.mean():.2f} late",
    )


def claims_of(case: Case) -> tuple[Claim, ...]:
    """The claims that these trials can decide."""
    left_out = (fold_name("*"),)
    found = [Claim("inclination_loo_deg", mean_left_out, left_out)] if case.folds else []
    found += claims_held_out(case)
    for state in other_filters.VQF:
        row, held = f"inclination_vqf{state}_deg", needed(case, other_filters.vqf_name(state))
        found.append(Claim(row, partial(other_filters.of_vqf, state=state), held))
    for name in case.tuned:
        held = () if name.startswith("room") else needed(case, name)
        default, tuned = (
            partial(each, name=name) for each in (other_filters.default, other_filters.tuned)
        )
        if not name.endswith("_lead"):  # which begin without one
            found.append(Claim(f"inclination_{name}_default_deg", default, held))
        found.append(Claim(f"inclination_{name}_deg", tuned, (name, *held)))
    found += [Claim("delay_sensor_ms", _sensor), Claim("delay_lead_ms", _lead, ("room",))]
    for name in ("madgwick", "mahony"):
        found.append(Claim(f"{name}_published_*_deg", partial(_published, name=name)))
    if len({trial.disturbed for trial in case.contest.trials}) == 2:
        needs = ("undisturbed", "room")
        found.append(Claim("inclination_transfer_deg", _transferred, needs))
    return tuple(found)
