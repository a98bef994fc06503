"""Filters with records long enough to try their C on."""

import jax.numpy as jnp
import numpy as np

from filters import (
    AttitudeKalman,
    AttitudeNoise,
    BoundedMotionKalman,
    BoundedMotionNoise,
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    GpsAidedKalman,
    GpsAidedNoise,
    GpsAidedSample,
    GyroscopeFilter,
    ImuSample,
    KownackiNoise,
    LinearKalman,
    LinearModel,
    Sample,
    Transition,
    blocks,
)

N = 400
_DRAW = np.random.default_rng(18)


def turned(p, x, u):
    """A coordinated turn: place (2), speed, heading, rate of turn, one Euler step of 0.05 s."""
    px, py, v, h, w = x
    return jnp.stack([px + 0.05 * v * jnp.cos(h), py + 0.05 * v * jnp.sin(h), v, h + 0.05 * w, w])


def turned_noise(p, x, u):
    return 0.05 * jnp.diag(jnp.stack([0 * p[0], 0 * p[0], p[0], 0 * p[0], p[1]]))


def turned_seen(p, x, u):
    return jnp.stack([x[0], x[1], x[4]])


def walk(m, holes=0.0):
    z = np.cumsum(0.05 * _DRAW.normal(size=(N, m)), 0) + 0.2 * _DRAW.normal(size=(N, m))
    z[_DRAW.random(N) < holes] = np.nan
    return z


def imu():
    rest = (np.arange(N) // 60 % 2)[:, None]
    force = np.array([0.2, -0.3, 9.7]) + (0.02 + rest) * _DRAW.normal(size=(N, 3))
    return ImuSample(force, 0.002 * _DRAW.normal(size=(N, 3)) + 0.3 * rest * walk(3))


def two_axes():
    """Position and speed on two axes."""
    F, G = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.005], [0.1]])
    k = np.kron
    move = Transition(k(np.eye(2), F), k(np.eye(2), G), np.eye(2))
    H = k(np.eye(2), np.array([[1.0, 0.0]]))
    return LinearModel(move, H, np.full(2, 0.04), np.eye(4), np.zeros(4))


def numbers(*values):
    return tuple(map(jnp.asarray, values))


_TURNED = jnp.array([0.9, 0.3, -0.3, 0.1])
FILTERS = {
    "gyroscope": (GyroscopeFilter(0.01), KownackiNoise.of(0.3, 2.0), walk(1)[:, 0]),
    "linear4": (LinearKalman(), two_axes(), Sample(walk(2))),
    "extended5": (
        ExtendedKalman(turned, turned_noise, turned_seen),
        ExtendedModel(
            jnp.array([0.5, 0.2]),
            jnp.array([1.0, 1.0, 1e-3]),
            jnp.array([0, 0, 5.0, 0, 0]),
            jnp.eye(5),
        ),
        ExtendedSample(walk(3)),
    ),
    "gravity": (
        AttitudeKalman(0.01),
        AttitudeNoise(
            *numbers(2.5e-4, 1e-5, 1e-2, 0.5, 2.0, 0.05, 9.81),
            _TURNED,
            jnp.zeros(3),
            *numbers(0.2, 0.1),
        ),
        imu(),
    ),
    "euler7": (
        GpsAidedKalman(0.1),
        GpsAidedNoise(
            *numbers(1e-2, 1e-2, 1e-2, 1e-3, 1e-5, 0.0, 0.0, 0.0),
            jnp.ones(7),
            _TURNED,
            jnp.zeros(3),
            *numbers(0.01, 0.01),
        ),
        GpsAidedSample(0.3 * _DRAW.normal(size=(N, 3)), 0.1 * walk(3)),
    ),
    "room21": (
        BoundedMotionKalman(0.01),
        BoundedMotionNoise(
            *numbers(0.3, 0.2, 0.05, 1e-3, 5e-3, 1e-4, 3e-3, 0.01, 0.2, 0.0, 9.81), _TURNED
        ),
        blocks(imu(), 5),
    ),
}
"""Each with parameters and a record."""
KEPT = {"linear4": ("x",), "extended5": ("x",)}
"""Outputs of filters that declare no details."""
