"""A tuned filter's results on a flight: innovations, likelihood, and attitude errors."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from filters import run
from filters.gps_aided import GpsAidedSample
from studies.uav.flights import Flight
from studies.uav.problems import Tuned, data, filter_of, parameters
from studies.uav.settings import ANGLES, Angle
from tuner.data.source import Source
from tuner.run.study import Solutions, best, tuned_values

BLOCK = 10
"""Length of blocks of innovations, whose neighbours share positions and manoeuvres."""


class Interval(NamedTuple):
    """A mean and its 95 % interval, by the spread of blocks."""

    mean: float
    low: float
    high: float

    def __str__(self) -> str:
        """As text."""
        return f"{self.mean:.3g} ({self.low:.3g} to {self.high:.3g})"


@dataclass(frozen=True, eq=False)
class Outcome:
    """A filter's run over a flight.

    Attributes:
        x: states, ``(N, 7)``.
        angles: (phi, theta, psi), rad, ``(N, 3)``.
        innovation: rad, ``(N, 3)``; NaN without a measurement.
        variance: of them, rad^2, ``(N, 3)``; NaN without a measurement.
    """

    x: np.ndarray
    angles: np.ndarray
    innovation: np.ndarray
    variance: np.ndarray

    @property
    def nis(self) -> np.ndarray:
        """Squared innovations over their variances, ``(N, 3)``; on average 1 if both fit."""
        return np.asarray(self.innovation**2 / self.variance)

    @property
    def surprise(self) -> np.ndarray:
        """Negative logarithms of the density of the measured numbers, ``(N, 3)``."""
        return (self.nis + np.log(2 * np.pi * self.variance)) / 2


@dataclass(frozen=True, eq=False)
class Field:
    """Flights with one tick, and results on them, computed once.

    Attributes:
        tuned: the flight that is tuned on.
        judged: the others.
        measured: which angles are used.
        left_out: those that are left out in turn, and tuned on the others without a glitch.
    """

    tuned: Flight
    judged: tuple[Flight, ...]
    measured: tuple[Angle, ...]
    left_out: tuple[Flight, ...] = ()
    _outcomes: dict[Any, Outcome] = field(default_factory=dict, init=False, repr=False)

    @property
    def flights(self) -> tuple[Flight, ...]:
        """All flights, the tuned one first."""
        return (self.tuned, *self.judged)

    def others(self, flight: Flight) -> tuple[Flight, ...]:
        """The other flights without a glitch."""
        return tuple(each for each in self.flights if each is not flight and not each.jumps)

    @property
    def source(self) -> Source:
        """The source of all flights."""
        text = f"flight {self.tuned.name}"
        if self.judged:
            text += f", judged on {', '.join(each.name for each in self.judged)}"
        return Source.joined(text, [each.source for each in self.flights])

    def tuned_outcome(self, flight: Flight, law: Tuned, solutions: Solutions) -> Outcome:
        """The outcome of a law on a flight, tuned on the first flight."""
        return self.outcome(flight, law, tuned_values(best(law, solutions)))

    def outcome(self, flight: Flight, law: Tuned, values: dict[str, Any]) -> Outcome:
        """The outcome of a law on a flight, with tuned values."""
        key = flight.name, law, tuple((k, float(v)) for k, v in values.items())
        if key not in self._outcomes:
            self._outcomes[key] = self._run(flight, law, values)
        return self._outcomes[key]

    def _run(self, flight: Flight, law: Tuned, values: dict[str, Any]) -> Outcome:
        length, n = max(len(each.t) for each in self.flights), len(flight.t)
        whole = data(flight, self.measured)
        # Filled up to one length, all flights share one compilation.
        z = np.full((length, 3), np.nan)
        z[:n] = whole.truth
        rate = np.zeros((length, 3))
        rate[:n] = flight.rate
        params = jax.tree.map(jnp.asarray, parameters(flight, law, values))
        filter = filter_of(law, flight.dt, flight.every)
        out = _runs(filter, params, GpsAidedSample(jnp.asarray(rate), jnp.asarray(z)))[1]
        seen = ~np.isnan(z[:n])
        innovation = np.where(seen, np.asarray(out.innovation)[:n], np.nan)
        variance = np.where(seen, np.asarray(out.variance)[:n], np.nan)
        x, angles = (np.asarray(leaf)[:n] for leaf in (out.x, out.angles))
        return Outcome(x, angles, innovation, variance)


# Run a few times only: optimised less it takes a third longer, and half the time to compile.
_runs = jax.jit(run, static_argnums=0, compiler_options={"xla_backend_optimization_level": 1})


def interval(values: np.ndarray) -> Interval:
    """The mean of values in time ``(n,)``, NaN left out, with its interval; infinite if too few.

    Blocks of :data:`BLOCK` neighbours count as one sample each.
    """
    known = values[~np.isnan(values)]
    if not len(known):
        return Interval(float("nan"), -float("inf"), float("inf"))
    blocks = [part.mean() for part in np.array_split(known, max(len(known) // BLOCK, 1))]
    mean = float(known.mean())
    if len(blocks) < 3:
        return Interval(mean, -float("inf"), float("inf"))
    half = 1.96 * float(np.std(blocks, ddof=1)) / np.sqrt(len(blocks))
    return Interval(mean, mean - half, mean + half)


def by_update(values: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """Means over the measured numbers of each update that counts ``(N,)``, ``(n,)``."""
    kept = values[keep & ~np.isnan(values).all(axis=1)]
    return np.asarray(np.nanmean(kept, axis=1)) if len(kept) else np.zeros(0)


def spread(values: np.ndarray, keep: np.ndarray) -> list[float]:
    """Root mean squares of angles in rad ``(N, 3)`` over what counts, deg; NaN where none does."""
    found = []
    for column in values[keep].T:
        known = column[~np.isnan(column)]
        found.append(float(np.degrees(np.sqrt((known**2).mean()))) if len(known) else float("nan"))
    return found


def turned(difference: np.ndarray) -> np.ndarray:
    """Differences of angles within half a turn."""
    return np.asarray((difference + np.pi) % (2 * np.pi) - np.pi)


def in_words(values: Sequence[float]) -> str:
    """Three angles, deg."""
    pairs = zip(ANGLES, values, strict=True)
    return ", ".join(f"{name} {value:.1f}" for name, value in pairs if np.isfinite(value)) + " deg"


def likeness(outcome: Outcome, keep: np.ndarray) -> float:
    """The largest correlation of an angle's normalised innovation with its next one.

    NaN where every angle has too few.
    """
    found = []
    for column in (outcome.innovation / np.sqrt(outcome.variance))[keep].T:
        known = column[~np.isnan(column)]
        if len(known) > BLOCK:
            found.append(float((known[1:] * known[:-1]).sum() / (known**2).sum()))
    return max(found, key=abs, default=np.nan)
