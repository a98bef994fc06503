"""Simulated motion of an inertial unit, and its sensors' measurements.

Axes are forward, left, up; attitudes turn sensor into earth coordinates with earth z up, so the
accelerometers show +g along z at rest. Angles are those of aeronautics: roll phi, pitch theta, yaw
psi of forward, right, down axes in north, east, down.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from filters.imu import ImuSample
from filters.rotation import rotate_back
from tuner.limits import check_amount

GRAVITY = 9.80665
"""m/s^2."""
_FLIP = np.array([1.0, -1.0, -1.0])  # between axes forward, left, up and forward, right, down


class Motion(NamedTuple):
    """A motion that is known exactly, N samples.

    Attributes:
        dt: sample time, s.
        angles: (phi, theta, psi), rad, ``(N, 3)``.
        q: attitude, sensor to earth, ``(N, 4)``.
        rate: angular rate in sensor axes, rad/s, ``(N, 3)``.
        force: specific force in sensor axes, m/s^2, ``(N, 3)``: gravity's reaction and
            acceleration.
        disturbed: whether there is external acceleration, ``(N,)`` of bool.
    """

    dt: float
    angles: np.ndarray
    q: np.ndarray
    rate: np.ndarray
    force: np.ndarray
    disturbed: np.ndarray


@dataclass(frozen=True)
class Swing:
    """Angles as sums of sines with random frequencies and phases.

    Attributes:
        size: standard deviations of (phi, theta, psi), rad; phi and theta well below pi/2.
        slowest, fastest: frequencies, Hz.
        count: sines per angle.
    """

    size: tuple[float, float, float]
    slowest: float = 0.02
    fastest: float = 0.4
    count: int = 6


@dataclass(frozen=True)
class Bursts:
    """External accelerations that come and go: whole sines, so that no speed is left.

    Attributes:
        count: their number.
        size: largest amplitude, m/s^2; each burst has between a fifth and all of it.
        seconds: duration of each.
        axes: in which earth axes they point; weights of east or north, north or west, up.
    """

    count: int
    size: float
    seconds: float = 2.0
    axes: tuple[float, float, float] = (1.0, 1.0, 0.5)


@dataclass(frozen=True)
class Sensor:
    """Three axes with errors.

    Attributes:
        noise: standard deviation of white noise in a sample.
        bias: constant part, ``(3,)``.
        walk: standard deviation that the bias's random walk reaches after one second.
        turn_on: standard deviation of a further constant part, which each seed draws anew.
    """

    noise: float = 0.0
    bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    walk: float = 0.0
    turn_on: float = 0.0

    def measure(self, truth: np.ndarray, dt: float, seed: int) -> np.ndarray:
        """The measurements of a truth ``(N, 3)``."""
        draw = np.random.default_rng(seed)
        walk = self.walk * np.sqrt(dt) * draw.normal(size=truth.shape).cumsum(axis=0)
        noise = self.noise * draw.normal(size=truth.shape)
        # Drawn last, so that noise and walk of a seed are the same with and without it.
        start = self.turn_on * draw.normal(size=truth.shape[1:])
        return np.asarray(truth + np.array(self.bias) + start + walk + noise)


def simulate(
    *, seconds: float, dt: float, seed: int, swing: Swing, bursts: Bursts | None = None
) -> Motion:
    """A random motion, the same for the same seed.

    Args:
        seconds: duration.
        dt: sample time, s.
        seed: seed of the random numbers.
        swing: motion of the angles; it starts from rest at zero within the first tenth.
        bursts: external accelerations, none if left out.

    Raises:
        ValueError: for times that are not positive, or angles that come near the vertical.

    >>> still = simulate(seconds=1.0, dt=0.1, seed=0, swing=Swing((0.0, 0.0, 0.0)))
    >>> still.force[0].round(5).tolist()
    [0.0, 0.0, 9.80665]
    """
    if not (0 < dt < np.inf and dt <= seconds < np.inf):
        raise ValueError(f"{seconds:g} s in steps of {dt:g} s is not a motion; give positive times")
    check_amount(f"{seconds / dt:.4g} samples", 512 * seconds / dt, "take a shorter time")
    draw = np.random.default_rng(seed)
    time = dt * np.arange(round(seconds / dt))
    angles, speed = _angles(swing, time, draw)
    if not np.isfinite(angles).all():
        raise ValueError(
            f"the swing {swing} is not a motion; give finite numbers, frequencies above 0"
        )
    if np.abs(angles[:, 1]).max() > np.radians(85):
        raise ValueError(
            f"the pitch reaches {np.degrees(np.abs(angles[:, 1]).max()):.0f} deg, where roll and "
            "yaw are one; give a smaller swing"
        )
    q = _attitude(angles)
    pushes = np.zeros((len(time), 3)) if bursts is None else _pushes(bursts, time, draw)
    earth = pushes + np.array([0.0, 0.0, GRAVITY])
    force = np.array(_to_sensor(jnp.asarray(q), jnp.asarray(earth)))
    return Motion(dt, angles, q, _rates(angles, speed), force, np.abs(pushes).max(axis=1) > 0)


def measure(motion: Motion, *, gyroscope: Sensor, accelerometer: Sensor, seed: int) -> ImuSample:
    """The measurements of an inertial unit in a motion; equal seeds give equal noise."""
    rate = gyroscope.measure(motion.rate, motion.dt, seed)
    # Another stream for the other sensor: their noises must not be one.
    force = accelerometer.measure(motion.force, motion.dt, seed + 2**31)
    return ImuSample(jnp.asarray(force), jnp.asarray(rate))


def even_normals(count: int, size: int, seed: int) -> np.ndarray:
    """Standard normal numbers for runs that together show the distribution, ``(count, size)``.

    A Latin hypercube (McKay, Beckman and Conover, Technometrics 21(2), 1979), then shifted and
    turned until the mean is 0 and the covariance 1, so that over the runs the mean square of any
    linear function of the numbers is exact. That needs more runs than numbers in each; fewer
    stay as the hypercube has them.

    >>> drawn = even_normals(20, 3, seed=0)
    >>> np.abs(drawn.T @ drawn / 20 - np.eye(3)).max() < 1e-12
    np.True_
    """
    from scipy.special import ndtri
    from scipy.stats.qmc import LatinHypercube

    drawn = ndtri(LatinHypercube(size, rng=np.random.default_rng(seed)).random(count))
    if count <= size:
        return np.asarray(drawn)
    drawn = drawn - drawn.mean(axis=0)
    return np.asarray(np.linalg.solve(np.linalg.cholesky(drawn.T @ drawn / count), drawn.T).T)


def _angles(swing: Swing, time: np.ndarray, draw: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Angles and their rates, ``(N, 3)`` each."""
    count = swing.count
    octaves = np.log(swing.fastest / swing.slowest) * draw.uniform(size=(3, count))
    omega = 2 * np.pi * swing.slowest * np.exp(octaves)
    phase = draw.uniform(0, 2 * np.pi, (3, count))
    size = np.array(swing.size)[:, None] * np.sqrt(2 / count)
    turn = time[:, None, None] * omega + phase
    value, slope = (size * np.sin(turn)).sum(axis=2), (size * omega * np.cos(turn)).sum(axis=2)
    # A smooth start: s = x^3 (10 - 15 x + 6 x^2) has no speed and no acceleration at its ends.
    length = 0.1 * time[-1] or 1.0
    x = np.clip(time / length, 0.0, 1.0)[:, None]
    rise, growth = x**3 * (10 - 15 * x + 6 * x**2), 30 * x**2 * (1 - x) ** 2 / length
    return rise * value, rise * slope + growth * value


