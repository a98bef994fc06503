"""Claims about the filter on the flights, one function each, with computed verdicts."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from studies.uav.flights import AROUND, Flight
from studies.uav.judging import (
    Field,
    Interval,
    by_update,
    in_words,
    interval,
    likeness,
    spread,
    turned,
)
from studies.uav.prediction import Predicted, predicted
from studies.uav.problems import LAWS, PROCESS, Tuned
from studies.uav.settings import ANGLES
from tuner.certificate.table import range_in_words
from tuner.run.comparison import Comparison, claim, undecided
from tuner.run.study import Claim, Solutions, best

NIS = (0.5, 2.0)
"""Range of the mean normalised innovation squared in which R and Q fit."""
MAKES_SENSE = {"phi": 5.0, "theta": 5.0, "psi": 20.0}
"""Largest root mean square difference of a valid constructed angle from the autopilot's, deg."""
HORIZON = 3
"""Horizon of the compared predictions, s."""
WHITE = 1.96
"""Quantile of the normal distribution for 95 %."""
REFERENCE = "root mean square against the autopilot's attitude, a reference and no truth"


def constructed(field: Field, solutions: Solutions) -> Iterator[Comparison]:
    """Whether the track's attitude agrees with the vehicle's."""
    for flight in field.flights:
        yield from _constructed(flight)


def _constructed(flight: Flight) -> Iterator[Comparison]:
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


def consistent(field: Field, solutions: Solutions, *, law: Tuned) -> Iterator[Comparison]:
    """Whether R and Q agree with the size of the innovations."""
    for flight in field.flights:
        outcome, keep = field.tuned_outcome(flight, law, solutions), ~flight.glitch
        found = interval(by_update(outcome.nis, keep))
        sizes = in_words(spread(outcome.innovation, keep))
        parts = ", ".join(
            f"{angle} {interval(column).mean:.2g}"
            for angle, column in zip(ANGLES, outcome.nis[keep].T, strict=True)
            if not np.isnan(column).all()
        )
        yield _within(
            f"uav.nis_{_how(field, flight)}.{law}.{flight.name}",
            f"mean of innovation^2 / variance, within {NIS[0]:g} to {NIS[1]:g}",
            found,
            f"1 if R and Q fit; {found}, 95 % by blocks; {parts}; innovations {sizes} RMS",
        )


def white(field: Field, solutions: Solutions, *, law: Tuned) -> Iterator[Comparison]:
    """Whether innovations are uncorrelated."""
    for flight in field.flights:
        outcome, keep = field.tuned_outcome(flight, law, solutions), ~flight.glitch
        count = int((keep & ~np.isnan(outcome.nis).all(axis=1)).sum())
        rho, bound = likeness(outcome, keep), WHITE / np.sqrt(max(count, 1))
        quantity = f"uav.white_{_how(field, flight)}.{law}.{flight.name}"
        where = "an innovation tells nothing of the next"
        if not np.isfinite(rho):
            yield undecided(quantity, where, note=f"{count} updates are too few")
            continue
        yield claim(
            quantity,
            where,
            abs(rho) <= bound,
            ours=rho,
            note=f"largest correlation of an angle; white within {bound:.2g} of {count} updates; "
            "neighbouring constructed attitudes share two positions",
        )


def _how(field: Field, flight: Flight) -> str:
    return "tuned" if flight is field.tuned else "heldout"


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


def fuzzy_or_constant(field: Field, solutions: Solutions) -> Iterator[Comparison]:
    """Whether fuzzy process noise predicts better than constant, number by number."""
    for flight in field.flights:
        constant, fuzzy = (field.tuned_outcome(flight, law, solutions) for law in LAWS)
        found = interval(by_update(constant.surprise - fuzzy.surprise, ~flight.glitch))
        yield _better(
            f"uav.fuzzy_vs_constant_{_how(field, flight)}.{flight.name}",
            "log likelihood gained by a measured number, fuzzy over constant process noise",
            found,
            f"{found}, 95 % by blocks; both laws have as many free numbers and the same search",
            "",
        )


def _better(quantity: str, where: str, found: Interval, note: str, unit: str) -> Comparison:
    """A claim that a gain is positive; undecided where its interval holds 0."""
    if not found.low * found.high > 0:
        mean = found.mean if np.isfinite(found.mean) else None
        return undecided(quantity, where, ours=mean, unit=unit, note=f"{note}; it may be 0")
    return claim(quantity, where, found.mean > 0, ours=found.mean, unit=unit, note=note)


