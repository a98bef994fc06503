"""Noise a sample, as a density and as a deviation side by side, and gains by all their names."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from filters.declared import Param, parameter_facts
from tuner.data.sensor_units import told_as
from tuner.data.unit_text import Powers, per, powers_of, raised, written
from tuner.export.tuned import Quantity
from tuner.run.finding import Finding

COLUMNS = ("variance", "density", "deviation")
"""What stands side by side: the ends of the findings' names."""
_SHOWN = 3  # a matrix of more states has too many numbers to be read


class Noise(NamedTuple):
    """A parameter that says how large a noise is.

    Attributes:
        name: of the parameter.
        square: its value, or the square of it where it is a root.
        powers: of the names in the square's unit.
        density: whether it is a spectral density, and not the variance of a sample.
        fact: what the filter declares of it.
    """

    name: str
    square: float
    powers: Powers
    density: bool
    fact: Param


def noises(filter: Any, values: Mapping[str, Any], units: Mapping[str, str]) -> Iterator[Noise]:
    """The parameters that are noises, known by their units.

    A variance is a square, a density is a square in a number of seconds that is odd, and its root
    is known by the half. What is not searched (starts, constants) does not count.

    Args:
        filter: declares what its parameters are.
        values: by name.
        units: of the values.
    """
    for name, fact in parameter_facts(filter).items():
        powers = powers_of(units.get(name, fact.unit))
        if fact.low is None or name not in values or powers is None or np.ndim(values[name]):
            continue
        value, seconds = float(values[name]), powers.get("s", 0.0)
        root = seconds % 1 == 0.5
        square = raised(powers, 2.0) if root else powers
        others = [power for name, power in square.items() if name != "s"]
        if value > 0 and others and all(power % 2 == 0 for power in others):
            odd = square.get("s", 0.0) % 2 == 1
            yield Noise(name, value**2 if root else value, square, odd, fact)


def noise_told(
    filter: Any, values: Mapping[str, Any], units: Mapping[str, str], dt: float
) -> Iterator[Finding]:
    """Every noise as variance a sample, density and deviation, and as data sheets tell it.

    Args:
        filter: declares what its parameters are.
        values: of the parameters, by name.
        units: of the values.
        dt: sample time, s.
    """
    at = f"at {1 / dt:.6g} Hz"
    for each in noises(filter, values, units):
        yield from _process(each, dt, at) if each.density else _measurement(each, dt, at)


def _process(noise: Noise, dt: float, at: str) -> Iterator[Finding]:
    entered = noise.square * dt
    unit = per(noise.powers, "s", -1)
    root = written(raised(unit, 0.5))
    yield Finding(f"{noise.name}.variance", entered, written(unit), f"enters in a sample {at}")
    yield Finding(f"{noise.name}.density", noise.square, written(noise.powers), noise.fact.meaning)
    yield Finding(f"{noise.name}.deviation", float(np.sqrt(entered)), root, "of a sample's")
    for told in told_as(noise.fact.sensor):
        value, name = float(np.sqrt(noise.square)) * told.factor, told.name or told.unit
        yield Finding(f"{noise.name}.{name}", value, told.unit, f"{noise.fact.sensor}, as a root")


def _measurement(noise: Noise, dt: float, at: str) -> Iterator[Finding]:
    unit, deviation = written(noise.powers), float(np.sqrt(noise.square))
    yield Finding(f"{noise.name}.variance", noise.square, unit, noise.fact.meaning)
    if not noise.fact.per_sample:
        density = written(per(noise.powers, "Hz"))
        told = f"the same as white noise with a sample {at}: over the rate"
        yield Finding(f"{noise.name}.density", noise.square * dt, density, told)
    root = written(raised(noise.powers, 0.5))
    yield Finding(f"{noise.name}.deviation", deviation, root, "of a sample")


def gains_told(derived: Iterable[Quantity]) -> Iterator[Finding]:
    """Q, the steady gains K and L, and their names among trackers, entry by entry.

    Args:
        derived: what follows from a filter's parameters; of a symmetric matrix one half is told.
    """
    for each in derived:
        if each.value.ndim == 2 and len(each.value) > _SHOWN:
            continue
        for at, number in np.ndenumerate(each.value):
            if _square(each) and at[0] > at[1]:
                continue
            index = "".join(f"{i + 1}" for i in (at[:1] if _column(each) else at))
            own = each.name.removesuffix("_derived")  # as Q beside the density q is exported
            name = own if each.value.size == 1 else f"{own}{index}"
            yield Finding(name, float(number), _unit(each, at), each.meaning)


def _square(quantity: Quantity) -> bool:
    return quantity.value.ndim == 2 and len(set(quantity.value.shape)) == 1


def _column(quantity: Quantity) -> bool:
    return not _square(quantity) and (quantity.value.ndim < 2 or quantity.value.shape[1] == 1)


def _unit(quantity: Quantity, at: tuple[int, ...]) -> str:
    """The unit of an entry, where there is one for each: of a symmetric matrix for each i + j."""
    first, ends, _ = quantity.unit.partition(" .. ")
    powers = powers_of(first)
    if ends and powers is not None and _square(quantity):
        return written(per(powers, "s", sum(at)))
    units = [unit.strip() for unit in quantity.unit.split(",")]
    place = sum(at) if _square(quantity) else (*at, 0)[0]
    count = 2 * len(quantity.value) - 1 if _square(quantity) else (*quantity.value.shape, 1)[0]
    fits = len(units) == count and (_square(quantity) or _column(quantity))
    return "" if not fits or units[place] == "1" else units[place]
