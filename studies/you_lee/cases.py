"""What the sensors measure, and what a filter makes of it in many runs."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields
from functools import cached_property
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Batched, PiComplementary, PiGains, PiSample, VelocityNoise, run, shared
from filters.pi_complementary import Aid
from studies.you_lee.flight import TRAJECTORIES, Motion, Trajectory, motion
from studies.you_lee.settings import GRAVITY, HELD_OUT, Settings, Start
from tuner.data.simulation import Sensor, even_normals

PER_HOUR = float(np.radians(1.0)) / 3600
"""1 deg/h in rad/s."""
MICRO = 1e-6 * GRAVITY
"""1 ug in ft/s^2."""
CHUNK = 25
"""Runs side by side: 42 MB of 300 s at 100 Hz."""
ALL = slice(None)
SETTLED = 0.2
"""The level root mean square leaves out this share of level flight, 50 s of 250."""
SHOWN = 301
"""Moments of each run that are kept for figures."""


class Case(NamedTuple):
    """A filter on a flight.

    Attributes:
        trajectory: which flight.
        aid: which filter.
        start: of the velocity filter.
        values: parameters by name that are not the settings'.
    """

    trajectory: Trajectory
    aid: Aid
    start: Start = "zero"
    values: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, eq=False)
class Flown:
    """What filters start from and are held against; sensors are exact at mid-interval.

    Attributes:
        angles0, velocity0: true ones at the start, rad and ft/s.
        sensed: what exact sensors show, ``(N, ...)``.
        truth: (roll, pitch) at the ends of the intervals, rad, ``(N, 2)``.
    """

    angles0: tuple[float, ...]
    velocity0: tuple[float, ...]
    sensed: Motion
    truth: np.ndarray


def flown(settings: Settings, trajectory: Trajectory) -> Flown:
    """One flight."""
    t = settings.dt / 2 * np.arange(2 * settings.samples + 1)
    known = [np.asarray(part) for part in motion(trajectory, settings.course, jnp.asarray(t))]
    angles, velocity = known[0], known[-1]
    sensed = Motion(*(jnp.asarray(part[1::2]) for part in known))
    return Flown(tuple(angles[0].tolist()), tuple(velocity[0].tolist()), sensed, angles[2::2])


def deterministic(settings: Settings, flight: Flown, axes: tuple[int, ...]) -> PiSample:
    """One run with table 1's deviations as constant errors, on some of the sensors' axes.

    Args:
        settings: say how large they are.
        flight: what is flown.
        axes: 0 to 2 for p, q, r, and 3 to 5 for fx, fy, fz.
    """
    on = np.isin(np.arange(6), axes)
    still = np.zeros((settings.samples, 1, 3))
    errors = Errors(
        still + settings.acc_bias * MICRO * on[3:],
        still + settings.gyro_bias * PER_HOUR * on[:3],
        still[..., 0],
    )
    return measured(flight, errors)


class Errors(NamedTuple):
    """Of the sensors in k runs: ``(N, k, 3)``, ``(N, k, 3)``, ``(N, k)``."""

    force: np.ndarray
    rate: np.ndarray
    airspeed: np.ndarray


def sensor_errors(settings: Settings, first: int, count: int, part: slice = ALL) -> Errors:
    """Table 1's errors in runs with the seeds first, first + 1, ..; every flight gets the same.

    The biases at turn-on decide most of an error, so those of all runs together are spread evenly.

    Args:
        settings: of the study.
        first: seed of the first run.
        count: how many runs there are.
        part: which of them are made; all if left out.
    """
    still = np.zeros((settings.samples, 3))
    hour = np.sqrt(3600.0)
    gyro_walk, acc_walk = settings.gyro_walk * PER_HOUR / hour, settings.acc_walk * MICRO / hour
    gyro_bias, acc_bias = settings.gyro_bias * PER_HOUR, settings.acc_bias * MICRO
    turn_on = even_normals(count, 6, first)
    runs = list(zip(range(first, first + count), turn_on, strict=True))
    made = []
    for seed, start in runs[part]:
        gyro = Sensor(walk=gyro_walk, bias=tuple(gyro_bias * start[:3]))
        acc = Sensor(walk=acc_walk, bias=tuple(acc_bias * start[3:]))
        draw = np.random.default_rng([seed, 2])
        made.append(
            (
                acc.measure(still, settings.dt, seed + 2**31),
                gyro.measure(still, settings.dt, seed),
                settings.airspeed_noise * draw.normal(size=len(still)),
            )
        )
    return Errors(*(np.stack(errors, axis=1) for errors in zip(*made, strict=True)))


def measured(flight: Flown, errors: Errors) -> PiSample:
    """What the sensors show of a flight in k runs, ``(N, k, ...)``."""
    # In NumPy: nothing has to be compiled for so many runs.
    force, rate = np.asarray(flight.sensed.force), np.asarray(flight.sensed.rate)
    u = np.asarray(flight.sensed.velocity)[:, :1]
    shown = force[:, None] + errors.force, rate[:, None] + errors.rate, u + errors.airspeed
    return PiSample(*map(jnp.asarray, shown))


def gains(settings: Settings, flight: Flown, start: Start, values: dict[str, Array]) -> PiGains:
    """What the filter takes: the settings' parameters, and those given by name."""
    known = {name: jnp.asarray(getattr(settings, name), float) for name in PARAMETERS} | values
    x0 = jnp.asarray(start_velocity(flight, start), float)
    noise = VelocityNoise(known["Q_k"], known["R_k"], known["threshold"], x0, known["P0"])
    angles0 = jnp.asarray(flight.angles0, float)
    return PiGains(known["K1"], known["K2"], jnp.asarray(GRAVITY, float), angles0, noise)


