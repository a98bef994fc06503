"""The filters that compete: their parameters, where a search begins, and by what it is judged."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import jax.numpy as jnp
from jax import Array

from filters import (
    AnyFilter,
    AttitudeKalman,
    AttitudeNoise,
    BoundedMotionKalman,
    BoundedMotionNoise,
    Madgwick,
    MadgwickGain,
    Mahony,
    MahonyGains,
    shared,
)
from studies.broad.trials import GRAVITY
from tuner.problem.parameters import Limited, Parameter, Positive

BLOCK = 0.196
"""How often the room filter corrects, s; 10 to 200 ms give the same errors."""
THINNED = 60.0
"""Rate at which the gravity filters run, Hz; rates and forces are averaged down to it."""
SPEED = 0.3
"""Held: all noises of the room filter share a scale that only the start's deviations see."""
GYROSCOPE = 1e-4
"""Held: the same of the gravity filters, rad^2/s."""
LEVEL = jnp.zeros(4)
"""No attitude to begin with: the first samples say where up is."""

Contestant = Literal[
    "room",
    "room_now",
    "gravity",
    "two_step",
    "mahony",
    "madgwick",
    "mahony_field",
    "madgwick_field",
]
LABELS: dict[str, str] = {
    "room": "strapdown navigation in a room",
    "room_now": "the same without a lead",
    "gravity": "gravity and bias, constant r",
    "two_step": "gravity and bias, the paper's adaptation",
    "mahony": "Mahony",
    "madgwick": "Madgwick",
    "mahony_field": "Mahony with a magnetometer",
    "madgwick_field": "Madgwick with a magnetometer",
}


def room(values: dict[str, Array]) -> BoundedMotionNoise:
    """Parameters of the room filter."""
    fixed = {"speed": SPEED, "gyroscope": 0.0, "bias0": 0.02, "tilt0": 0.03, "lead": 0.0}
    numbers = _arrays(fixed | {"gravity": GRAVITY}) | values
    return BoundedMotionNoise(**numbers, q0=LEVEL)


def gravity(values: dict[str, Array]) -> AttitudeNoise:
    """Parameters of the gravity filter; the adaptive ones do nothing where it is not."""
    fixed = {"memory": 1.0, "gain": 0.0, "delta": 1e3, "bias0": 0.02, "tilt0": 0.03}
    numbers = _arrays(fixed | {"gravity": GRAVITY, "gyroscope": GYROSCOPE}) | values
    return AttitudeNoise(**numbers, q0=LEVEL, b0=jnp.zeros(3))


def mahony(values: dict[str, Array]) -> MahonyGains:
    """Gains of Mahony's filter."""
    return MahonyGains(**values, q0=LEVEL)


def madgwick(values: dict[str, Array]) -> MadgwickGain:
    """The gain of Madgwick's filter."""
    return MadgwickGain(**values, q0=LEVEL)


PLAIN: dict[str, Parameter] = {
    "bias": Positive(1e-7, 1e-15, 1e-3, "rad^2/s^3"),
    "accelerometer": Positive(1.0, 1e-5, 1e4),
}
LEAD = Limited(0.0, -0.02, 0.02, "s", scale=2e-3, limited=False)
FREE: dict[str, dict[str, Parameter]] = {
    "room": {
        "place": Positive(0.2, 1e-3, 1e2, "m s^0.5"),
        "accelerometer": Positive(0.03, 1e-4, 1e1, "m/s^1.5"),
        "turning": Positive(5e-4, 1e-6, 1e-1, "s^0.5"),
        "bias": Positive(2e-4, 1e-7, 1e-1, "rad/s^1.5"),
        "matrix0": Positive(3e-3, 1e-5, 1e-1),
        "lead": LEAD,
    },
    "gravity": PLAIN,
    "two_step": PLAIN
    | {
        "memory": Positive(0.5, 1e-2, 1e2, "s"),
        "gain": Positive(10.0, 1e-4, 1e6),
        "delta": Positive(0.05, 1e-3, 1.0, threshold=True),
    },
    "mahony": {
        "Kp": Positive(0.74, 1e-3, 1e2, "1/s"),
        "Ki": Positive(0.0012, 1e-7, 1e1, "1/s^2"),
    },
    "madgwick": {"beta": Positive(0.12, 1e-4, 1e1, "rad/s")},
}
"""What is tuned, and where it begins: round numbers, or the gains published for the benchmark."""
FREE["room_now"] = {name: p for name, p in FREE["room"].items() if name != "lead"}
"""The room filter without a lead: the attitude of the last sample, whatever the sensor's delay."""
PARAMETERS: dict[str, Callable[[dict[str, Array]], Any]] = {
    "room": room,
    "room_now": room,
    "gravity": gravity,
    "two_step": gravity,
    "mahony": mahony,
    "madgwick": madgwick,
}
for _name in ("mahony", "madgwick"):
    FREE[f"{_name}_field"] = FREE[_name]
    PARAMETERS[f"{_name}_field"] = PARAMETERS[_name]


def start(name: str) -> dict[str, Array]:
    """Where a filter's search begins."""
    return {key: p.constrain(jnp.asarray(p.start())) for key, p in FREE[name].items()}


def takes_field(name: str) -> bool:
    """Whether a filter takes the magnetometer too."""
    return name.endswith("_field")


@dataclass(frozen=True)
class Build:
    """From parameters by name to those of k filters side by side.

    Attributes:
        name: the filter's.
        starts: attitudes ``(k, 4)`` that they begin at, as tuples; zeros: level, heading 0.
    """

    name: str
    starts: tuple[tuple[float, ...], ...]

    def __call__(self, values: dict[str, Array]) -> Any:
        """The same for every trial but for where it begins."""
        params = shared(PARAMETERS[self.name](values), len(self.starts))
        return params._replace(q0=jnp.asarray(self.starts))


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
    return filters[name.removesuffix("_field")]


def group(name: str, rate_hz: float) -> int:
    """How many samples a step of a filter takes."""
    if name.startswith("room"):
        return max(round(BLOCK * rate_hz), 1)
    return max(round(rate_hz / THINNED), 1) if name in ("gravity", "two_step") else 1


def _arrays(numbers: dict[str, float]) -> dict[str, Array]:
    return {name: jnp.asarray(number, float) for name, number in numbers.items()}
