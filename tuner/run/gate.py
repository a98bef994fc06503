"""The gate that a fit may add to any filter, and the likelihood that goes with it."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, cast

import jax
import jax.numpy as jnp
import numpy as np

from filters import (
    Gated,
    Lanes,
    Student,
    assembled,
    bare,
    channel_noise,
    coloured_noise,
    level_noise,
    run,
)
from filters.gated import PATIENCE
from filters.measurement_mask import MeasuredEntries, measured_entries
from objectives import HeavyTails, InnovationLikelihood, Objective, PartlyWrong
from tuner.problem.space import Space

NAMES = ("gate", "patience", "student", "noise", "stretches")
"""Options of every fit, beside the fields of the filter's class."""

SAID = ("offered", "predicted", "rejected", "weight")
"""The outputs that a gate adds to a filter's own, and that are written with them."""


NOISES = ("coloured", "sigma", "level")
"""The kinds of measurement noise, in the order in which one wraps another."""


@dataclass(frozen=True)
class Care:
    """How a fit guards against measurements that are wrong.

    Attributes:
        gate: deviations beyond which a measurement is rejected; None: none is.
        patience: refusals in a row after which it is taken all the same.
        student: degrees of freedom of heavy tails; None: the tails are normal.
        stretches: how many times as far out as usual a stretch of the record may be before it is
            left out; None: none is.
    """

    gate: float | None = None
    patience: int = PATIENCE
    student: float | None = None
    stretches: float | None = None


def with_noise(
    cls: type[Any], options: Mapping[str, Any], step: float
) -> tuple[type[Any], dict[str, Any]]:
    """The class of the filter with the measurement noise that is asked for, and the other options.

    Args:
        cls: the filter's class.
        options: what is asked for: ``noise`` is one of :data:`NOISES`, or a list of them.
        step: sample time of the data, s.

    Raises:
        ValueError: for another noise, and a filter that cannot have it.
    """
    if "noise" not in options or "noise" in {each.name for each in fields(cls)}:
        return cls, dict(options)
    named = options["noise"]
    words = [named] if isinstance(named, str) else named
    if not isinstance(words, list | tuple) or not words or not set(words) <= set(NOISES):
        raise ValueError(f"noise is {named!r}; give {', '.join(NOISES[:-1])} or {NOISES[-1]}")
    made = {"level": level_noise, "sigma": channel_noise}
    for word in (each for each in NOISES if each in words):
        key = cast("Hashable", cls)
        cls = coloured_noise(key, step) if word == "coloured" else made[word](key)
    return cls, {name: value for name, value in options.items() if name != "noise"}


def care_of(cls: type[Any], options: Mapping[str, Any]) -> tuple[Care, dict[str, Any]]:
    """The care that options ask for, and the options that are the filter's own.

    Raises:
        ValueError: for a value that is none.
    """
    own = {each.name for each in fields(cls)}
    given = {name: value for name, value in options.items() if name in NAMES and name not in own}
    if "gate" in given:
        given["gate"] = _number("gate", given["gate"], "deviations")
    if "student" in given:
        given["student"] = _number("student", given["student"], "degrees of freedom")
    if "stretches" in given:
        given["stretches"] = _number("stretches", given["stretches"], "times the usual deviation")
        if given["stretches"] < 2:
            raise ValueError(
                f"stretches={given['stretches']:g} rejects correct measurements; give 3 to 7"
            )
    if "gate" in given and "student" in given:
        raise ValueError("gate and student guard against the same outliers; give one of them")
    if "patience" in given:
        if not {"gate", "student"} & given.keys():
            raise ValueError("patience needs a gate; give --set gate=4 with it")
        if not isinstance(given["patience"], int) or isinstance(given["patience"], bool):
            raise ValueError(f"patience is {given['patience']!r}; give a whole number of samples")
    return Care(**given), {name: v for name, v in options.items() if name not in given}


