"""Errors of a filter on the flights, in many runs."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Lanes, PiComplementary, PiGains, PiSample, assembled, run
from filters.pi_complementary import Aid
from studies.you_lee.data import Errors, Flown, flown, measured, sensor_errors
from studies.you_lee.flight import TRAJECTORIES, Trajectory
from studies.you_lee.paper import GRAVITY
from studies.you_lee.settings import HELD_OUT, Settings, Start

CHUNK = 25
"""Runs in a batch: 42 MB of 300 s at 100 Hz."""
KEPT = 300_000_000
"""Memory for drawn errors, bytes: 100 runs, and those of the sweeps."""
SETTLED = 0.2
"""Share of level flight left out of its root mean square, 50 s of 250."""
SHOWN = 1501
"""Number of times of each run that are kept for figures."""


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


PARAMETERS = ("K1", "K2", "Q_k", "R_k", "P0", "threshold")
"""The filter's parameters that are settings."""


def known(settings: Settings, flight: Flown, start: Start) -> dict[str, Any]:
    """All parameters of the filter by name: from the settings, and from the flight's start."""
    named = {name: getattr(settings, name) for name in PARAMETERS}
    # The airspeed is known.
    x0 = flight.velocity0 if start == "true" else (flight.velocity0[0], 0.0, 0.0)
    return {**named, "gravity": GRAVITY, "angles0": flight.angles0, "x0": x0}


def gains(settings: Settings, flight: Flown, start: Start, values: Mapping[str, Any]) -> PiGains:
    """The filter's parameters: known ones, and those given by name."""
    made: PiGains = assembled(PiComplementary, known(settings, flight, start) | dict(values))
    return made


def errors_of(
    filter: PiComplementary, params: PiGains, inputs: PiSample, truth: np.ndarray
) -> np.ndarray:
    """Estimated minus true (roll, pitch) in k runs, deg, ``(N, k, 2)``."""
    side_by_side = Lanes(filter, inputs.airspeed.shape[1])
    return np.asarray(_errors(side_by_side, params, inputs, jnp.asarray(truth)))


@jax.jit(static_argnums=0)
def _errors(filter: Lanes, params: PiGains, inputs: PiSample, truth: Array) -> Array:
    return jnp.degrees(run(filter, params, inputs)[1].angles - truth[:, None])


@dataclass(frozen=True, eq=False)
class Spread:
    """Errors of k runs, deg; the last axis is (roll, pitch).

    Attributes:
        level: mean squares over level flight without its beginning, ``(k, 2)``.
        turn: over the turn.
        whole: over all.
        level_peak: largest absolute errors in level flight, ``(k, 2)``.
        turn_peak: in the turn.
        t: times of the figures, s, ``(n,)``.
        errors: at these times, ``(n, k, 2)``.
    """

    level: np.ndarray
    turn: np.ndarray
    whole: np.ndarray
    level_peak: np.ndarray
    turn_peak: np.ndarray
    t: np.ndarray
    errors: np.ndarray

    @property
    def level_rms(self) -> np.ndarray:
        """Root mean square over runs in level flight, ``(2,)``."""
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
        """All three flights."""
        return {name: flown(self.settings, name) for name in TRAJECTORIES}

    @cached_property
    def _known(self) -> dict[tuple[Case, int], Spread]:
        return {}

    @cached_property
    def _drawn(self) -> dict[tuple[int, int], Errors]:
        return {}

    @cached_property
    def train(self) -> tuple[PiSample, np.ndarray]:
        """Training data: inputs ``(N, k, ...)`` and truth ``(N, 2)``."""
        flight = self.flights[self.settings.trajectory]
        errors = sensor_errors(self.settings, self.seed, self.settings.train)
        return measured(flight, errors), flight.truth

    def shown(self) -> Iterator[PiSample]:
        """Sensor readings of all runs: those that are tuned on, and then the others."""
        yield self.train[0]
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
        self._known.update({(case, count): _concatenated(part) for case, part in parts.items()})
        return [self._known[case, count] for case in cases]

    def _chunks(self, count: int) -> Iterator[Errors]:
        """The sensors' errors in a number of runs; as many as fit :data:`KEPT` are drawn once."""
        for begin in range(0, count, CHUNK):
            key = count, begin
            errors = self._drawn.get(key)
            if errors is None:
                part = slice(begin, begin + CHUNK)
                errors = sensor_errors(self.settings, self.seed + HELD_OUT, count, part)
                if sum(map(_bytes, (errors, *self._drawn.values()))) <= KEPT:
                    self._drawn[key] = errors
            yield errors

    def _one(self, case: Case, errors: Errors) -> Spread:
        flight = self.flights[case.trajectory]
        params = gains(self.settings, flight, case.start, dict(case.values))
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
        errors=errors[kept],
    )


def _bytes(errors: Errors) -> int:
    return sum(part.nbytes for part in errors)


def _mean_square(errors: np.ndarray) -> np.ndarray:
    return np.asarray((errors**2).mean(axis=0))


def _concatenated(parts: list[Spread]) -> Spread:
    """The runs of all parts joined."""

    def along(name: str) -> np.ndarray:
        if name == "t":
            return parts[0].t
        return np.concatenate([getattr(part, name) for part in parts], 1 if name == "errors" else 0)

    return Spread(**{field.name: along(field.name) for field in fields(Spread)})
