"""Attitude at any orientation: gyroscopes turn a quaternion, gravity corrects it, where trusted.

The two-step adaptation of Suh, Park, Kang and Ro, 2004, without Euler angles: the gyroscopes'
prediction comes first, and the accelerometers' variance grows along the body axes on which they
contradict it.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.declared import Channel, Param, components
from filters.extended import linearised
from filters.imu import ATTITUDE, DISTURBANCE, GRAVITY, LEVEL, XYZ, ImuSample, SixAxes
from filters.kalman import Estimate, predict
from filters.rotation import begun, from_rotation_vector, multiply, normalise, or_else, rotate_back
from filters.validate import check_setup


class AttitudeNoise(NamedTuple):
    """Parameters of the gravity filter: densities of white noises, and how the adaptation works.

    As far as the attitude's error shows, gyroscope, bias, accelerometer and gain share a scale that
    is free but for the start's deviations; the innovations' likelihood determines it.
    """

    gyroscope: Annotated[
        Array,
        Param(
            "rad^2/s",
            "density of the gyroscopes' white noise",
            typical=1e-6,
            low=1e-12,
            high=1e-1,
            smaller="gyroscopes are trusted more",
            larger="the attitude follows the accelerometers faster",
            sensor="gyroscope",
        ),
    ]
    bias: Annotated[
        Array,
        Param(
            "rad^2/s^3",
            "density of the drift of the gyroscopes' bias",
            typical=1e-9,
            low=1e-15,
            high=1e-3,
            smaller="the bias is taken as constant",
            larger="the bias follows faster, accelerations too",
            sensor="gyroscope bias",
        ),
    ]
    accelerometer: Annotated[
        Array,
        Param(
            "",
            "variance of the accelerometers over g^2, usual accelerations included",
            typical=1e-2,
            low=1e-8,
            high=1e4,
            smaller="the attitude follows the accelerometers faster",
            larger="gyroscopes are trusted longer",
        ),
    ]
    memory: Annotated[
        Array,
        Param(
            "s",
            "time constant with which a grown variance is forgotten",
            typical=0.5,
            low=1e-2,
            high=1e2,
            smaller="accelerometers count again sooner after a disturbance",
            larger="a disturbance is distrusted longer",
        ),
    ]
    gain: Annotated[
        Array,
        Param(
            "",
            "variance over g^2 that a lasting residual of 1 g adds",
            typical=5.0,
            low=1e-4,
            high=1e6,
            smaller="disturbances come through",
            larger="disturbed axes are left to the gyroscopes",
        ),
    ]
    delta: Annotated[Array, DISTURBANCE]
    gravity: Annotated[Array, GRAVITY]
    q0: Annotated[Array, LEVEL]
    b0: Annotated[
        Array, Param("rad/s", "bias of the gyroscopes at the start", typical=0.0, shape=(3,))
    ]
    tilt0: Annotated[Array, Param("rad", "deviation of the attitude at the start", typical=0.1)]
    bias0: Annotated[Array, Param("rad/s", "deviation of the bias at the start", typical=0.02)]


class AttitudeState(NamedTuple):
    """Attitude, gyroscope bias, covariance of both errors ``(6, 6)``, and variances r ``(3,)``."""

    q: Array
    b: Array
    P: Array
    r: Array


class AttitudeOutputs(NamedTuple):
    """The outputs of the filter after a sample; the heading comes from the gyroscopes alone."""

    att: Annotated[Array, ATTITUDE]
    b: Annotated[Array, Channel("rad/s", "bias of the gyroscopes", XYZ)]
    r: Annotated[
        Array, Channel("", "variances of the accelerometers over g^2, as taken", XYZ, "detail")
    ]
    detected: Annotated[Array, Channel("", "whether a disturbance was detected", (), "detail")]
    innovation: Annotated[
        Array, Channel("", "accelerometers over g less what is predicted", XYZ, "detail")
    ]
    variance: Annotated[Array, Channel("", "predicted variances of these", XYZ, "detail")]


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

    params, inputs, outputs = AttitudeNoise, SixAxes, AttitudeOutputs
    states = (
        components("q", "", "attitude, sensor to earth", "wxyz")
        | components("bias", "rad/s", "bias of the gyroscopes", "xyz")
        | components("r", "", "variance of the accelerometers over g^2", "xyz")
    )

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: AttitudeNoise) -> AttitudeState:
        """The start."""
        start = jnp.repeat(jnp.stack([params.tilt0, params.bias0]), 3)
        r = jnp.repeat(params.accelerometer, 3)
        return AttitudeState(params.q0, params.b0, jnp.diag(start**2), r)

    def step(
        self, params: AttitudeNoise, state: AttitudeState, inputs: SixAxes | ImuSample
    ) -> tuple[AttitudeState, AttitudeOutputs]:
        """Turn by the gyroscopes, detect, and correct by the accelerometers."""
        turn = from_rotation_vector((or_else(inputs.gyr, state.b) - state.b) * self.dt)
        q = multiply(begun(state.q, inputs.acc), turn)
        P = self._spread(params, state.P, turn)
        up = rotate_back(q, jnp.array([0.0, 0.0, 1.0], q.dtype))
        missing = ~jnp.isfinite(inputs.acc)
        # Masked before it is divided: a NaN would reach the derivative by gravity.
        a = jnp.where(missing, 0.0, inputs.acc) / params.gravity
        a = jnp.where(missing, jnp.nan, a)
        detected = jnp.abs(a @ a - 1) > params.delta
        r = self._adapted(params, state.r, a - up, detected) if self.adaptive else state.r
        # up' = up + up x error, for a small error of the body frame
        H = jnp.concatenate([skew(up), jnp.zeros((3, 3), q.dtype)], axis=1)
        found, taken = linearised(Estimate(jnp.zeros(6, q.dtype), P), H, r, a, up)
        q = normalise(multiply(q, from_rotation_vector(found.x[:3])))
        state = AttitudeState(q, state.b + found.x[3:], found.P, r)
        return state, AttitudeOutputs(
            state.q, state.b, r, detected, taken.innovation, taken.variance
        )

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
