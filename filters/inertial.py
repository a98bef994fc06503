"""Kownacki's accelerometer and gyroscope filters (Digital Signal Processing, 2010).

Both are the Kalman filter (7) on the state models (8) and (9), with Phi = [1 T; 0 1],
G = T I and a scalar Q, so that Q T^2 I enters per sample. They are written out, for they
run inside a tuning loop: the covariance is three numbers and their determinant, and its update
subtracts nothing. What (1 - K) P11 and P22 - K P12 lose where P0 has rank one is up to 3e-4 of the
output at R = 1e-12, and most of it in single precision.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike


class Noise(NamedTuple):
    """What is tuned.

    Attributes:
        R: variance of the measurement noise, unit of z squared, ``()``, positive.
        Q: variance of the process noise w per sample, ``()``, not negative; it enters as Q T^2.
        P0: covariance of the start, ``(2, 2)``; the paper's is all ones, of rank one.
    """

    R: ArrayLike
    Q: ArrayLike
    P0: ArrayLike

    @classmethod
    def of(cls, R: ArrayLike, Q: ArrayLike) -> "Noise":
        """R and Q with the paper's P0, a matrix of ones."""
        return cls(R, Q, jnp.ones((2, 2)))


class LevelState(NamedTuple):
    """Accelerometer: the acceleration ``a`` and the variance ``p`` of its error."""

    a: Array
    p: Array


class RateState(NamedTuple):
    """Gyroscope: angular rate, angular acceleration, and P11, P12, P22, det P of their errors."""

    omega: Array
    epsilon: Array
    p11: Array
    p12: Array
    p22: Array
    det: Array


@dataclass(frozen=True)
class AccelerometerFilter:
    """Model (8), a constant acceleration: measured and put out is a, in the unit of z.

    The velocity of (8) is driven by a and never feeds back, so it cannot be observed and its
    variance only grows; a alone is exactly the scalar filter that is run here.

    Attributes:
        dt: sample time T in s.
        shape: shape of one sample, ``()``; ``(s,)`` where s signals pass through the same gains.
    """

    dt: float
    shape: tuple[int, ...] = ()

    def init(self, params: Noise) -> LevelState:
        """At zero, with the variance P0[1, 1] of a."""
        P0 = jnp.asarray(params.P0)
        return LevelState(jnp.zeros(self.shape, P0.dtype), P0[1, 1])

    def step(self, params: Noise, state: LevelState, inputs: Array) -> tuple[LevelState, Array]:
        """Take one sample; NaN is a missing one."""
        missing = jnp.any(jnp.isnan(inputs))
        p = state.p + params.Q * self.dt**2
        gain = p / (p + params.R)
        a = state.a + gain * jnp.where(missing, 0.0, inputs - state.a)
        return LevelState(a, jnp.where(missing, p, params.R * gain)), a


@dataclass(frozen=True)
class GyroscopeFilter:
    """Model (9), a uniformly varying rate: measured and put out is omega, in the unit of z.

    With the determinant D of the covariance, a measurement takes P22 to (R P22 + D) / S and D to
    R D / S; the transition keeps D, and the noise adds q (P11 + P22) + q^2 to it.

    Attributes:
        dt: sample time T in s.
        shape: shape of one sample, ``()``; ``(s,)`` where s signals pass through the same gains.
    """

    dt: float
    shape: tuple[int, ...] = ()

    def init(self, params: Noise) -> RateState:
        """At zero, with the covariance P0."""
        P0 = jnp.asarray(params.P0)
        still = jnp.zeros(self.shape, P0.dtype)
        det = P0[0, 0] * P0[1, 1] - P0[0, 1] ** 2
        return RateState(still, still, P0[0, 0], P0[0, 1], P0[1, 1], det)

    def step(self, params: Noise, state: RateState, inputs: Array) -> tuple[RateState, Array]:
        """Take one sample; NaN is a missing one."""
        T = self.dt
        missing = jnp.any(jnp.isnan(inputs))
        q = params.Q * T**2
        p11 = state.p11 + T * (2 * state.p12 + T * state.p22)
        p12 = state.p12 + T * state.p22
        det = state.det + q * (p11 + state.p22) + q**2
        p11, p22 = p11 + q, state.p22 + q
        over_s = 1 / (p11 + params.R)
        k1, k2, shrink = p11 * over_s, p12 * over_s, params.R * over_s
        omega = state.omega + T * state.epsilon
        y = jnp.where(missing, 0.0, inputs - omega)
        omega, epsilon = omega + k1 * y, state.epsilon + k2 * y
        p22 = jnp.where(missing, p22, shrink * p22 + det * over_s)
        shrink = jnp.where(missing, 1.0, shrink)
        p11, p12, det = shrink * p11, shrink * p12, shrink * det
        return RateState(omega, epsilon, p11, p12, p22, det), omega


