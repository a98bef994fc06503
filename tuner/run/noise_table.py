"""Noise a sample, as a density and as a deviation side by side, and gains by all their names."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from tuner.data.sensor_units import sheet_units
from tuner.data.unit_text import per, powers_of, raised, written
from tuner.export.tuned import Quantity
from tuner.run.finding import Finding
from tuner.run.noise_parameters import NoiseParameter, noise_parameters

COLUMNS = ("variance", "density", "deviation")
"""The quantities that stand side by side: the ends of the findings' names."""
_MODEL = ("F", "C")  # exported beside the gains, and known to who made the model
_SHOWN = 3  # a matrix of more states has too many numbers to be read


def noise_findings(
    filter: Any, values: Mapping[str, Any], units: Mapping[str, str]
) -> Iterator[Finding]:
    """Every noise as variance a sample, density and deviation, and in data sheet units.

    Args:
        filter: the filter, for its sample time.
        values: of the parameters, by name.
        units: of the values.
    """
    dt = float(filter.dt)
    at = f"at {1 / dt:.6g} Hz"
    for each in noise_parameters(filter, values, units):
        yield from _process(each, dt, at) if each.kind == "density" else _sampled(each, dt, at)


def _process(noise: NoiseParameter, dt: float, at: str) -> Iterator[Finding]:
    entered = noise.square * dt
    unit = per(noise.powers, "s", -1) if noise.powers else {}
    root = written(raised(unit, 0.5))
    yield Finding(
        f"{noise.name}.variance", entered, written(unit), f"process noise per sample {at}"
    )
    yield Finding(f"{noise.name}.density", noise.square, written(noise.powers), noise.fact.meaning)
    yield Finding(
        f"{noise.name}.deviation", float(np.sqrt(entered)), root, "of the process noise per sample"
    )
    for form in sheet_units(noise.fact.sensor):
        value, name = float(np.sqrt(noise.square)) * form.factor, form.name or form.unit
        yield Finding(f"{noise.name}.{name}", value, form.unit, f"{noise.fact.sensor}, as a root")


def _sampled(noise: NoiseParameter, dt: float, at: str) -> Iterator[Finding]:
    unit, deviation = written(noise.powers), float(np.sqrt(noise.square))
    yield Finding(f"{noise.name}.variance", noise.square, unit, noise.fact.meaning)
    if noise.kind == "variance":
        density = written(per(noise.powers, "Hz")) if noise.powers else ""
        meaning = f"white noise sampled {at}: variance over the rate"
        yield Finding(f"{noise.name}.density", noise.square * dt, density, meaning)
    root = written(raised(noise.powers, 0.5))
    yield Finding(f"{noise.name}.deviation", deviation, root, "of a measurement")


def gain_findings(derived: Iterable[Quantity]) -> Iterator[Finding]:
    """Q, the steady gains K and L, and their names among trackers, entry by entry.

    Args:
        derived: what follows from a filter's parameters; of a symmetric matrix one half is told.
    """
    for each in derived:
        own = each.name.removesuffix("_derived")  # as Q beside the density q is exported
        if own in _MODEL or (each.value.ndim == 2 and len(each.value) > _SHOWN):
            continue
        for at, number in np.ndenumerate(each.value):
            if _square(each) and at[0] > at[1]:
                continue
            index = "".join(f"{i + 1}" for i in (at[:1] if _column(each) else at))
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
