"""Attitude and gyroscope bias, aided by Euler angles that are measured now and then.

Chauhan, Patil, Sinha and Halder 2009, corrected. The state is (q, b): a quaternion, scalar first,
from body (forward, right, down) to north, east, down, and the gyroscopes' bias in rad/s.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.extended import linearised
from filters.kalman import Estimate, matmul, predict
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
from filters.validate import check_setup


class GpsAidedNoise(NamedTuple):
    """What the filter takes.

    Attributes:
        R: variances of the measured (phi, theta, psi), rad^2, ``(3,)``.
        process: the process noise and its law's constants; seven states.
        x0: the start, ``(7,)``.
        P0: its covariance, ``(7, 7)``.
    """

    R: Array
    process: ResidualNoise
    x0: Array
    P0: Array


class GpsAidedSample(NamedTuple):
    """One tick's inputs; stacked along time for :func:`filters.run`.

    Attributes:
        rate: gyroscopes, rad/s, ``(3,)``; NaN means missing, and is taken as no turn.
        z: measured (phi, theta, psi), rad, ``(3,)``; NaN throughout where there is no measurement.
        draw: uniform numbers of the random law, ``(7,)``; None for the others.
    """

    rate: Array
    z: Array
    draw: Array | None = None


class GpsAidedState(NamedTuple):
    """Estimate, diagonal of Q ``(7,)``, and the last residuals."""

    estimate: Estimate
    Q: Array
    residuals: Residuals


class GpsAidedOutputs(NamedTuple):
    """What the filter knows after a tick.

    Attributes:
        x: the state, ``(7,)``.
        P: its covariance, ``(7, 7)``.
        angles: (phi, theta, psi), rad, ``(3,)``.
        Q: the diagonal this tick was predicted with, ``(7,)``.
        residual: K nu, ``(7,)``; 0 without a measurement.
        innovation: one angle after another, each less what the state and the angles before it
            foretell, rad, ``(3,)``; 0 without a measurement, phi and psi within half a turn.
        variance: their predicted variances, rad^2, ``(3,)``.
    """

    x: Array
    P: Array
    angles: Array
    Q: Array
    residual: Array
    innovation: Array
    variance: Array


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

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: GpsAidedNoise) -> GpsAidedState:
        """The start."""
        none = no_residuals(self.samples, len(params.x0))
        return GpsAidedState(Estimate(params.x0, params.P0), params.process.Q, none)

    def step(
        self, params: GpsAidedNoise, state: GpsAidedState, inputs: GpsAidedSample
    ) -> tuple[GpsAidedState, GpsAidedOutputs]:
        """Predict; where there is a measurement, correct and choose the next Q."""
        ahead = self._ahead(state, inputs.rate)
        angles = self._angles(ahead.x)
        H = jax.jacfwd(self._angles)(ahead.x)
        nu = wrapped(inputs.z - angles)
        found, taken = linearised(ahead, H, params.R, angles + nu, angles)
        seen = ~jnp.isnan(inputs.z).all()
        residual = found.x - ahead.x
        after = self._normalised(found, seen)
        residuals = remembered(state.residuals, residual, seen)
        Q = jnp.where(seen, self._noise(params.process, residuals, inputs.draw), state.Q)
        outputs = GpsAidedOutputs(
            after.x,
            after.P,
            self._angles(after.x),
            state.Q,
            residual,
            taken.innovation,
            taken.variance,
        )
        return GpsAidedState(after, Q, residuals), outputs

    def _ahead(self, state: GpsAidedState, rate: Array) -> Estimate:
        """(3) to (6), without a projection."""
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

    def _angles(self, x: Array) -> Array:
        return euler_angles(x[:4], homogeneous=self.euler == "homogeneous")

    def _normalised(self, found: Estimate, seen: Array) -> Estimate:
        """(9), where there was an update, and J P J' with J = diag((I - u u') / abs(q), I)."""
        q = found.x[:4]
        length = jnp.sqrt(q @ q)
        u = q / length
        P = found.P
        if self.projected:
            upper = (jnp.eye(4, dtype=q.dtype) - jnp.outer(u, u)) / length
            J = jnp.eye(7, dtype=q.dtype).at[:4, :4].set(upper)
            P = jnp.where(seen, matmul(matmul(J, P), J.T), P)
        return Estimate(jnp.where(seen, jnp.concatenate([u, found.x[4:]]), found.x), P)

    def _noise(self, noise: ResidualNoise, residuals: Residuals, draw: Array | None) -> Array:
        dt = self.dt * self.every
        if self.law == "fuzzy":
            return fuzzy_noise(residuals, noise, dt, edge=self.slope == "edge")
        if self.law == "random":
            if draw is None:
                raise ValueError("the random law needs uniform numbers: give draw with each sample")
            return random_noise(draw, noise, dt)
        return noise.Q


def euler_angles(q: Array, *, homogeneous: bool = True) -> Array:
    """(phi, theta, psi) of a quaternion from body to north, east, down, ``(3,)``.

    Args:
        q: ``(4,)``, scalar first, of any length if homogeneous.
        homogeneous: whether theta is over abs(q)^2, so that no angle changes with q's length.

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
    return difference - jnp.array([turn, 0.0, turn]) * jnp.round(difference / turn)


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