def start_velocity(flight: Flown, start: Start) -> tuple[float, ...]:
    """(u, v, w) that the velocity filter starts from; the airspeed is known."""
    return flight.velocity0 if start == "true" else (flight.velocity0[0], 0.0, 0.0)


PARAMETERS = ("K1", "K2", "Q_k", "R_k", "P0", "threshold")


def errors_of(
    filter: PiComplementary, params: PiGains, inputs: PiSample, truth: np.ndarray
) -> np.ndarray:
    """Estimated minus true (roll, pitch) in k runs, deg, ``(N, k, 2)``."""
    count = inputs.airspeed.shape[1]
    return np.asarray(_errors(filter, shared(params, count), inputs, jnp.asarray(truth)))


@jax.jit(static_argnums=0)
def _errors(filter: PiComplementary, params: PiGains, inputs: PiSample, truth: Array) -> Array:
    angles = run(Batched(filter), params, inputs)[1].angles
    return jnp.degrees(angles - truth[:, None])


@dataclass(frozen=True, eq=False)
class Spread:
    """Errors of k runs, deg; the last axis is (roll, pitch).

    Attributes:
        level: mean squares over level flight without its beginning, ``(k, 2)``.
        turn: over the turn.
        whole: over all.
        level_peak: largest absolute errors in level flight, ``(k, 2)``.
        turn_peak: in the turn.
        t: moments that are shown, s, ``(n,)``.
        shown: errors there, ``(n, k, 2)``.
    """

    level: np.ndarray
    turn: np.ndarray
    whole: np.ndarray
    level_peak: np.ndarray
    turn_peak: np.ndarray
    t: np.ndarray
    shown: np.ndarray

    @property
    def level_rms(self) -> np.ndarray:
        """Over runs, ``(2,)``."""
        return np.asarray(np.sqrt(self.level.mean(axis=0)))

    @property
    def whole_rms(self) -> float:
        """Root of the mean over time and runs of roll^2 + pitch^2."""
        return float(np.sqrt(self.whole.mean(axis=0).sum()))

    @property
    def turn_rms(self) -> float:
        """The same in the turn."""
        return float(np.sqrt(self.turn.mean(axis=0).sum()))

    @property
    def turn_maximum(self) -> np.ndarray:
        """The mean over runs of the largest error, ``(2,)``."""
        return np.asarray(self.turn_peak.mean(axis=0))