def _number(name: str, value: Any, of: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise ValueError(f"{name} is {value!r}; give a number of {of}, such as {name}=4")
    return float(value)


def guarded(
    care: Care, filter: Any, objective: Objective, space: Space, inputs: Any
) -> tuple[Any, Objective]:
    """The filter with the care that is asked for, and the objective that goes with it.

    Args:
        care: what is asked for.
        filter: the filter.
        objective: what it is judged by; the likelihood of its innovations changes with the care.
        space: its parameters, whose initial values show how it runs over the record.
        inputs: the record.

    Raises:
        ValueError: for a filter that has nothing to refuse.
    """
    if care.gate is None and care.student is None:
        return filter, objective
    params = assembled(bare(filter), _begun(space))
    parts = parts_of(filter, params, inputs)
    likely = isinstance(objective, InnovationLikelihood)
    if care.student is not None:
        nu = care.student
        weighed = _inside(filter, lambda f: Student(f, parts, nu, care.patience))
        return weighed, InnovationLikelihood(HeavyTails(nu)) if likely else objective
    gate = Gated.gate if care.gate is None else care.gate
    if likely:
        objective = InnovationLikelihood(PartlyWrong(_widths(filter, params, inputs)))
    return _inside(filter, lambda f: Gated(f, parts, gate, care.patience)), objective


def _begun(space: Space) -> dict[str, Any]:
    return space.constrain(jnp.asarray(space.start()))


def _inside(filter: Any, wrap: Any) -> Any:
    """A filter wrapped within its lanes."""
    if isinstance(filter, Lanes):
        return replace(filter, filter=wrap(filter.filter))
    return wrap(filter)


def parts_of(filter: Any, params: Any, inputs: Any) -> MeasuredEntries:
    """The numbers that a filter's innovations are made of, over all recordings."""
    if not isinstance(filter, Lanes):
        return measured_entries(filter, params, inputs)
    found: MeasuredEntries = ()
    for lane in range(filter.count):
        alone = jax.tree.map(lambda leaf, lane=lane: leaf[:, lane], inputs)
        more = measured_entries(filter.filter, params, alone)
        found = tuple(a or b for a, b in zip(found, more, strict=True)) if found else more
        if all(found):
            break
    return found


def _widths(filter: Any, params: Any, inputs: Any) -> tuple[float, ...]:
    """How far apart innovations may lie: as far as without a gate at typical parameters."""
    out = run(filter, params, inputs)[1]
    y, s = (np.asarray(part) for part in (out.innovation, out.variance))
    y, s = (part.reshape(-1, part.shape[-1]) for part in (y, s))
    far = np.max(np.abs(np.where((s > 0) & np.isfinite(y), y, 0.0)), axis=0)
    sure = np.sqrt(np.max(np.where(np.isfinite(s), s, 0.0), axis=0))
    widest = np.where(far > 0, 2 * far, sure)
    return tuple(float(w) if w > 0 else 1.0 for w in widest)


@dataclass(frozen=True)
class Rejected:
    """The samples that a gate left out, or that counted for less than half.

    Attributes:
        rejected: how many numbers that were.
        outside: how many lay outside the gate, those included that were taken because too many
            had been rejected in a row.
        numbers: how many numbers were judged.
        weighed: whether they had weights, and were not rejected.
    """

    rejected: int
    outside: int
    numbers: int
    weighed: bool = False

    @property
    def words(self) -> str:
        """In a few words."""
        what = "given less than half their weight" if self.weighed else "rejected"
        text = f"{self.rejected} of {self.numbers} numbers {what}"
        taken = self.outside - self.rejected
        return text + (
            f", {taken} more accepted to recover after rejections in a row" if taken else ""
        )


def rejected_of(outputs: Any) -> Rejected | None:
    """The samples rejected in a run; None for a filter without a gate.

    Raises:
        ValueError: where more is rejected than taken.
    """
    if not hasattr(outputs, "rejected"):
        return None
    numbers = int((np.asarray(outputs.predicted) != 0).sum())
    weighed = hasattr(outputs, "weight")
    rejected, outside = (int(np.asarray(p).sum()) for p in (outputs.rejected, outputs.outside))
    if 2 * outside >= numbers:
        what = "have less than half their weight" if weighed else "lie outside the gate"
        wider = "--set student=10" if weighed else "--set gate=6"
        raise ValueError(
            f"{outside} of {numbers} measured numbers {what}, so too few are left; "
            f"give a wider one, as in {wider}, another --start, or none"
        )
    return Rejected(rejected, outside, numbers, weighed)