class Gains(NamedTuple):
    """Gains that stay as they are.

    Attributes:
        K1: gain on the measured quantity, 1.
        K2: gain on its derivative, 1/s; 0 for a filter without one.
    """

    K1: ArrayLike
    K2: ArrayLike


@dataclass(frozen=True)
class FixedGainFilter:
    """What either filter becomes once P0 is forgotten: two numbers instead of a covariance.

    The form for a small machine: no division, and single precision does it no harm.

    Attributes:
        dt: sample time T in s.
        shape: shape of one sample, ``()``; ``(s,)`` where s signals pass through the same gains.
    """

    dt: float
    shape: tuple[int, ...] = ()

    def init(self, params: Gains) -> tuple[Array, Array]:
        """At zero: the measured quantity and its derivative."""
        still = jnp.zeros(self.shape, jnp.asarray(params.K1).dtype)
        return still, still

    def step(
        self, params: Gains, state: tuple[Array, Array], inputs: Array
    ) -> tuple[tuple[Array, Array], Array]:
        """Take one sample; NaN is a missing one."""
        level, slope = state
        level = level + self.dt * slope
        y = jnp.where(jnp.any(jnp.isnan(inputs)), 0.0, inputs - level)
        level = level + params.K1 * y
        return (level, slope + params.K2 * y), level


class SteadyState(NamedTuple):
    """What a filter becomes once P0 is forgotten.

    Attributes:
        gains: the gains of the :class:`FixedGainFilter` that it becomes.
        bandwidth_hz: frequency at which the response has fallen by 3 dB.
    """

    gains: Gains
    bandwidth_hz: Array


def accelerometer_steady(q_over_r: ArrayLike, dt: float) -> SteadyState:
    """The accelerometer filter's steady gain, in closed form.

    The scalar Riccati equation with rho = (Q/R) T^2 gives K = u sqrt(rho),
    u = 2 / (sqrt(rho) + sqrt(rho + 4)), a form without cancellation. The response falls by
    3 dB where sin(pi f T) = T sqrt(Q/R) / 2; above rho = 4 it never does, and the bandwidth
    is given as infinite.

    >>> f"{float(accelerometer_steady(22.9537, 1e-4).gains.K1):.5e}"
    '4.78985e-04'
    """
    rho = jnp.asarray(q_over_r, dtype=float) * dt**2
    root = jnp.sqrt(rho)
    K = 2 * root / (root + jnp.sqrt(rho + 4))
    bandwidth = jnp.where(rho <= 4, jnp.arcsin(jnp.minimum(root / 2, 1.0)) / (jnp.pi * dt), jnp.inf)
    return SteadyState(Gains(K, jnp.zeros_like(K)), bandwidth)


def gyroscope_steady(q_over_r: ArrayLike, dt: float) -> SteadyState:
    """The gyroscope filter's steady gains: the exact solution of its Riccati equation.

    With rho = (Q/R) T^2: y = (T sqrt(rho) + sqrt(T^2 rho + 16 + 4 rho)) / 2,
    D = sqrt(rho + T sqrt(rho) y), u = 2 / (y + D), K1 = u D, K2 = u sqrt(rho). As T -> 0,
    K1/T -> sqrt(r + 2 sqrt(r)) and K2/T -> sqrt(r) with r = Q/R.

    >>> f"{float(gyroscope_steady(1027.47, 1e-4).gains.K1):.5e}"
    '3.29845e-03'
    """
    T = dt
    rho = jnp.asarray(q_over_r, dtype=float) * T**2
    root = jnp.sqrt(rho)
    y = (T * root + jnp.sqrt(T**2 * rho + 16 + 4 * rho)) / 2
    D = jnp.sqrt(rho + T * root * y)
    u = 2 / (y + D)
    K1, K2 = u * D, u * root
    return SteadyState(Gains(K1, K2), _gyroscope_bandwidth(K1, K2, T))


def _gyroscope_bandwidth(K1: Array, K2: Array, T: float) -> Array:
    """The -3 dB frequency of H(z) = z (K1 z - K1 + T K2) / (z^2 - (2 - K1 - T K2) z + 1 - K1).

    With c = cos(2 pi f T) and s = 2 (1 - c), |numerator|^2 = (T K2)^2 + K1 (K1 - T K2) s and
    |denominator|^2 = (T K2)^2 + (K1^2 - T K2 (2 - K1)) s + (1 - K1) s^2. Setting the ratio to 1/2
    leaves a quadratic in s; its positive root is the only crossing, as H(1) = 1.
    """
    k = T * K2
    square = 1 - K1
    linear = K1**2 - k * (2 - K1) - 2 * K1 * (K1 - k)
    constant = -(k**2)
    s = (-linear + jnp.sqrt(linear**2 - 4 * square * constant)) / (2 * square)
    inside = s <= 4
    half_angle = jnp.arcsin(jnp.sqrt(jnp.where(inside, s, 4.0)) / 2)
    return jnp.where(inside, half_angle / (jnp.pi * T), jnp.inf)