def _rates(angles: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Body rates of Euler angles that move, in axes forward, left, up."""
    (phi, theta, _), (dphi, dtheta, dpsi) = angles.T, speed.T
    p = dphi - dpsi * np.sin(theta)
    q = dtheta * np.cos(phi) + dpsi * np.sin(phi) * np.cos(theta)
    r = -dtheta * np.sin(phi) + dpsi * np.cos(phi) * np.cos(theta)
    return np.asarray(_FLIP * np.stack([p, q, r], axis=1))


def _attitude(angles: np.ndarray) -> np.ndarray:
    """Quaternions of Rz(psi) Ry(theta) Rx(phi), turned from down to up."""
    half = angles / 2
    (c1, c2, c3), (s1, s2, s3) = np.cos(half).T, np.sin(half).T
    w = c1 * c2 * c3 + s1 * s2 * s3
    x = s1 * c2 * c3 - c1 * s2 * s3
    y = c1 * s2 * c3 + s1 * c2 * s3
    z = c1 * c2 * s3 - s1 * s2 * c3
    return np.stack([w, x, -y, -z], axis=1)


def _pushes(bursts: Bursts, time: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """External acceleration in earth axes, ``(N, 3)``."""
    found = np.zeros((len(time), 3))
    for start in draw.uniform(time[0], max(time[-1] - bursts.seconds, time[0]), bursts.count):
        direction = np.array(bursts.axes) * draw.normal(size=3)
        direction /= np.linalg.norm(direction)
        size = bursts.size * draw.uniform(0.2, 1.0)
        x = (time - start) / bursts.seconds
        within = (x >= 0) & (x < 1)
        found += np.where(within, size * np.sin(2 * np.pi * x), 0.0)[:, None] * direction
    return found


_to_sensor = jax.jit(jax.vmap(rotate_back))
