"""A flight on equal ticks: inertial samples, positions, and the attitude constructed from them."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from filters.dead_reckoning import constructed_attitude
from studies.uav.recordings import Delays, Recording, Units, read
from studies.uav.settings import Settings
from tuner.data.record import Record
from tuner.data.source import Source

APART = 1.0
"""Interval of the three positions of a constructed attitude, s."""
LONGEST_HOLE = 1.0
"""Longest interval of fixes that are interpolated, s."""
JUMP = 30.0
"""Largest change of the ground speed without a glitch, m/s^2."""
AROUND = 5.0
"""Time before and after a jump in which the GPS is not trusted, s."""
AGREES = 0.5
"""The least correlation with the gyroscopes of an attitude that may serve as a reference."""


class Whole(NamedTuple):
    """Inertial readings at all ticks, those before the first constructed attitude too.

    Attributes:
        force: mean specific force over each tick, forward, right, down, m/s^2, ``(N, 3)``.
        rate: mean angular rate likewise, rad/s, ``(N, 3)``.
        reference: the autopilot's (phi, theta, psi), ``(N, 3)``; None without a usable one.
        moves: whether the ground speed is above that of a constructed attitude, ``(N,)``.
    """

    force: np.ndarray
    rate: np.ndarray
    reference: np.ndarray | None
    moves: np.ndarray


@dataclass(frozen=True, eq=False)
class Flight:
    """A flight from its first constructed attitude on; tick k ends at time ``t[k]``.

    Attributes:
        dt: interval of ticks, s.
        t: times, s, ``(N,)``.
        rate: mean of the gyroscopes over each tick, rad/s, ``(N, 3)``.
        z: constructed (phi, theta, psi) at the tick it refers to, rad, ``(N, 3)``; NaN where there
            is none.
        first: the attitude from which it begins, one tick before, ``(3,)``.
        position: north, east, down of the first fix, m, ``(N, 3)``; NaN in holes of the GPS.
        speed: of the GPS, m/s, ``(N,)``.
        reference: the autopilot's (phi, theta, psi), ``(N, 3)``; None without a usable one.
        glitch: whether the GPS is not trusted, ``(N,)``.
        jumps: times at which the ground speed jumps, s.
        whole: the inertial sensors' ticks from the recording's beginning.
        source: the recording, with the number of ticks and their rate.
    """

    dt: float
    t: np.ndarray
    rate: np.ndarray
    z: np.ndarray
    first: np.ndarray
    position: np.ndarray
    speed: np.ndarray
    reference: np.ndarray | None
    glitch: np.ndarray
    jumps: tuple[float, ...]
    whole: Whole
    source: Source

    @property
    def name(self) -> str:
        """Name of the recording."""
        return self.source.name

    @property
    def every(self) -> int:
        """Ticks between measurements."""
        return round(APART / self.dt)


def flown(settings: Settings) -> tuple[Flight, ...]:
    """The flight that is tuned on, and those that are judged on.

    Raises:
        ValueError: where one is named twice, cannot be used, or has a glitch and is tuned on.
    """
    if settings.tuned in settings.judged or len(set(settings.judged)) < len(settings.judged):
        raise ValueError(
            f"{settings.tuned} is tuned on, and {', '.join(settings.judged) or 'none'} judged on; "
            "name every flight once"
        )
    tuned, *judged = (_flown(settings, name) for name in (settings.tuned, *settings.judged))
    if tuned.jumps:
        raise ValueError(
            f"the ground speed of {tuned.name} jumps at {tuned.jumps[0]:.1f} s, a GPS glitch; tune "
            "on another flight, --set tuned=NAME, or on the time before, --set seconds=N"
        )
    return tuned, *judged


def _flown(settings: Settings, name: str) -> Flight:
    units = Units(settings.acc_unit, settings.gyr_unit)
    delays = Delays(settings.velocity_delay, settings.position_delay)
    recording = read(settings.folder, name, units, delays)
    whole = flight(recording, 1 / settings.ticks_per_second, settings.slowest, settings.gravity)
    return cut(whole, settings.seconds)


def over_ticks(t: np.ndarray, values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Means between neighbouring edges of samples joined by straight lines, ``(len - 1, d)``.

    The integral over any number of ticks is that of the samples, whatever their spacing.
    """
    steps = np.diff(t)[:, None] * (values[1:] + values[:-1]) / 2
    total = np.vstack([np.zeros((1, values.shape[1])), np.cumsum(steps, axis=0)])
    at = np.clip(np.searchsorted(t, edges, side="right") - 1, 0, len(t) - 2)
    part, step = (edges - t[at])[:, None], (t[at + 1] - t[at])[:, None]
    slope = (values[at + 1] - values[at]) / step
    whole = total[at] + part * values[at] + part**2 / 2 * slope
    return np.asarray(np.diff(whole, axis=0) / np.diff(edges)[:, None])


