"""The size of a noise: a number of a run with its unit, read as a density or as a deviation."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from tuner.data.sensor_units import sheet_units
from tuner.data.unit_text import powers_of
from tuner.data.units import Unit
from tuner.export.tuned import Quantity, Tuned
from tuner.run.finding import Finding

_SECOND = np.array(Unit.of("s").powers, float)
_EXPORTS = {
    sheet_units(sensor)[0].name
    for sensor in ("gyroscope", "gyroscope bias", "accelerometer", "accelerometer bias")
}
_AT_REST = {export: export.partition("_")[2] for export in _EXPORTS}
"""Names of the exports of a record at rest: noise_density, random_walk."""


class Amount(NamedTuple):
    """A number that may be the size of a noise.

    Attributes:
        name: of the quantity, after that of its filter where there are several.
        value: the number.
        unit: of the number.
        meaning: of the quantity.
        dt: the sample time at which it is a number a sample, s; 0: none.
        export: its known meaning: ``gyroscope_noise_density`` and so on; "" where it is not known.
        below: its upper limit, where only that is known; else None.
        again: whether it repeats other numbers of its filter.
    """

    name: str
    value: float
    unit: str
    meaning: str
    dt: float
    export: str = ""
    below: float | None = None
    again: bool = False


class Known(NamedTuple):
    """A run's result for an amount.

    Attributes:
        export: its meaning.
        below: as of an amount.
    """

    export: str
    below: float | None = None


class Read(NamedTuple):
    """An amount in the unit that was asked for.

    Attributes:
        value: the number.
        how: the formula.
    """

    value: float
    how: str


def amounts(
    tuned: Collection[Tuned],
    findings: Iterable[Finding],
    limits: Mapping[tuple[str, str], float] = MappingProxyType({}),
) -> list[Amount]:
    """All numbers of tuned filters; vectors and diagonals entry by entry, as ``R1`` or ``Q22``.

    Args:
        tuned: the filters.
        findings: of their run, which name the numbers of inertial sensors.
        limits: upper limits where only these are known, by filter and quantity.
    """
    known = _known(tuned, list(findings))
    found = []
    for filter in tuned:
        at_rest = any(name == filter.name for name, _ in known)
        prefix = f"{filter.name}." if len(tuned) > 1 else ""
        for quantity in filter.quantities:
            place = filter.name, quantity.name
            export, below = known.get(place) or known.get(("", quantity.name)) or Known("")
            below = limits.get(place) if below is None else below
            for end, value, unit in _entries(quantity):
                name, dt = f"{prefix}{quantity.name}{end}", 0.0 if at_rest else filter.dt
                again = at_rest and not export
                found.append(Amount(name, value, unit, quantity.meaning, dt, export, below, again))
    return found


def _known(tuned: Collection[Tuned], findings: list[Finding]) -> dict[tuple[str, str], Known]:
    """Findings by filter and quantity: ``z.gyroscope_random_walk.likelihood`` of a record at rest,
    ``q.gyroscope_noise_density`` of a parameter, whose filter is the run's only one."""
    names = {filter.name for filter in tuned}
    found = {}
    for finding in findings:
        subject, _, rest = finding.name.partition(".")
        export = rest.removesuffix(".likelihood")
        if export not in _EXPORTS:
            continue
        if rest == export:
            found["", subject] = Known(export)
        elif subject in names:
            below = finding.high if finding.low is None else None
            found[subject, _AT_REST[export]] = Known(export, below)
    return found


def _entries(quantity: Quantity) -> Iterator[tuple[str, float, str]]:
    """Suffixes of names, numbers and units."""
    value, unit = quantity.value, quantity.unit
    if value.size == 1:
        yield "", float(value.item()), unit
    elif value.ndim == 1:
        units = [part.strip() for part in unit.split(",")]
        for i, number in enumerate(value):
            yield f"{i + 1}", float(number), units[i] if len(units) == len(value) else unit
    elif value.shape[0] == value.shape[1]:
        for i, number in enumerate(np.diagonal(value)):
            yield f"{i + 1}{i + 1}", float(number), unit


def density(amount: Amount, unit: str) -> Read | None:
    """The root of the density of white noise in unit/sqrt(Hz); None where units contradict it.

    A variance or deviation of a sample is that of white noise at its sample time.

    >>> density(Amount("q", 4e-6, "rad^2/s", "", 0.01), "rad/s")
    Read(value=0.002, how='sqrt(q)')
    """
    T = amount.dt
    return _read(
        amount,
        unit,
        {
            (2.0, 1.0): (0.5, 1.0, "sqrt({})"),
            (1.0, 0.5): (1.0, 1.0, "{}"),
            (2.0, 0.0): (0.5, np.sqrt(T), f"sqrt({{}} {T:.6g} s)"),
            (1.0, 0.0): (1.0, np.sqrt(T), f"{{}} sqrt({T:.6g} s)"),
        },
    )


def deviation(amount: Amount, unit: str) -> Read | None:
    """The deviation of a measurement in a unit; None where units contradict it.

    >>> deviation(Amount("R", 4.0, "m^2", "", 0.01), "m").value
    2.0
    """
    ways = {(2.0, 0.0): (0.5, 1.0, "sqrt({})"), (1.0, 0.0): (1.0, 1.0, "{}")}
    return _read(amount, unit, ways)


_Ways = Mapping[tuple[float, float], tuple[float, float, str]]


def _read(amount: Amount, unit: str, ways: _Ways) -> Read | None:
    """A number read by powers of the unit and of the second: power, factor and formula."""
    wanted = Unit.of(unit)
    given = _in_si(amount.unit)
    if given is None:
        return None
    for (of_unit, of_second), (power, factor, how) in ways.items():
        dimensions = of_unit * np.array(wanted.powers, float) + of_second * _SECOND
        if factor and np.array_equal(given[1], dimensions):
            value = (amount.value * given[0]) ** power * factor / wanted.factor
            return Read(float(value), how.format(amount.name))
    return None


def _in_si(unit: str) -> tuple[float, np.ndarray] | None:
    """Factor to SI and powers of the base units, halves too; None for text that is not a unit."""
    powers = powers_of(re.sub(r"sqrt\((\w+)\)", r"\1^0.5", unit))
    if not powers:
        return None
    factor, dimensions = 1.0, np.zeros(len(_SECOND))
    for name, power in powers.items():
        try:
            known = Unit.of(name)
        except ValueError:
            return None
        factor *= known.factor**power
        dimensions += power * np.array(known.powers)
    return factor, dimensions