def predictions(field: Field, solutions: Solutions) -> Iterator[Comparison]:
    """Predicted positions, beside a straight line and the autopilot's attitude."""
    for flight in field.flights:
        outcome = field.tuned_outcome(flight, "constant", solutions)
        yield _prediction(flight.name, predicted(flight, outcome))


def _prediction(name: str, found: Predicted) -> Comparison:
    believed, at = ~found.glitch, HORIZON - 1
    quantity = f"uav.gps_prediction_m.{name}"
    where = f"mean horizontal error {HORIZON} s ahead, less than a straight line's"
    if not believed.any():
        return undecided(quantity, where, unit="m", note="no positions could be predicted")
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
        return claim(quantity, where, gain.mean > 0, ours=ours, unit="m", note=note)
    return undecided(quantity, where, ours=ours, unit="m", note=f"{note}; it may be 0")


def attitude(field: Field, solutions: Solutions, *, law: Tuned) -> Iterator[Comparison]:
    """The estimated attitude beside the autopilot's."""
    for flight in field.flights:
        angles = field.tuned_outcome(flight, law, solutions).angles
        yield _attitude(f"uav.attitude_difference_deg.{law}.{flight.name}", flight, angles)


def _attitude(quantity: str, flight: Flight, angles: np.ndarray) -> Comparison:
    where = "phi and theta of the estimate, within 5 deg where it moves"
    if flight.reference is None:
        note = "the autopilot's attitude is missing, or not that of the gyroscopes"
        return undecided(quantity, where, unit="deg", note=note)
    difference = turned(angles - flight.reference)
    near = _near_measurements(flight)
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


def glitch(field: Field, solutions: Solutions, *, law: Tuned) -> Iterator[Comparison]:
    """Whether a GPS glitch shows in the innovations."""
    for flight in field.flights:
        if not flight.jumps:
            continue
        nis = field.tuned_outcome(flight, law, solutions).nis
        when = ", ".join(f"{at:.1f}" for at in flight.jumps)
        inside, outside = (by_update(nis, keep) for keep in (flight.glitch, ~flight.glitch))
        quantity = f"uav.glitch_nis.{law}.{flight.name}"
        where = "largest innovation^2 / variance of an update in the glitch, above all others"
        if not len(inside) or not len(outside):
            yield undecided(quantity, where, note="no attitude is constructed in it, or besides it")
            continue
        yield claim(
            quantity,
            where,
            float(inside.max()) > float(outside.max()),
            ours=float(inside.max()),
            note=f"mean {inside.mean():.3g} of {len(inside)} updates within {AROUND:g} s of the "
            f"jumps at {when} s, {outside.mean():.3g} of {len(outside)} outside, "
            f"at most {outside.max():.3g}; not used for tuning",
        )


def determined(field: Field, solutions: Solutions, *, law: Tuned) -> Iterator[Comparison]:
    """The parameters of the process noise that the flight determines."""
    found = best(law, solutions)
    names = [name for name in found.parameters if name.startswith(PROCESS[law])]
    for name in names:
        about = [words for words in found.certificate.flat_directions if name in words]
        bound = [label for label in found.certificate.active_bounds if name in label]
        value, rises = float(found.parameters[name].value), found.parameters[name].interval
        quantity, where = f"uav.{law}.{name}", "determined by the flight that is tuned on"
        unit = found.parameters[name].unit
        if about or bound or rises is None:
            notes = [*about, *(f"{label} ended at its bound" for label in bound)]
            note = "; ".join(notes) or "the deviation does not curve there as at a minimum"
            yield undecided(quantity, where, ours=value, unit=unit, note=note)
        else:
            note = range_in_words(rises, found.parameters[name].interval_kind)
            yield claim(quantity, where, True, ours=value, unit=unit, note=note)


def _of_law(law: Tuned) -> Iterator[Claim]:
    """The claims about one tuned law."""
    needs = (law,)
    yield Claim(f"uav.nis_*.{law}.*", partial(consistent, law=law), needs)
    yield Claim(f"uav.white_*.{law}.*", partial(white, law=law), needs)
    yield Claim(f"uav.attitude_difference_deg.{law}.*", partial(attitude, law=law), needs)
    yield Claim(f"uav.glitch_nis.{law}.*", partial(glitch, law=law), needs)
    yield Claim(f"uav.{law}.{PROCESS[law]}_*", partial(determined, law=law), needs)


CLAIMS = (
    Claim("uav.constructed_*_deg.*", constructed),
    *(said for law in LAWS for said in _of_law(law)),
    Claim("uav.fuzzy_vs_constant_*.*", fuzzy_or_constant, needs=LAWS),
    Claim("uav.gps_prediction_m.*", predictions, needs=("constant",)),
)
