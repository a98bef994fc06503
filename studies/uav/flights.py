"""A flight on equal ticks: inertial samples, positions, and the attitude constructed from them."""

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np

from filters.dead_reckoning import constructed_attitude
from studies.uav.recordings import Recording

APART = 1.0
"""Between the three positions of a constructed attitude, s."""
LONGEST_HOLE = 1.0
"""Between fixes that are joined by a line, s."""
JUMP = 30.0
"""A ground speed that changes faster than this is a glitch, m/s^2."""
AROUND = 5.0
"""So long before and after a jump the GPS is not believed, s."""
AGREES = 0.5
"""The least correlation with the gyroscopes of an attitude that may serve as a reference."""
SEMI_MAJOR, FLATTENING = 6378137.0, 1 / 298.257223563


@dataclass(frozen=True, eq=False)
class Flight:
    """A flight from its first constructed attitude on; tick k ends at time ``t[k]``.

    Attributes:
        name: of the recording.
        dt: between ticks, s.
        t: times, s, ``(N,)``.
        rate: mean of the gyroscopes over each tick, rad/s, ``(N, 3)``.
        z: constructed (phi, theta, psi) at the tick it refers to, rad, ``(N, 3)``; NaN where there
            is none.
        first: the attitude from which it begins, one tick before, ``(3,)``.
        position: north, east, down of the first fix, m, ``(N, 3)``; NaN in holes of the GPS.
        speed: of the GPS, m/s, ``(N,)``.
        reference: the autopilot's (phi, theta, psi), ``(N, 3)``; None without a usable one.
        glitch: whether the GPS is not believed, ``(N,)``.
        jumps: times at which the ground speed jumps, s.
        sha256: of the recording.
    """

    name: str
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
    sha256: str

    @property
    def every(self) -> int:
        """Ticks between measurements."""
        return round(APART / self.dt)


def local(place: np.ndarray) -> np.ndarray:
    """North, east, down of the first fix, m, ``(N, 3)``.

    North is M dphi and east N cos(phi0) dlambda, with the ellipsoid's radii of curvature at the
    first latitude phi0 (WGS 84), M = a (1 - e^2) / w^3 and N = a / w, w^2 = 1 - e^2 sin^2 phi0:
    what it neglects is of the second order, 2 cm within 500 m.

    Args:
        place: latitude and longitude, deg, and height, m, ``(N, 3)``.
    """
    e2 = FLATTENING * (2 - FLATTENING)
    latitude = np.radians(place[0, 0])
    w = np.sqrt(1 - e2 * np.sin(latitude) ** 2)
    moved = place - place[0]
    east = np.radians((moved[:, 1] + 180) % 360 - 180)
    along = SEMI_MAJOR * (1 - e2) / w**3 * np.radians(moved[:, 0])
    return np.stack([along, SEMI_MAJOR / w * np.cos(latitude) * east, -moved[:, 2]], axis=1)


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
    velocity_late, position_late = recording.delays
    begin = max(recording.imu_t[0], recording.gps_t[0] - position_late)
    end = min(recording.imu_t[-1], recording.gps_t[-1] - max(position_late, velocity_late))
    count = int((end - begin) / dt)
    edges = begin + dt * np.arange(count + 1)
    force = over_ticks(recording.imu_t, recording.force, edges)
    position = _joined(recording.gps_t - position_late, local(recording.place), edges[1:])
    z = _constructed(position, force, dt, slowest, gravity)
    seen = np.flatnonzero(~np.isnan(z).any(axis=1))
    if len(seen) < 10:
        raise ValueError(
            f"{recording.name} gives {len(seen)} attitudes from three positions (10 are needed): "
            f"it hardly moves faster than {slowest:g} m/s; take another flight, or more of this one"
        )
    kept = slice(int(seen[0]) + 1, None)
    t = edges[1:]
    jumps = _jumps(recording)
    speeds = np.hypot(*recording.speed.T)[:, None]
    near = [np.abs(t - at) <= AROUND for at in jumps]
    reference = _reference(recording, edges)
    return Flight(
        name=recording.name,
        dt=dt,
        t=t[kept],
        rate=over_ticks(recording.imu_t, recording.rate, edges)[kept],
        z=z[kept],
        first=z[seen[0]],
        position=position[kept],
        speed=_joined(recording.gps_t - velocity_late, speeds, t)[kept, 0],
        reference=None if reference is None else reference[kept],
        glitch=(np.any(near, axis=0) if near else np.zeros(len(t), bool))[kept],
        jumps=jumps,
        sha256=recording.sha256,
    )


def cut(whole: Flight, seconds: float | None) -> Flight:
    """Only so many seconds of a flight."""
    if seconds is None:
        return whole
    n = round(seconds / whole.dt)
    names = ("t", "rate", "z", "position", "speed", "glitch")
    parts = {name: getattr(whole, name)[:n] for name in names}
    reference = None if whole.reference is None else whole.reference[:n]
    jumps = tuple(at for at in whole.jumps if at <= parts["t"][-1] + AROUND)
    return replace(whole, **parts, reference=reference, jumps=jumps)


def _joined(t: np.ndarray, values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Values between samples, on straight lines; NaN in holes."""
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


def _jumps(recording: Recording) -> tuple[float, ...]:
    """When the ground speed changes faster than a vehicle can."""
    t, ground = recording.gps_t - recording.delays[0], recording.speed[:, 0]
    steep = np.abs(np.diff(ground)) > JUMP * np.diff(t)
    return tuple(float(at) for at in t[1:][steep])


def _reference(recording: Recording, edges: np.ndarray) -> np.ndarray | None:
    """The autopilot's attitude at the ticks' ends; None where the gyroscopes deny it."""
    if len(recording.attitude_t) < 2:
        return None
    angles = np.unwrap(recording.attitude, axis=0)
    found = np.stack([np.interp(edges, recording.attitude_t, a) for a in angles.T], axis=1)
    step = max(round(0.5 / float(edges[1] - edges[0])), 1)
    turned = np.diff(found[::step], axis=0)
    rates = over_ticks(recording.imu_t, recording.rate, edges[::step])
    agreeing = [
        float(np.corrcoef(a, b)[0, 1]) if a.std() and b.std() else 0.0
        for a, b in zip(turned.T, rates.T, strict=True)
    ]
    return found[1:] if np.median(agreeing) > AGREES else None
