"""Attitude and gyroscope bias, aided by Euler angles that are measured now and then.

Chauhan, Patil, Sinha and Halder 2009, corrected. The state is (q, b): a quaternion, scalar first,
from body (forward, right, down) to north, east, down, and the gyroscopes' bias in rad/s.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.declared import Channel, Param, components
from filters.extended import linearised
from filters.imu import WXYZ, XYZ
from filters.kalman import Estimate, predict
from filters.residual_noise import (
    Law,
    ResidualNoise,
    Residuals,
    fuzzy_noise,
    no_residuals,
    random_noise,
    remembered,
)
from filters.rotation import or_else
from filters.small_linalg import matmul
from filters.validate import check_setup

EULER = ("roll", "pitch", "yaw")
_STATES = (*(f"q_{axis}" for axis in WXYZ), *(f"bias_{axis}" for axis in XYZ))


class GpsAidedNoise(NamedTuple):
    """Parameters of the filter; the process noise has one number for q and one for the bias."""

    R_phi: Annotated[
        Array,
        Param(
            "rad^2",
            "variance of the measured roll",
            typical=0.01,
            low=1e-6,
            high=10.0,
            smaller="the roll follows the measurements",
            larger="gyroscopes are trusted longer",
        ),
    ]
    R_theta: Annotated[
        Array,
        Param(
            "rad^2",
            "variance of the measured pitch",
            typical=0.01,
            low=1e-6,
            high=10.0,
            smaller="the pitch follows the measurements",
            larger="gyroscopes are trusted longer",
        ),
    ]
    R_psi: Annotated[
        Array,
        Param(
            "rad^2",
            "variance of the measured yaw",
            typical=0.01,
            low=1e-6,
            high=10.0,
            smaller="the yaw follows the measurements",
            larger="gyroscopes are trusted longer",
        ),
    ]
    Q_quaternion: Annotated[
        Array,
        Param(
            "1/s",
            "density of the noise of each part of the quaternion: constant, or until a law has one",
            typical=1e-6,
            low=1e-12,
            high=1.0,
            smaller="gyroscopes are trusted more",
            larger="angles follow the measurements",
        ),
    ]
    Q_bias: Annotated[
        Array,
        Param(
            "rad^2/s^3",
            "density of the drift of the gyroscopes' bias: constant, or until a law has one",
            typical=1e-8,
            low=1e-14,
            high=1e-1,
            smaller="the bias is taken as constant",
            larger="the bias follows faster",
            sensor="gyroscope bias",
        ),
    ]
    floor_quaternion: Annotated[
        Array, Param("1/s", "least noise that a law may set for the quaternion", typical=1e-9)
    ]
    floor_bias: Annotated[
        Array, Param("rad^2/s^3", "least noise that a law may set for the bias", typical=1e-12)
    ]
    h: Annotated[Array, Param("", "fuzzy law: degree of membership, 0 to below 1", typical=0.0)]
    scale: Annotated[
        Array,
        Param("1/s, rad/s^2", "random law: rates for a draw of 1", typical=0.0, shape=(7,)),
    ]
    q0: Annotated[
        Array,
        Param("", "attitude at the start, body to north, east, down", typical=(1.0, 0.0, 0.0, 0.0)),
    ]
    b0: Annotated[
        Array, Param("rad/s", "bias of the gyroscopes at the start", typical=0.0, shape=(3,))
    ]
    P0_quaternion: Annotated[
        Array,
        Param("", "variance of each part of the quaternion at the start", typical=0.05),
    ]
    P0_bias: Annotated[
        Array, Param("rad^2/s^2", "variance of each bias at the start", typical=1e-3)
    ]

    @property
    def R(self) -> Array:
        """Variances of the measured (phi, theta, psi), ``(3,)``."""
        return jnp.stack([self.R_phi, self.R_theta, self.R_psi], axis=-1)

    @property
    def process(self) -> ResidualNoise:
        """Noise of seven states, as the laws take it."""
        floor = _by_state(self.floor_quaternion, self.floor_bias)
        return ResidualNoise(_by_state(self.Q_quaternion, self.Q_bias), floor, self.scale, self.h)


class GpsAidedSample(NamedTuple):
    """One tick's inputs; stacked along time for :func:`filters.run`.

    A missing rate (NaN) is taken as no turn; angles are NaN throughout where none is measured.
    ``draw`` are uniform numbers of the random law, ``(7,)``, None for the others.
    """

    gyr: Annotated[Array, Channel("rad/s", "angular rate about forward, right, down axes", XYZ)]
    angles: Annotated[Array, Channel("rad", "measured roll, pitch and yaw", EULER, "angle")]
    draw: Array | None = None


class GpsAidedState(NamedTuple):
    """Estimate, diagonal of Q ``(7,)``, and the last residuals."""

    estimate: Estimate
    Q: Array
    residuals: Residuals


class GpsAidedOutputs(NamedTuple):
    """The outputs of the filter after a tick; residual and innovation are 0 without a measurement.

    Innovations are one angle after another, each less what the state and the earlier angles
    predict; those of phi and psi lie within half a turn.
    """

    x: Annotated[Array, Channel("", "quaternion and bias", _STATES, "detail")]
    P: Annotated[Array, Channel("", "covariance of the state", _STATES, "detail")]
    angles: Annotated[Array, Channel("rad", "roll, pitch and yaw", EULER, "angle")]
    Q: Annotated[Array, Channel("", "diagonal that the tick was predicted with", _STATES, "detail")]
    residual: Annotated[Array, Channel("", "K nu, the correction of the state", _STATES, "detail")]
    innovation: Annotated[
        Array, Channel("rad", "measured angles less what is predicted", EULER, "detail")
    ]
    variance: Annotated[Array, Channel("rad^2", "predicted variances of these", EULER, "detail")]


@dataclass(frozen=True)
class GpsAidedKalman:
    """The extended Kalman filter (3) to (10) with a process noise by law.

    Every tick predicts; a tick with a measurement corrects, normalises q, and takes P's part along
    q away, of which homogeneous Euler angles see nothing.

    Attributes:
        dt: time between ticks, s.
        every: ticks between measurements.
        law: constant Q, fuzzy by :func:`filters.residual_noise.fuzzy_noise`, or random.
        samples: residuals in the window, an even number. They count as `every` ticks apart, also
            where measurements were missing between them.
        slope: of the fuzzy law's line: its center's, or that of the band's edge, with h.
        kinematics: half of Omega q; printed: (3) without the half, twice the rate.
        propagation: psd, (I + T A) P (I + T A)' + T Q; printed: (6), which drops T^2 A P A'.
        euler: homogeneous, blind along q; unit: asin of (2 (q0 q2 - q1 q3)) alone.
        projected: whether P loses its part along q.
    """

    dt: float
    every: int = 4
    law: Law = "constant"
    samples: int = 6
    slope: Literal["center", "edge"] = "center"
    kinematics: Literal["half", "printed"] = "half"
    propagation: Literal["psd", "printed"] = "psd"
    euler: Literal["homogeneous", "unit"] = "homogeneous"
    projected: bool = True

    params, inputs, outputs = GpsAidedNoise, GpsAidedSample, GpsAidedOutputs
    states = components("q", "", "attitude, body to north, east, down", WXYZ) | components(
        "bias", "rad/s", "bias of the gyroscopes", XYZ
    )

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: GpsAidedNoise) -> GpsAidedState:
        """The start."""
        x0 = jnp.concatenate([params.q0, params.b0])
        P0 = jnp.diag(_by_state(params.P0_quaternion, params.P0_bias))
        none = no_residuals(self.samples, x0)
        return GpsAidedState(Estimate(x0, P0), params.process.Q, none)

    def step(
        self, params: GpsAidedNoise, state: GpsAidedState, inputs: GpsAidedSample
    ) -> tuple[GpsAidedState, GpsAidedOutputs]:
        """Predict; where there is a measurement, correct and choose the next Q."""
        return self.corrected(params, state, self.ahead(state, inputs.gyr), inputs)

    def corrected(
        self,
        params: GpsAidedNoise,
        state: GpsAidedState,
        ahead: Estimate,
        inputs: GpsAidedSample,
        edge: Array | None = None,
    ) -> tuple[GpsAidedState, GpsAidedOutputs]:
        """The second half of a step, from what :meth:`ahead` predicted.

        The fuzzy law's slope takes a share ``edge`` of the band's spread; None: as ``slope`` says.
        """
        angles = self.angles(ahead.x)
        H = jax.jacfwd(self.angles)(ahead.x)
        nu = wrapped(inputs.angles - angles)
        found, taken = linearised(ahead, H, params.R, angles + nu, angles)
        seen = ~jnp.isnan(inputs.angles).all()
        residual = found.x - ahead.x
        after = self._normalised(found, seen)
        residuals = remembered(state.residuals, residual, seen)
        Q = jnp.where(seen, self._noise(params.process, residuals, inputs.draw, edge), state.Q)
        outputs = GpsAidedOutputs(
            after.x,
            after.P,
            self.angles(after.x),
            state.Q,
            residual,
            taken.innovation,
            taken.variance,
        )
        return GpsAidedState(after, Q, residuals), outputs

    def ahead(self, state: GpsAidedState, rate: Array) -> Estimate:
        """The prediction over one tick, (3) to (6), without a projection."""
        x, P = state.estimate
        half = 0.5 if self.kinematics == "half" else 1.0
        turn = half * turning(or_else(rate, x[4:]) - x[4:])
        A = jnp.zeros((7, 7), x.dtype).at[:4, :4].set(turn).at[:4, 4:].set(-half * moved_by(x[:4]))
        TQ = self.dt * jnp.diag(state.Q)
        if self.propagation == "psd":
            P = predict(state.estimate, jnp.eye(7, dtype=x.dtype) + self.dt * A, TQ).P
        else:
            AP = matmul(A, P)
            P = P + self.dt * (AP + AP.T) + TQ
        q = x[:4] + self.dt * matmul(turn, x[:4])
        return Estimate(jnp.concatenate([q / jnp.sqrt(q @ q), x[4:]]), P)

    def angles(self, x: Array) -> Array:
        """Roll, pitch and yaw of a state, rad, ``(3,)``."""
        return euler_angles(x[:4], homogeneous=self.euler == "homogeneous")

    def _normalised(self, found: Estimate, seen: Array) -> Estimate:
        """(9), after an update, and J P J' with J = diag((I - u u') / abs(q), I)."""
        q = found.x[:4]
        length = jnp.sqrt(q @ q)
        u = q / length
        P = found.P
        if self.projected:
            upper = (jnp.eye(4, dtype=q.dtype) - jnp.outer(u, u)) / length
            J = jnp.eye(7, dtype=q.dtype).at[:4, :4].set(upper)
            P = jnp.where(seen, matmul(matmul(J, P), J.T), P)
        return Estimate(jnp.where(seen, jnp.concatenate([u, found.x[4:]]), found.x), P)

    def _noise(
        self,
        noise: ResidualNoise,
        residuals: Residuals,
        draw: Array | None,
        edge: Array | None,
    ) -> Array:
        dt = self.dt * self.every
        if self.law == "fuzzy":
            whole = self.slope == "edge" if edge is None else edge
            return fuzzy_noise(residuals, noise, dt, edge=whole)
        if self.law == "random":
            if draw is None:
                raise ValueError("the random law needs uniform numbers: give draw with each sample")
            return random_noise(draw, noise, dt)
        return noise.Q


def _by_state(quaternion: Array, bias: Array) -> Array:
    """One number for q and one for the bias, ``(7,)``."""
    return jnp.stack([*4 * [quaternion], *3 * [bias]], axis=-1)


def euler_angles(q: Array, *, homogeneous: bool = True) -> Array:
    """(phi, theta, psi) of a quaternion from body to north, east, down, ``(3,)``.

    Args:
        q: ``(4,)``, scalar first, of any norm if homogeneous.
        homogeneous: whether theta is divided by abs(q)^2, so that no angle changes with q's norm.

    >>> jnp.degrees(euler_angles(jnp.array([2.0, 0.0, 0.0, 2.0]))).round().tolist()
    [0.0, 0.0, 90.0]
    """
    a, b, c, d = q
    sine = 2 * (a * c - b * d) / ((q @ q) if homogeneous else 1.0)
    phi = jnp.arctan2(2 * (a * b + c * d), a**2 - b**2 - c**2 + d**2)
    theta = jnp.arcsin(jnp.clip(sine, -1 + 1e-15, 1 - 1e-15))
    psi = jnp.arctan2(2 * (a * d + b * c), a**2 + b**2 - c**2 - d**2)
    return jnp.stack([phi, theta, psi])


def wrapped(difference: Array) -> Array:
    """Differences of (phi, theta, psi) with those of phi and psi within half a turn, ``(3,)``."""
    turn = 2 * jnp.pi
    turns = jnp.array([turn, 0.0, turn], difference.dtype)
    return difference - turns * jnp.round(difference / turn)


def turning(rate: Array) -> Array:
    """Omega of (17): twice the quaternion's derivative per quaternion, ``(4, 4)``."""
    a, b, c = rate
    zero = jnp.zeros((), rate.dtype)
    rows = [zero, -a, -b, -c, a, zero, c, -b, b, -c, zero, a, c, b, -a, zero]
    return jnp.stack(rows).reshape(4, 4)


def moved_by(q: Array) -> Array:
    """Xi with Omega(w) q = Xi(q) w, ``(4, 3)``."""
    a, b, c, d = q
    return jnp.stack([-b, -c, -d, a, -d, c, d, a, -b, -c, b, a]).reshape(4, 3)