def flight(recording: Recording, dt: float, slowest: float, gravity: float) -> Flight:
    """A recording on ticks.

    The GPS tells of the past: a fix that came in at t is taken for t - delay. The attitude that
    three positions make refers to the middle one and is put there, so that the filter runs one
    second and the delay behind the time of flight.

    Raises:
        ValueError: where no attitude can be constructed.
    """
    channels, late = recording.record.channels, recording.delays
    acc, gyr, fixes, speed = (channels[name] for name in ("acc", "gyr", "position", "speed"))
    begin = max(acc.times[0], fixes.times[0] - late.position)
    end = min(acc.times[-1], fixes.times[-1] - max(late))
    count = int((end - begin) / dt)
    edges = begin + dt * np.arange(count + 1)
    force = over_ticks(acc.times, acc.values, edges)
    position = _interpolated(fixes.times - late.position, fixes.values, edges[1:])
    z = _constructed(position, force, dt, slowest, gravity)
    seen = np.flatnonzero(~np.isnan(z).any(axis=1))
    if len(seen) < 10:
        raise ValueError(
            f"{recording.record.name} gives {len(seen)} attitudes from three positions (10 are "
            f"needed): it hardly moves faster than {slowest:g} m/s; take another flight, or more "
            "of this one"
        )
    kept = slice(int(seen[0]) + 1, None)
    t = edges[1:]
    measured_at = speed.times - late.speed
    jumps = _jumps(measured_at, speed.values[:, 0])
    ground = np.hypot(*speed.values.T)[:, None]
    near = [np.abs(t - at) <= AROUND for at in jumps]
    reference = _reference(recording.record, edges)
    rate, along = over_ticks(gyr.times, gyr.values, edges), _interpolated(measured_at, ground, t)
    found = Flight(
        dt=dt,
        t=t[kept],
        rate=rate[kept],
        z=z[kept],
        first=z[seen[0]],
        position=position[kept],
        speed=along[kept, 0],
        reference=None if reference is None else reference[kept],
        glitch=(np.any(near, axis=0) if near else np.zeros(len(t), bool))[kept],
        jumps=jumps,
        whole=Whole(force, rate, reference, along[:, 0] > slowest),
        source=recording.record.sources[0],
    )
    return replace(found, source=replace(found.source, samples=len(found.t), rate_hz=1 / dt))


def cut(whole: Flight, seconds: float | None) -> Flight:
    """The first seconds of a flight."""
    if seconds is None:
        return whole
    n = round(seconds / whole.dt)
    names = ("t", "rate", "z", "position", "speed", "glitch")
    parts = {name: getattr(whole, name)[:n] for name in names}
    reference = None if whole.reference is None else whole.reference[:n]
    felt = whole.whole
    end = len(felt.rate) - len(whole.t) + len(parts["t"])
    shorter = Whole(*(None if part is None else part[:end] for part in felt))  # type: ignore[arg-type]
    jumps = tuple(at for at in whole.jumps if at <= parts["t"][-1] + AROUND)
    source = replace(whole.source, samples=len(parts["t"]))
    return replace(whole, **parts, reference=reference, jumps=jumps, whole=shorter, source=source)


def _interpolated(t: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Linearly interpolated values; NaN in gaps."""
    found = np.stack([np.interp(at, t, column) for column in values.T], axis=1)
    after = np.clip(np.searchsorted(t, at), 1, len(t) - 1)
    hole = (t[after] - t[after - 1] > LONGEST_HOLE) | (at < t[0] - 1e-9) | (at > t[-1] + 1e-9)
    return np.where(hole[:, None], np.nan, found)


def _constructed(
    position: np.ndarray, force: np.ndarray, dt: float, slowest: float, gravity: float
) -> np.ndarray:
    """Attitudes at every tick that closes a second, ``(N, 3)``; NaN elsewhere."""
    step = round(APART / dt)
    middle = np.arange(2 * step - 1, len(position) - step, step)
    z = np.full(position.shape, np.nan)
    if not len(middle):
        return z
    total = np.vstack([np.zeros((1, 3)), np.cumsum(force, axis=0)])
    mean = (total[middle + step + 1] - total[middle - step + 1]) / (2 * step)
    three = np.stack([position[middle - step], position[middle], position[middle + step]], axis=1)

    def one(positions: jax.Array, acceleration: jax.Array) -> jax.Array:
        return constructed_attitude(
            positions, acceleration, dt=APART, gravity=gravity, slowest=slowest
        )

    z[middle] = jax.vmap(one)(jnp.asarray(three), jnp.asarray(mean))
    return z


def _jumps(t: np.ndarray, ground: np.ndarray) -> tuple[float, ...]:
    """Times at which the ground speed changes faster than a vehicle can."""
    steep = np.abs(np.diff(ground)) > JUMP * np.diff(t)
    return tuple(float(at) for at in t[1:][steep])


def _reference(record: Record, edges: np.ndarray) -> np.ndarray | None:
    """The autopilot's attitude at the ticks' ends; None where the gyroscopes contradict it."""
    if "angles" not in record.channels:
        return None
    pilot, gyr = record.channels["angles"], record.channels["gyr"]
    angles = np.unwrap(pilot.values, axis=0)
    found = np.stack([np.interp(edges, pilot.times, a) for a in angles.T], axis=1)
    step = max(round(0.5 / float(edges[1] - edges[0])), 1)
    turned = np.diff(found[::step], axis=0)
    rates = over_ticks(gyr.times, gyr.values, edges[::step])
    agreeing = [
        float(np.corrcoef(a, b)[0, 1]) if a.std() and b.std() else 0.0
        for a, b in zip(turned.T, rates.T, strict=True)
    ]
    return found[1:] if np.median(agreeing) > AGREES else None
