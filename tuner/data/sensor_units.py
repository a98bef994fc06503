"""Noise densities of inertial sensors in kalibr's units and in those of data sheets."""

from typing import NamedTuple

import numpy as np

from filters.declared import Sensor

_DEGREES, _HOUR, _GRAVITY = 180 / np.pi, 3600.0, 9.80665


class SheetUnit(NamedTuple):
    """A unit in which the root of a density is given.

    Attributes:
        name: its name; "" where the unit says it.
        factor: from SI.
        unit: of the number.
    """

    name: str
    factor: float
    unit: str


def sheet_units(sensor: Sensor) -> tuple[SheetUnit, ...]:
    """The units for the root of a sensor's noise density, kalibr's first.

    Args:
        sensor: the kind of sensor; none for "".

    >>> [(unit.name, unit.unit) for unit in sheet_units("gyroscope")][::2]
    [('gyroscope_noise_density', 'rad/s/sqrt(Hz)'), ('ARW', 'deg/sqrt(h)')]
    """
    return _UNITS.get(sensor, ())


_UNITS: dict[Sensor, tuple[SheetUnit, ...]] = {
    "gyroscope": (
        SheetUnit("gyroscope_noise_density", 1.0, "rad/s/sqrt(Hz)"),
        SheetUnit("", _DEGREES, "deg/s/sqrt(Hz)"),
        SheetUnit("ARW", _DEGREES * 60, "deg/sqrt(h)"),
    ),
    "gyroscope bias": (
        SheetUnit("gyroscope_random_walk", 1.0, "rad/s^2/sqrt(Hz)"),
        SheetUnit("RRW", _DEGREES * _HOUR * 60, "deg/h/sqrt(h)"),
    ),
    "accelerometer": (
        SheetUnit("accelerometer_noise_density", 1.0, "m/s^2/sqrt(Hz)"),
        SheetUnit("", 1e6 / _GRAVITY, "ug/sqrt(Hz)"),
        SheetUnit("VRW", 60.0, "m/s/sqrt(h)"),
    ),
    "accelerometer bias": (
        SheetUnit("accelerometer_random_walk", 1.0, "m/s^3/sqrt(Hz)"),
        SheetUnit("RRW", 60.0, "m/s^2/sqrt(h)"),
    ),
}
