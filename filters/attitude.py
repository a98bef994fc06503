"""Attitude at any orientation: gyroscopes turn a quaternion, gravity corrects it, where trusted.

The two-step adaptation of Suh, Park, Kang and Ro, 2004, without Euler angles: the gyroscopes'
prediction comes first, and the accelerometers' variance grows along the body axes on which they
contradict it.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.extended import linearised
from filters.kalman import Estimate, predict
from filters.rotation import begun, from_rotation_vector, multiply, normalise, or_else, rotate_back
from filters.validate import check_setup


class ImuSample(NamedTuple):
    """One sample of an inertial unit; stacked along time for :func:`filters.run`.

    Attributes:
        acceleration: specific force, m/s^2, ``(3,)``; +g along z where z points up at rest. NaN
            means missing.
        rate: angular rate, rad/s, ``(3,)``; NaN means missing, and is taken as no turn.
        field: magnetic field in any unit, ``(3,)``, or None; NaN means missing.
    """

    acceleration: Array
    rate: Array
    field: Array | None = None


class AttitudeNoise(NamedTuple):
    """What the gravity filter takes.

    Attributes:
        gyroscope: density of the gyroscopes' white noise, rad^2/s.
        bias: density of the drift of their bias, rad^2/s^3.
        accelerometer: variance of the accelerometers in rest over g^2, ``()``.
        memory: time constant with which their variance is forgotten, s.
        gain: variance over g^2 that a lasting residual of 1 g adds.
        delta: by how much abs(a)^2 / g^2 may differ from 1 before a disturbance is detected.
        gravity: m/s^2.
        q0: attitude at the start, sensor to earth, ``(4,)``; zeros: level by the first sample.
        b0: bias at the start, rad/s, ``(3,)``.
        tilt0: its deviation, rad.
        bias0: the bias's deviation at the start, rad/s.
    """

    gyroscope: Array
    bias: Array
    accelerometer: Array
    memory: Array
    gain: Array
    delta: Array
    gravity: Array
    q0: Array
    b0: Array
    tilt0: Array
    bias0: Array


class AttitudeState(NamedTuple):
    """Attitude, gyroscope bias, covariance of both errors ``(6, 6)``, and variances r ``(3,)``."""

    q: Array
    b: Array
    P: Array
    r: Array


class AttitudeOutputs(NamedTuple):
    """What the filter knows after a sample.

    Attributes:
        q: attitude, sensor to earth, ``(4,)``; the heading is the gyroscopes' alone.
        b: bias of the gyroscopes, rad/s, ``(3,)``.
        r: variances over g^2 that the accelerometers were taken with, ``(3,)``.
        detected: whether a disturbance was, ``()`` of bool.
    """

    q: Array
    b: Array
    r: Array
    detected: Array


@dataclass(frozen=True)
class AttitudeKalman:
    """An error-state Kalman filter for attitude and gyroscope bias from six axes.

    Source: Markley, J. Guidance, Control and Dynamics 26(2), 2003 (the error state, in the body
    frame); Suh et al. 2004, (7), (9), (10) with their memory as a time constant.

    Attributes:
        dt: sample time, s.
        adaptive: whether r follows the residual; else it stays.
    """

    dt: float
    adaptive: bool = True

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: AttitudeNoise) -> AttitudeState:
        """The start."""
        start = jnp.repeat(jnp.stack([params.tilt0, params.bias0]), 3)
        r = jnp.repeat(params.accelerometer, 3)
        return AttitudeState(params.q0, params.b0, jnp.diag(start**2), r)

    def step(
        self, params: AttitudeNoise, state: AttitudeState, inputs: ImuSample
    ) -> tuple[AttitudeState, AttitudeOutputs]:
        """Turn by the gyroscopes, detect, and correct by the accelerometers."""
        turn = from_rotation_vector((or_else(inputs.rate, state.b) - state.b) * self.dt)
        q = multiply(begun(state.q, inputs.acceleration), turn)
        P = self._spread(params, state.P, turn)
        up = rotate_back(q, jnp.array([0.0, 0.0, 1.0], q.dtype))
        missing = ~jnp.isfinite(inputs.acceleration)
        # Masked before it is divided: a NaN would reach the derivative by gravity.
        a = jnp.where(missing, 0.0, inputs.acceleration) / params.gravity
        a = jnp.where(missing, jnp.nan, a)
        detected = jnp.abs(a @ a - 1) > params.delta
        r = self._adapted(params, state.r, a - up, detected) if self.adaptive else state.r
        # up' = up + up x error, for a small error of the body frame
        H = jnp.concatenate([skew(up), jnp.zeros((3, 3), q.dtype)], axis=1)
        found, _ = linearised(Estimate(jnp.zeros(6, q.dtype), P), H, r, a, up)
        q = normalise(multiply(q, from_rotation_vector(found.x[:3])))
        state = AttitudeState(q, state.b + found.x[3:], found.P, r)
        return state, AttitudeOutputs(state.q, state.b, r, detected)

    def _spread(self, params: AttitudeNoise, P: Array, turn: Array) -> Array:
        one = jnp.eye(3, dtype=P.dtype)
        axes = [rotate_back(turn, axis) for axis in one]
        upper = jnp.concatenate([jnp.stack(axes, axis=1), -self.dt * one], axis=1)
        F = jnp.concatenate([upper, jnp.concatenate([jnp.zeros_like(one), one], axis=1)])
        noise = jnp.repeat(jnp.stack([params.gyroscope, params.bias]), 3)
        return predict(Estimate(noise, P), F, jnp.diag(noise * self.dt)).P

    def _adapted(self, params: AttitudeNoise, r: Array, e: Array, detected: Array) -> Array:
        """(9) and (10), their convex form."""
        keep = jnp.exp(-self.dt / params.memory)
        size = jnp.where(jnp.isnan(e), 0.0, jnp.abs(e))
        grown = jnp.maximum(keep * r + (1 - keep) * params.gain * size, params.accelerometer)
        return jnp.where(detected, grown, keep * r + (1 - keep) * params.accelerometer)


def skew(v: Array) -> Array:
    """The matrix of v x, ``(3, 3)``.

    >>> skew(jnp.array([1.0, 2.0, 3.0])).tolist()
    [[0.0, -3.0, 2.0], [3.0, 0.0, -1.0], [-2.0, 1.0, 0.0]]
    """
    zero = jnp.zeros((), v.dtype)
    entries = [zero, -v[2], v[1], v[2], zero, -v[0], -v[1], v[0], zero]
    return jnp.stack(entries).reshape(3, 3)
