"""Tuned against untuned and against no filter on flights that were not tuned on."""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from studies.uav.flights import Flight
from studies.uav.judging import Field, Interval, Outcome, by_update, interval
from studies.uav.prediction import Predicted, predicted
from studies.uav.problems import Tuned, alone_name, fold_name, quaternion, start_values
from tuner.run.comparison import Comparison, claim, undecided
from tuner.run.study import Claim, Solutions, best, tuned_values

AHEAD = 3
"""Horizon of the compared predictions, s."""
NO_HELP = "tuning does not help here"
LAW: Tuned = "constant"
NATS = "log likelihood gained by a measured number"


def unfiltered(flight: Flight) -> Outcome:
    """No filter: each constructed attitude as it is, and the gyroscopes after it."""
    x = np.zeros((len(flight.t), 7))
    for at in np.flatnonzero(~np.isnan(flight.z).any(axis=1)):
        x[at, :4] = quaternion(flight.z[at])
    nothing = np.full((len(flight.t), 3), np.nan)
    return Outcome(x, nothing, nothing, nothing)


def untuned(field: Field, flight: Flight) -> Outcome:
    """The filter with the start values of its search."""
    return field.outcome(flight, LAW, start_values(LAW, field.measured))


def _values(field: Field, flight: Flight, solutions: Solutions, how: str) -> dict[str, Any]:
    """Values tuned on the study's tuning flight, or on all other flights."""
    name = LAW if how == "one" else fold_name(flight.name)
    return tuned_values(best(name, solutions))


def _alone(field: Field, flight: Flight) -> str:
    """The problem of a flight's own optimum."""
    return LAW if flight is field.tuned else alone_name(flight.name)


def _flights(field: Field, how: str) -> tuple[Flight, ...]:
    return field.judged if how == "one" else field.left_out


HOWS = {"one": "tuned on {tuned}", "others": "tuned on all other flights without a glitch"}


def helps(field: Field, solutions: Solutions, *, how: str) -> Iterator[Comparison]:
    """Whether tuning predicts the measurements of a flight better that it has not seen."""
    words = HOWS[how].format(tuned=field.tuned.name)
    for flight in _flights(field, how):
        before = untuned(field, flight)
        after = field.outcome(flight, LAW, _values(field, flight, solutions, how))
        keep = ~flight.glitch
        nis = [by_update(each.nis, keep).mean() for each in (before, after)]
        yield _gain(
            f"uav.tuning_gain.{how}.{flight.name}",
            f"{NATS}, {words} over untuned",
            interval(by_update(before.surprise - after.surprise, keep)),
            f"NIS {nis[0]:.3g} untuned, {nis[1]:.3g} tuned",
            NO_HELP,
        )


def predicts(field: Field, solutions: Solutions, *, how: str) -> Iterator[Comparison]:
    """Whether tuning predicts positions better, and whether a filter does."""
    words = HOWS[how].format(tuned=field.tuned.name)
    for flight in _flights(field, how):
        tuned = field.outcome(flight, LAW, _values(field, flight, solutions, how))
        after = predicted(flight, tuned)
        for rival, name, sentence in (
            (untuned(field, flight), "untuned", NO_HELP),
            (unfiltered(flight), "no filter", "a filter does not help here"),
        ):
            quantity = "tuning" if name == "untuned" else "filter"
            yield _nearer(
                f"uav.{quantity}_gain_m.{how}.{flight.name}",
                f"horizontal error {AHEAD} s ahead, {name} less {words}",
                predicted(flight, rival),
                after,
                name,
                sentence,
            )


def _nearer(
    quantity: str, where: str, rival: Predicted, found: Predicted, name: str, sentence: str
) -> Comparison:
    believed, at = ~found.glitch, AHEAD - 1
    if not believed.any():
        return undecided(quantity, where, unit="m", note="no positions could be predicted")
    theirs, ours = rival.horizontal[believed, at], found.horizontal[believed, at]
    note = f"{theirs.mean():.3g} m {name}, {ours.mean():.3g} m tuned"
    return _gain(quantity, where, interval(theirs - ours), note, sentence, "m")


def _gain(
    quantity: str, where: str, found: Interval, note: str, sentence: str, unit: str = ""
) -> Comparison:
    """A claim that a gain is positive; where that is not certain, its note says so."""
    note = f"{note}; gain {found}, 95 % by blocks"
    if found.low > 0:
        return claim(quantity, where, True, ours=found.mean, unit=unit, note=note)
    if found.high < 0:
        note = f"{note}; {sentence}: it harms"
        return claim(quantity, where, False, ours=found.mean, unit=unit, note=note)
    mean = found.mean if np.isfinite(found.mean) else None
    note = f"{note}; {sentence}, as far as this flight can tell"
    return undecided(quantity, where, ours=mean, unit=unit, note=note)


def gaps(field: Field, solutions: Solutions) -> Iterator[Comparison]:
    """The gap to each flight's own optimum."""
    for flight in field.left_out:
        keep = ~flight.glitch
        values = _values(field, flight, solutions, "others")
        found = field.outcome(flight, LAW, values)
        own = field.outcome(flight, LAW, tuned_values(best(_alone(field, flight), solutions)))
        left = interval(by_update(found.surprise - own.surprise, keep))
        before = interval(by_update(untuned(field, flight).surprise - found.surprise, keep))
        yield claim(
            f"uav.tuning_gap.{flight.name}",
            f"{NATS}, tuned on the flight itself over tuned on all others; less than tuning gains",
            left.mean < before.mean,
            ours=left.mean,
            note=f"gap {left}, 95 % by blocks; tuning on others gains {before.mean:.3g}",
        )


def claims_held_out(field: Field) -> tuple[Claim, ...]:
    """The claims that these flights can decide."""
    found = []
    for how in ("one", "others"):
        if not _flights(field, how):
            continue
        needs: tuple[str, ...] = (LAW,) if how == "one" else (fold_name("*"),)
        judgements = {"uav.tuning_gain": helps, "uav.*_gain_m": predicts}
        for name, rows in judgements.items():
            found.append(Claim(f"{name}.{how}.*", partial(rows, how=how), needs))
    if field.left_out:
        needs = (LAW, fold_name("*"), alone_name("*"))
        found.append(Claim("uav.tuning_gap.*", gaps, needs))
    return tuple(found)
