"""Kownacki's two sensors, with their published values."""

from collections.abc import Callable
from dataclasses import dataclass

from jax import Array

from filters import (
    AccelerometerFilter,
    Channel,
    GyroscopeFilter,
    SteadyState,
    accelerometer_steady,
    gyroscope_steady,
)
from tuner.data.noise_split import NoiseSplit


@dataclass(frozen=True)
class Sensor:
    """One of the paper's two sensors: its filter and its published values.

    Attributes:
        name: of its rows and files.
        channel: of its record, for ``--map``.
        unit: of its record; the paper prints none.
        filter: its filter, (8) or (9).
        steady: its steady gains in closed form.
        states: estimated ones; the accelerometer's velocity is not observable.
        table1: R and Q from a motionless record.
        table2: R and Q from the optimisation.
    """

    name: str
    channel: str
    unit: str
    filter: type[AccelerometerFilter] | type[GyroscopeFilter]
    steady: Callable[[Array | float, float], SteadyState]
    states: tuple[str, ...]
    table1: NoiseSplit
    table2: NoiseSplit


GYRO = Sensor(
    "gyro",
    "omega",
    "rad/s",
    GyroscopeFilter,
    gyroscope_steady,
    ("omega", "epsilon"),
    NoiseSplit(1.3872e-6, 2.4907e-9),
    NoiseSplit(1.9148e-10, 1.9674e-7),
)
ACC = Sensor(
    "acc",
    "a",
    "m/s^2",
    AccelerometerFilter,
    accelerometer_steady,
    ("a",),
    NoiseSplit(1.8472e-4, 1.1859e-8),
    NoiseSplit(5.8631e-13, 1.3458e-11),
)


def channels(settings: object) -> dict[str, Channel]:
    """Channels for ``--map``: a record of either sensor at rest."""
    return {
        "omega": Channel("rad/s", "gyroscope: angular rate"),
        "a": Channel("m/s^2", "accelerometer: acceleration"),
    }
