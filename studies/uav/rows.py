"""What the flights say of the filter, row by row, with verdicts that are worked out."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from studies.uav.estimator import ANGLES, LAWS, PROCESS, Tuned
from studies.uav.flights import AROUND, Flight
from studies.uav.judging import (
    Field,
    Interval,
    Outcome,
    by_update,
    in_words,
    interval,
    likeness,
    spread,
    turned,
)
from studies.uav.prediction import predicted
from tuner.run.comparison import Comparison, claim, undecided
from tuner.run.study import Solutions, best, tuned_values

NIS = (0.5, 2.0)
"""A normalised innovation squared has the mean 1; so far from it R and Q still fit."""
MAKES_SENSE = {"phi": 5.0, "theta": 5.0, "psi": 20.0}
"""A constructed angle that is so near the autopilot's, root mean square, says what it should, deg.
"""
HORIZON = 3
"""Predictions are compared so many seconds ahead."""
WHITE = 1.96
"""Quantile of the normal distribution: of 95 % within."""
REFERENCE = "root mean square against the autopilot's attitude, a reference and no truth"


class Run(NamedTuple):
    """A law's run over a flight."""

    law: Tuned
    flight: Flight
    outcome: Outcome


def compare(field: Field, solutions: Solutions) -> list[Comparison]:
    """All rows."""
    runs = {
        (law, flight.name): Run(law, flight, outcome_of(field, flight, law, solutions))
        for flight in field.flights
        for law in LAWS
    }
    rows = [row for flight in field.flights for row in _constructed(flight)]
    for flight in field.flights:
        how = "tuned" if flight is field.tuned else "heldout"
        for law in LAWS:
            rows += _consistent(runs[law, flight.name], how)
        rows += _laws(runs["constant", flight.name], runs["fuzzy", flight.name], how)
        rows += _predicted(runs["constant", flight.name])
        rows += [_attitude(runs[law, flight.name]) for law in LAWS]
        rows += _glitch([runs[law, flight.name] for law in LAWS])
    return [*rows, *(row for law in LAWS for row in _determined(law, solutions))]


def outcome_of(field: Field, flight: Flight, law: Tuned, solutions: Solutions) -> Outcome:
    """How a law, tuned on the field's first flight, does on a flight."""
    values: dict[str, Any] = tuned_values(best(law, solutions))
    return field.outcome(flight, law, values)


def _constructed(flight: Flight) -> Iterator[Comparison]:
    """Whether the track's attitude is the vehicle's."""
    seen = ~np.isnan(flight.z).any(axis=1)
    for i, name in enumerate(ANGLES):
        quantity = f"uav.constructed_{name}_deg.{flight.name}"
        where = "constructed from three GPS positions and the accelerometers"
        if flight.reference is None:
            note = "the autopilot's attitude is missing, or not that of the gyroscopes"
            yield undecided(quantity, where, unit="deg", note=note)
            continue
        error = np.degrees(np.abs(turned(flight.z[seen, i] - flight.reference[seen, i])))
        found, bound = float(np.sqrt((error**2).mean())), MAKES_SENSE[name]
        yield claim(
            quantity,
            f"{where}: within {bound:g} deg",
            found <= bound,
            ours=found,
            unit="deg",
            note=f"{REFERENCE}; {100 * (error <= bound).mean():.0f} % of {len(error)} are within, "
            f"half of them within {np.median(error):.1f} deg",
        )


def _consistent(run: Run, how: str) -> Iterator[Comparison]:
    """Whether R and Q say how large innovations are, and whether these are white."""
    keep, name = ~run.flight.glitch, f"{run.law}.{run.flight.name}"
    found = interval(by_update(run.outcome.nis, keep))
    sizes = in_words(spread(run.outcome.innovation, keep))
    parts = ", ".join(
        f"{angle} {interval(column).mean:.2g}"
        for angle, column in zip(ANGLES, run.outcome.nis[keep].T, strict=True)
        if not np.isnan(column).all()
    )
    yield _within(
        f"uav.nis_{how}.{name}",
        f"mean of innovation^2 / variance, within {NIS[0]:g} to {NIS[1]:g}",
        found,
        f"1 if R and Q fit; {found}, 95 % by blocks; {parts}; innovations {sizes} RMS",
    )
    count = int((keep & ~np.isnan(run.outcome.nis).all(axis=1)).sum())
    rho, bound = likeness(run.outcome, keep), WHITE / np.sqrt(max(count, 1))
    row = f"uav.white_{how}.{name}", "an innovation tells nothing of the next"
    if not np.isfinite(rho):
        yield undecided(*row, note=f"{count} updates are too few")
        return
    yield claim(
        *row,
        abs(rho) <= bound,
        ours=rho,
        note=f"largest correlation of an angle; white within {bound:.2g} of {count} updates; "
        "neighbouring constructed attitudes share two positions",
    )


def _within(quantity: str, where: str, found: Interval, note: str) -> Comparison:
    """A claim that a mean is in its band; undecided where its interval holds an end of that."""
    if not np.isfinite(found.mean):
        return undecided(quantity, where, note="nothing was measured")
    inside = NIS[0] <= found.mean <= NIS[1]
    certain = (NIS[0] <= found.low and found.high <= NIS[1]) or (
        found.high < NIS[0] or found.low > NIS[1]
    )
    if not certain:
        return undecided(quantity, where, ours=found.mean, note=f"{note}; an end is within it")
    return claim(quantity, where, inside, ours=found.mean, note=note)


