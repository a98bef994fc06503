"""The competing filters: their parameters, start values, and sample rates."""

from dataclasses import dataclass, replace
from typing import Any, Literal

import jax
import jax.numpy as jnp
from jax import Array

from filters import (
    AnyFilter,
    AttitudeKalman,
    BoundedMotionKalman,
    Madgwick,
    Mahony,
    assembled,
)
from studies.broad.lead import Ahead
from tuner.problem.parameters import Limited, Parameter, Positive
from tuner.problem.space import Space

BLOCK = 0.196
"""Interval of the room filter's corrections, s; 10 to 200 ms give the same errors."""
THINNED = 60.0
"""Rate at which the gravity filters run, Hz; rates and forces are averaged down to it."""
SPEED = 0.3
"""Held: all noises of the room filter share a scale that only the start's deviations see."""
GYROSCOPE = 1e-4
"""Held: the same for the gravity filters, rad^2/s."""
LEVEL = (0.0, 0.0, 0.0, 0.0)
"""No initial attitude: the first samples determine the vertical."""

Contestant = Literal[
    "room",
    "room_now",
    "gravity",
    "two_step",
    "mahony",
    "madgwick",
    "mahony_field",
    "madgwick_field",
    "gravity_lead",
    "two_step_lead",
    "mahony_lead",
    "madgwick_lead",
    "mahony_field_lead",
    "madgwick_field_lead",
]
_LABELS: dict[str, str] = {
    "room": "strapdown navigation in a room",
    "room_now": "the same without a lead",
    "gravity": "gravity and bias, constant r",
    "two_step": "gravity and bias, the paper's adaptation",
    "mahony": "Mahony",
    "madgwick": "Madgwick",
    "mahony_field": "Mahony with a magnetometer",
    "madgwick_field": "Madgwick with a magnetometer",
}
_OTHERS = tuple(name for name in _LABELS if not name.startswith("room"))
LABELS = _LABELS | {f"{name}_lead": f"{_LABELS[name]}, with a lead" for name in _OTHERS}

LEAD = Limited(
    0.0,
    -0.02,
    0.02,
    scale=2e-3,
    limited=False,
    meaning="lead of the attitude over the last sample: delay of this sensor's gyroscopes against "
    "this truth, less half a sample; 0 for another sensor",
)
ROOM: dict[str, Parameter | float | tuple[float, ...]] = {
    "speed": SPEED,
    "gyroscope": 0.0,
    "q0": LEVEL,
}
PLAIN: dict[str, Parameter | float | tuple[float, ...]] = {
    "gyroscope": GYROSCOPE,
    "bias": Positive(1e-7, 1e-15, 1e-3),
    "accelerometer": Positive(1.0, 1e-5, 1e4),
    "tilt0": 0.03,
    "q0": LEVEL,
    "b0": (0.0, 0.0, 0.0),
}
_SPACES: dict[str, Space] = {
    "room": Space.of_filter(BoundedMotionKalman, **ROOM, lead=LEAD),
    "room_now": Space.of_filter(BoundedMotionKalman, **ROOM),
    "gravity": Space.of_filter(AttitudeKalman, **PLAIN, memory=1.0, gain=0.0, delta=1e3),
    "two_step": Space.of_filter(
        AttitudeKalman,
        **PLAIN,
        gain=Positive(10.0, 1e-4, 1e6),
        delta=Positive(0.05, 1e-3, 1.0, threshold=True),
    ),
    "mahony": Space.of_filter(Mahony, q0=LEVEL),
    "madgwick": Space.of_filter(Madgwick, q0=LEVEL),
}
_PLAIN = _SPACES | {f"{name}_field": _SPACES[name] for name in ("mahony", "madgwick")}
SPACES = _PLAIN | {
    f"{name}_lead": Space((*_PLAIN[name].parameters, ("lead", replace(LEAD, unit="s"))))
    for name in _OTHERS
}
"""Tuned parameters and their start values: round numbers, or the benchmark's published gains.

room and those that end in _lead are given the sensor's delay back; the others, room_now among
them, give the attitude of the last sample, whatever that delay.
"""


def start(name: str) -> dict[str, Array]:
    """The start values of a filter's search."""
    space = SPACES[name]
    return space.constrain(jnp.asarray(space.start()))


def takes_field(name: str) -> bool:
    """Whether a filter also uses the magnetometer."""
    return "_field" in name


def has_lead(name: str) -> bool:
    """Whether a filter's attitude is extrapolated by a tuned lead."""
    return name == "room" or name.endswith("_lead")


@dataclass(frozen=True)
class Build:
    """The map from parameters by name to those of k filters in a batch, each with its own start.

    Attributes:
        filter: the filter.
        starts: attitudes ``(k, 4)`` that they begin at, as tuples; zeros: level, heading 0.
    """

    filter: AnyFilter
    starts: tuple[tuple[float, ...], ...]

    def __call__(self, values: dict[str, Array]) -> Any:
        """Equal parameters for all trials, except for the start."""
        each = [assembled(self.filter, values | {"q0": jnp.asarray(q)}) for q in self.starts]
        return jax.tree.map(lambda *leaves: jnp.stack(leaves), *each)


def filter_of(name: str, rate_hz: float) -> AnyFilter:
    """A filter by name."""
    dt = 1 / rate_hz
    slow = dt * group(name, rate_hz)
    filters: dict[str, AnyFilter] = {
        "room": BoundedMotionKalman(dt),
        "room_now": BoundedMotionKalman(dt),
        "gravity": AttitudeKalman(slow, adaptive=False),
        "two_step": AttitudeKalman(slow),
        "mahony": Mahony(dt),
        "madgwick": Madgwick(dt),
    }
    filter = filters[_kind(name)]
    return Ahead(filter) if name.endswith("_lead") else filter


def group(name: str, rate_hz: float) -> int:
    """Number of samples in a filter's step."""
    if name.startswith("room"):
        return max(round(BLOCK * rate_hz), 1)
    return max(round(rate_hz / THINNED), 1) if _kind(name) in ("gravity", "two_step") else 1


def _kind(name: str) -> str:
    """The kind of a filter, whatever its sensors and its lead."""
    return name.removesuffix("_lead").removesuffix("_field")
