"""The filters that compete, and the problems they are tuned by."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import (
    AnyFilter,
    GravityKalman,
    GravityNoise,
    ImuSample,
    Madgwick,
    MadgwickGain,
    Mahony,
    MahonyGains,
    RoomKalman,
    RoomNoise,
    Several,
    run,
    shared,
)
from objectives import AttitudeRmse, Data, Records
from studies.broad.trials import GRAVITY, Trial
from tuner.parameters import Limited, Parameter, Positive
from tuner.problem import Problem
from tuner.space import Space

BLOCK = 0.196
"""How often the room filter corrects, s; 10 to 200 ms give the same errors."""
THINNED = 60.0
"""Rate at which the gravity filters run, Hz; rates and forces are averaged down to it."""
SPEED = 0.3
"""Held: all noises of the room filter share a scale that only the start's deviations see."""
LEVEL = jnp.zeros(4)
"""No attitude to begin with: the first samples say where up is."""


@dataclass(frozen=True)
class Inclination:
    """Root mean square inclination error of one trial, deg."""

    def __call__(self, outputs: Any, truth: Array) -> Array:
        """Of quaternions, or of outputs that have some; in blocks or not."""
        q = getattr(outputs, "q", outputs)
        return AttitudeRmse()(q.reshape(-1, 4), truth.reshape(-1, 4))


OBJECTIVE = Records(Inclination())


def room(values: dict[str, Array]) -> RoomNoise:
    """Parameters of the room filter."""
    fixed = {"speed": SPEED, "gyroscope": 0.0, "bias0": 0.02, "tilt0": 0.03, "lead": 0.0}
    numbers = _arrays(fixed | {"gravity": GRAVITY}) | values
    return RoomNoise(**numbers, q0=LEVEL)


def gravity(values: dict[str, Array]) -> GravityNoise:
    """Parameters of the gravity filter; the adaptive ones do nothing where it is not."""
    fixed = {"memory": 1.0, "gain": 0.0, "delta": 1e3, "bias0": 0.02, "tilt0": 0.03}
    numbers = _arrays(fixed | {"gravity": GRAVITY}) | values
    return GravityNoise(**numbers, q0=LEVEL, b0=jnp.zeros(3))


def mahony(values: dict[str, Array]) -> MahonyGains:
    """Gains of Mahony's filter."""
    return MahonyGains(**values, q0=LEVEL)


def madgwick(values: dict[str, Array]) -> MadgwickGain:
    """The gain of Madgwick's filter."""
    return MadgwickGain(**values, q0=LEVEL)


PLAIN: dict[str, Parameter] = {
    "gyroscope": Positive(1e-6, 1e-14, 1e-2, "rad^2/s"),
    "bias": Positive(1e-9, 1e-17, 1e-4, "rad^2/s^3"),
    "accelerometer": Positive(1.0, 1e-4, 1e4),
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
        "kp": Positive(0.74, 1e-3, 1e2, "1/s"),
        "ki": Positive(0.0012, 1e-7, 1e1, "1/s^2"),
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


@dataclass(frozen=True)
class Build:
    """From parameters by name to those of k filters side by side."""

    name: str
    count: int

    def __call__(self, values: dict[str, Array]) -> Any:
        """The same for every trial."""
        return shared(PARAMETERS[self.name](values), self.count)


def filter_of(name: str, rate_hz: float) -> AnyFilter:
    """A filter by name."""
    dt = 1 / rate_hz
    slow = dt * _group(name, rate_hz)
    filters: dict[str, AnyFilter] = {
        "room": RoomKalman(dt),
        "room_now": RoomKalman(dt),
        "gravity": GravityKalman(slow, adaptive=False),
        "two_step": GravityKalman(slow),
        "mahony": Mahony(dt),
        "madgwick": Madgwick(dt),
    }
    return filters[name]


def side_by_side(name: str, trials: Sequence[Trial]) -> Data:
    """Trials as a filter takes them; shorter ones are filled up with their last sample at rest.

    For the room filter samples are in blocks, for the gravity filters averaged in groups, whose
    truth is that of their last sample.
    """
    length = _group(name, trials[0].rate_hz)
    count = max(len(trial.rate) for trial in trials) // length
    acceleration = _cut([trial.acceleration for trial in trials], count, length, "edge")
    rate = _cut([trial.rate for trial in trials], count, length, "zero")
    truth = _cut([trial.truth for trial in trials], count, length, "nan")
    if name.startswith("room"):
        return Data(ImuSample(acceleration, rate), truth)
    samples = ImuSample(acceleration.mean(axis=2), rate.mean(axis=2))
    return Data(samples, truth[:, :, -1])


def _group(name: str, rate_hz: float) -> int:
    """How many samples a step of a filter takes."""
    if name.startswith("room"):
        return max(round(BLOCK * rate_hz), 1)
    return max(round(rate_hz / THINNED), 1) if name in ("gravity", "two_step") else 1


def _cut(
    parts: list[np.ndarray], count: int, length: int, fill: Literal["edge", "zero", "nan"]
) -> Array:
    """Records ``(N, d)`` as ``(count, k, length, d)``."""
    whole = []
    for part in parts:
        last = {"edge": part[-1], "zero": 0 * part[-1], "nan": np.nan * part[-1]}[fill]
        rest = np.broadcast_to(last, (max(count * length - len(part), 0), part.shape[1]))
        filled = np.concatenate([part[: count * length], rest])
        whole.append(filled.reshape(count, length, -1))
    return jnp.asarray(np.stack(whole, axis=1))


def problem(title: str, name: str, trials: Sequence[Trial]) -> Problem:
    """A filter tuned on trials.

    Args:
        title: what the problem is called.
        name: the filter's.
        trials: what it is tuned on.
    """
    return Problem(
        name=title,
        space=Space.of(**FREE[name]),
        filter=Several(filter_of(name, trials[0].rate_hz)),
        build=Build(name, len(trials)),
        objective=OBJECTIVE,
        data=side_by_side(name, trials),
    )


def judged(name: str, values: dict[str, Array], trials: Sequence[Trial]) -> np.ndarray:
    """The errors of single trials, deg, ``(k,)``."""
    params = shared(PARAMETERS[name](values), len(trials))
    data = side_by_side(name, trials)
    return np.asarray(_judged(filter_of(name, trials[0].rate_hz), params, data))


@jax.jit(static_argnums=0)
def _judged(filter: AnyFilter, params: Any, data: Data) -> Array:
    return OBJECTIVE.each(run(Several(filter), params, data.inputs)[1], data.truth)


def _arrays(numbers: dict[str, float]) -> dict[str, Array]:
    return {name: jnp.asarray(number) for name, number in numbers.items()}