def _laws(constant: Run, fuzzy: Run, how: str) -> Iterator[Comparison]:
    """Whether fuzzy process noise foretells better than constant, number by number."""
    keep = ~constant.flight.glitch
    gain = constant.outcome.surprise - fuzzy.outcome.surprise
    found = interval(by_update(gain, keep))
    quantity = f"uav.fuzzy_vs_constant_{how}.{constant.flight.name}"
    where = "log likelihood gained by a measured number, fuzzy over constant process noise"
    note = f"{found}, 95 % by blocks; both laws have as many free numbers and the same search"
    yield _better(quantity, where, found, note, "")


def _better(quantity: str, where: str, found: Interval, note: str, unit: str) -> Comparison:
    """A claim that a gain is positive; undecided where its interval holds 0."""
    if not found.low * found.high > 0:
        mean = found.mean if np.isfinite(found.mean) else None
        return undecided(quantity, where, ours=mean, unit=unit, note=f"{note}; it may be 0")
    return claim(quantity, where, found.mean > 0, ours=found.mean, unit=unit, note=note)


def _predicted(run: Run) -> Iterator[Comparison]:
    """Positions foretold, beside a straight line and the autopilot's attitude."""
    found = predicted(run.flight, run.outcome)
    believed, at = ~found.glitch, HORIZON - 1
    quantity = f"uav.gps_prediction_m.{run.flight.name}"
    where = f"mean horizontal error {HORIZON} s ahead, less than a straight line's"
    if not believed.any():
        yield undecided(quantity, where, unit="m", note="no positions could be foretold")
        return
    each = ", ".join(f"{v:.1f}" for v in found.horizontal[believed].mean(axis=0))
    down = float(np.abs(found.vertical[believed, at]).mean())
    line = float(found.straight[believed, at].mean())
    pilot = (
        ""
        if found.reference is None
        else f"by the autopilot's attitude {found.reference[believed, at].mean():.1f}, "
    )
    gain = interval((found.straight - found.horizontal)[believed, at])
    note = (
        f"{int(believed.sum())} predictions, 1 to 5 s ahead {each} m; straight on {line:.1f}, "
        f"{pilot}down {down:.1f}; gain over the straight line {gain}, 95 % by blocks"
    )
    ours = float(found.horizontal[believed, at].mean())
    if gain.low * gain.high > 0:
        yield claim(quantity, where, gain.mean > 0, ours=ours, unit="m", note=note)
    else:
        yield undecided(quantity, where, ours=ours, unit="m", note=f"{note}; it may be 0")


def _attitude(run: Run) -> Comparison:
    quantity = f"uav.attitude_difference_deg.{run.law}.{run.flight.name}"
    where = "phi and theta of the estimate, within 5 deg where it moves"
    if run.flight.reference is None:
        note = "the autopilot's attitude is missing, or not that of the gyroscopes"
        return undecided(quantity, where, unit="deg", note=note)
    difference = turned(run.outcome.angles - run.flight.reference)
    near = _near_measurements(run.flight)
    moving, whole = spread(difference, near), spread(difference, np.ones_like(near))
    worst = max(moving[:2])
    return claim(
        quantity,
        where,
        worst <= MAKES_SENSE["phi"],
        ours=worst,
        unit="deg",
        note=f"{REFERENCE}; {in_words(moving)} within a second of a measurement, {in_words(whole)} "
        "with the hover between them",
    )


def _near_measurements(flight: Flight) -> np.ndarray:
    """Ticks within a second after a constructed attitude."""
    seen = ~np.isnan(flight.z).all(axis=1)
    return np.convolve(seen, np.ones(flight.every), "full")[: len(seen)] > 0


def _glitch(runs: list[Run]) -> Iterator[Comparison]:
    """Whether a GPS glitch shows in the innovations."""
    flight = runs[0].flight
    if not flight.jumps:
        return
    when = ", ".join(f"{at:.1f}" for at in flight.jumps)
    for run in runs:
        inside = by_update(run.outcome.nis, flight.glitch)
        outside = by_update(run.outcome.nis, ~flight.glitch)
        quantity = f"uav.glitch_nis.{run.law}.{flight.name}"
        where = "largest innovation^2 / variance of an update in the glitch, above all others"
        if not len(inside) or not len(outside):
            yield undecided(quantity, where, note="no attitude is constructed in it, or besides it")
            continue
        yield claim(
            quantity,
            where,
            float(inside.max()) > float(outside.max()),
            ours=float(inside.max()),
            note=f"mean {inside.mean():.3g} of {len(inside)} updates in it, {outside.mean():.3g} "
            f"of {len(outside)} besides, of which the largest {outside.max():.3g}; the ground "
            f"speed jumps at {when} s, and {AROUND:g} s around "
            "count as the glitch; tuning on this flight is refused",
        )


def _determined(law: Tuned, solutions: Solutions) -> Iterator[Comparison]:
    """Which numbers of the process noise the flight determines."""
    found = best(law, solutions)
    names = [name for name in found.parameters if name.startswith(PROCESS[law])]
    for name in names:
        about = [words for words in found.certificate.flat_directions if name in words]
        bound = [label for label in found.certificate.active_bounds if name in label]
        value, rises = float(found.parameters[name].value), found.parameters[name].interval
        quantity, where = f"uav.{law}.{name}", "determined by the flight that is tuned on"
        unit = found.parameters[name].unit
        if about or bound or rises is None:
            said = [*about, *(f"{label} ended at its bound" for label in bound)]
            note = "; ".join(said) or "the deviation does not curve there as at a minimum"
            yield undecided(quantity, where, ours=value, unit=unit, note=note)
        else:
            note = f"the deviation rises by 1 % at {rises[0]:.2g} and {rises[1]:.2g}"
            yield claim(quantity, where, True, ours=value, unit=unit, note=note)
