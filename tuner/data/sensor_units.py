"""Noise densities of inertial sensors in kalibr's units and in those of data sheets."""

from typing import NamedTuple

import numpy as np

from filters.declared import Sensor

_DEGREES, _HOUR, _GRAVITY = 180 / np.pi, 3600.0, 9.80665


class Told(NamedTuple):
    """A unit in which the root of a density is given.

    Attributes:
        name: its name; "" where the unit says it.
        factor: from SI.
        unit: of the number.
    """

    name: str
    factor: float
    unit: str


def told_as(sensor: Sensor) -> tuple[Told, ...]:
    """The units for the root of a sensor's noise density, kalibr's first.

    Args:
        sensor: the kind of sensor; none for "".

    >>> [(told.name, told.unit) for told in told_as("gyroscope")][::2]
    [('gyroscope_noise_density', 'rad/s/sqrt(Hz)'), ('ARW', 'deg/sqrt(h)')]
    """
    return _TOLD.get(sensor, ())


_TOLD: dict[Sensor, tuple[Told, ...]] = {
    "gyroscope": (
        Told("gyroscope_noise_density", 1.0, "rad/s/sqrt(Hz)"),
        Told("", _DEGREES, "deg/s/sqrt(Hz)"),
        Told("ARW", _DEGREES * 60, "deg/sqrt(h)"),
    ),
    "gyroscope bias": (
        Told("gyroscope_random_walk", 1.0, "rad/s^2/sqrt(Hz)"),
        Told("RRW", _DEGREES * _HOUR * 60, "deg/h/sqrt(h)"),
    ),
    "accelerometer": (
        Told("accelerometer_noise_density", 1.0, "m/s^2/sqrt(Hz)"),
        Told("", 1e6 / _GRAVITY, "ug/sqrt(Hz)"),
        Told("VRW", 60.0, "m/s/sqrt(h)"),
    ),
    "accelerometer bias": (
        Told("accelerometer_random_walk", 1.0, "m/s^3/sqrt(Hz)"),
        Told("RRW", 60.0, "m/s^2/sqrt(h)"),
    ),
}
