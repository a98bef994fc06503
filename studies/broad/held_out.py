"""The benefit of tuning on held-out trials, and the benefit of a filter at all."""

from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from studies.broad.contestants import LABELS, SPACES, start
from studies.broad.no_filter import accelerometers, gyroscopes
from studies.broad.other_filters import REACH, beaten, by_trial, each, left_out, needed, room
from studies.broad.problems import Case, alone_name, fold_name
from tuner.names import counted
from tuner.run.comparison import Comparison, claim, undecided
from tuner.run.study import Claim, Solutions

NO_HELP = "tuning does not help here"


class Gain(NamedTuple):
    """A mean of paired differences and its 95 % interval by Student's t."""

    mean: float
    low: float
    high: float

    @classmethod
    def of(cls, differences: np.ndarray) -> "Gain":
        """Of single trials' ``(k,)``; infinite limits of a single one."""
        count, mean = len(differences), float(differences.mean())
        if count < 2:
            return cls(mean, -np.inf, np.inf)
        deviation = float(differences.std(ddof=1))
        half = float(stdtrit(count - 1, 0.975)) * deviation / np.sqrt(count)
        return cls(mean, mean - half, mean + half)

    def __str__(self) -> str:
        """As text."""
        return f"{self.mean:.3f} ({self.low:.3f} to {self.high:.3f})"


def mean_left_out(case: Case, solutions: Solutions) -> Comparison:
    """The error on trials that the filter was not tuned on."""
    own = room(case, solutions, "room")
    return claim(
        "inclination_loo_deg",
        "leave one trial out, mean of the trials' RMSE in motion",
        float(own.errors.mean()) <= REACH,
        ours=float(own.errors.mean()),
        unit="deg",
        note=f"{LABELS['room']}, {counted(SPACES['room'].size, 'parameter')}; aim {REACH}; "
        f"by trial {by_trial(case, own)}",
    )


def helps(case: Case, solutions: Solutions, *, name: str) -> Comparison:
    """Whether tuning helps on a trial that was not tuned on."""
    untuned = case.contest.judged(name, start(name)).inclination[list(case.folds)]
    found = left_out(case, solutions, name)
    gain = Gain.of(untuned - found)
    quantity = f"inclination_{name}_gain_deg"
    where = "untuned less tuned without the trial, both on that trial; tuning helps"
    note = (
        f"{LABELS[name]}: {untuned.mean():.3f} untuned, {found.mean():.3f} tuned; gain {gain}, "
        f"95 % by trials; better on {int((found < untuned).sum())} of {len(found)}"
    )
    if gain.low <= 0 <= gain.high:
        note += f"; {NO_HELP}, as far as {counted(len(found), 'trial')} can tell"
        return undecided(quantity, where, ours=gain.mean, unit="deg", note=note)
    note += "" if gain.mean > 0 else f"; {NO_HELP}: it harms"
    return claim(quantity, where, gain.mean > 0, ours=gain.mean, unit="deg", note=note)


def gap(case: Case, solutions: Solutions) -> Comparison:
    """The gap to each trial's own optimum."""
    found = left_out(case, solutions)
    own = each(case, solutions, "room", alone_name)
    untuned = case.contest.judged("room", start("room")).inclination[list(case.folds)]
    left = Gain.of(found - own)
    return claim(
        "inclination_gap_deg",
        "tuned without the trial less tuned on it alone; that is less than what tuning gains",
        left.mean < float((untuned - found).mean()),
        ours=left.mean,
        unit="deg",
        note=f"{LABELS['room']}: each trial's own optimum {own.mean():.3f}; gap {left}, 95 % by "
        f"trials, largest {float((found - own).max()):.3f}",
    )


ALONE = {"accelerometers": accelerometers, "gyroscopes": gyroscopes}


def nothing(case: Case, solutions: Solutions, *, name: str) -> Comparison:
    """No filter at all: accelerometers alone, or gyroscopes alone."""
    note = "their mean at rest is taken off" if name == "gyroscopes" else "each for itself"
    own = room(case, solutions, "none")
    how = f"no filter, {name} alone"
    return beaten(f"inclination_{name}_deg", how, ALONE[name](case.contest), own, note)


def claims_held_out(case: Case) -> tuple[Claim, ...]:
    """The claims that these trials can decide."""
    held = needed(case, "none")
    nothings = [
        Claim(f"inclination_{name}_deg", partial(nothing, name=name), held) for name in ALONE
    ]
    if not case.folds:
        return tuple(nothings)
    folds = {name: (fold_name("*", name),) for name in ("room", "room_now")}
    gains = (
        Claim(f"inclination_{name}_gain_deg", partial(helps, name=name), needs)
        for name, needs in folds.items()
    )
    gaps = Claim("inclination_gap_deg", gap, (*folds["room"], alone_name("*")))
    return (*gains, gaps, *nothings)