@dataclass(frozen=True, eq=False)
class Bench:
    """Monte Carlo runs of any case on the same errors of the sensors.

    Attributes:
        settings: of the study.
        seed: of the first run that is tuned on; Monte Carlo runs have others.
    """

    settings: Settings
    seed: int

    @cached_property
    def flights(self) -> dict[Trajectory, Flown]:
        """All three."""
        return {name: flown(self.settings, name) for name in TRAJECTORIES}

    @cached_property
    def _known(self) -> dict[tuple[Case, int], Spread]:
        return {}

    def train(self) -> tuple[PiSample, np.ndarray]:
        """What is tuned on: inputs ``(N, k, ...)`` and truth ``(N, 2)``."""
        flight = self.flights[self.settings.trajectory]
        errors = sensor_errors(self.settings, self.seed, self.settings.train)
        return measured(flight, errors), flight.truth

    def shown(self) -> Iterator[PiSample]:
        """What the sensors show in all runs: those that are tuned on, and then the others."""
        yield self.train()[0]
        flight = self.flights[self.settings.trajectory]
        for errors in self._chunks(self.settings.runs):
            yield measured(flight, errors)

    def spread(self, case: Case, runs: int | None = None) -> Spread:
        """One case; see :meth:`spreads`."""
        return self.spreads([case], runs)[0]

    def spreads(self, cases: Iterable[Case], runs: int | None = None) -> list[Spread]:
        """Each case over all Monte Carlo runs, or fewer; in chunks, and only once."""
        cases, count = list(cases), min(runs or self.settings.runs, self.settings.runs)
        wanted = [case for case in dict.fromkeys(cases) if (case, count) not in self._known]
        parts: dict[Case, list[Spread]] = {case: [] for case in wanted}
        for errors in self._chunks(count) if wanted else ():
            for case in wanted:
                parts[case].append(self._one(case, errors))
        self._known.update({(case, count): _joined(part) for case, part in parts.items()})
        return [self._known[case, count] for case in cases]

    def _chunks(self, count: int) -> Iterator[Errors]:
        for begin in range(0, count, CHUNK):
            part = slice(begin, begin + CHUNK)
            yield sensor_errors(self.settings, self.seed + HELD_OUT, count, part)

    def _one(self, case: Case, errors: Errors) -> Spread:
        flight = self.flights[case.trajectory]
        values = {name: jnp.asarray(value, float) for name, value in case.values}
        params = gains(self.settings, flight, case.start, values)
        filter = PiComplementary(self.settings.dt, case.aid)
        found = errors_of(filter, params, measured(flight, errors), flight.truth)
        return judged(self.settings, found)


def judged(settings: Settings, errors: np.ndarray) -> Spread:
    """The errors ``(N, k, 2)`` by phases."""
    t = settings.dt * np.arange(1, len(errors) + 1)
    level, late = t <= settings.level + settings.dt / 2, t >= SETTLED * settings.level
    kept = np.unique(np.linspace(0, len(t) - 1, min(SHOWN, len(t))).astype(int))
    return Spread(
        level=_mean_square(errors[level & late]),
        turn=_mean_square(errors[~level]),
        whole=_mean_square(errors),
        level_peak=np.abs(errors[level]).max(axis=0),
        turn_peak=np.abs(errors[~level]).max(axis=0),
        t=t[kept],
        shown=errors[kept],
    )


def _mean_square(errors: np.ndarray) -> np.ndarray:
    return np.asarray((errors**2).mean(axis=0))


def _joined(parts: list[Spread]) -> Spread:
    """The runs of all parts together."""

    def along(name: str) -> np.ndarray:
        if name == "t":
            return parts[0].t
        return np.concatenate([getattr(part, name) for part in parts], 1 if name == "shown" else 0)

    return Spread(**{field.name: along(field.name) for field in fields(Spread)})
