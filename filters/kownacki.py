"""Kownacki's accelerometer and gyroscope filters (Digital Signal Processing, 2010).

Both are the Kalman filter (7) on the state models (8) and (9), with Phi = [1 T; 0 1],
G = T I and a scalar Q, so that Q T^2 I enters per sample. They are written out, for they run
inside a tuning loop. The covariance is carried over R, so that after a measurement its first
column is the gain: p11 -> p11 / (p11 + 1) = K1. Only Q/R and P0/R are left in the recursion.
Beside its three numbers runs their determinant, and nothing is ever subtracted: where P0 has rank
one, P22 - K2 P12 loses up to 3e-4 of the step at R = 1e-12, and 0.2 of it in single precision.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike

from filters.declared import Channel, Param
from filters.validate import check_setup

MEASURED = {"z": Channel("unit", "measured quantity")}
FILTERED = {"z": Channel("unit", "filtered quantity")}


class KownackiNoise(NamedTuple):
    """Parameters to tune; only Q/R and P0/R matter, and P0 not for long."""

    R: Annotated[
        ArrayLike,
        Param(
            "unit^2",
            "variance of the measurement noise",
            typical=1e-3,
            low=1e-12,
            high=1e3,
            smaller="the output follows the measurements",
            larger="the output is smoother and lags",
        ),
    ]
    Q: Annotated[
        ArrayLike,
        Param(
            "unit^2/s^2",
            "variance of the process noise a sample; it enters as Q T^2",
            typical=1.0,
            low=1e-9,
            high=1e9,
            smaller="the output is smoother and lags",
            larger="the output follows the measurements",
            per_sample=True,
        ),
    ]
    P0: Annotated[
        ArrayLike,
        Param(
            "unit^2",
            "covariance of the start; the paper's is all ones, of rank one",
            typical=1.0,
            shape=(2, 2),
        ),
    ]

    @classmethod
    def of(cls, R: ArrayLike, Q: ArrayLike) -> "KownackiNoise":
        """R and Q with the paper's P0, a matrix of ones."""
        return cls(R, Q, jnp.ones((2, 2)))


class LevelState(NamedTuple):
    """Accelerometer: the acceleration ``a``, and the variance of its error over R."""

    a: Array
    p: Array


class RateState(NamedTuple):
    """Gyroscope: rate, its derivative, and P11, P12, P22 over R and their determinant."""

    omega: Array
    epsilon: Array
    p11: Array
    p12: Array
    p22: Array
    det: Array


_DERIVED = {
    "K1": Param("1", "steady gain on the measured quantity", 0.1),
    "K2": Param("1/s", "steady gain on its derivative", 0.1),
    "bandwidth": Param("Hz", "where the response has fallen by 3 dB", 1.0),
}
"""Numbers that follow from R and Q; a filter that hardly smooths has no bandwidth."""


@dataclass(frozen=True)
class AccelerometerFilter:
    """Model (8), a constant acceleration: measured and output is a, in the unit of z.

    The velocity of (8) is driven by a and never feeds back, so it cannot be observed and its
    variance only grows; a alone is exactly the scalar filter that is run here.

    Attributes:
        dt: sample time T in s.
        shape: shape of one sample, ``()``; ``(s,)`` where s signals pass through the same gains.
    """

    dt: float
    shape: tuple[int, ...] = ()

    derived = _DERIVED
    params, inputs, outputs = KownackiNoise, MEASURED, FILTERED
    states = {"a": Channel("unit", "measured quantity")}  # noqa: RUF012

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: KownackiNoise) -> LevelState:
        """At zero, with the variance P0[1, 1] of a."""
        p = jnp.asarray(params.P0)[1, 1] / params.R
        return LevelState(jnp.zeros(self.shape, p.dtype), p)

    def step(
        self, params: KownackiNoise, state: LevelState, inputs: Array
    ) -> tuple[LevelState, Array]:
        """Take one sample; NaN is a missing one."""
        missing = jnp.any(jnp.isnan(inputs))
        p = state.p + params.Q * self.dt**2 / params.R
        p = jnp.where(missing, p, p / (p + 1))
        a = state.a + p * jnp.where(missing, 0.0, inputs - state.a)
        return LevelState(a, p), a

    def steady(self, params: KownackiNoise) -> "tuple[FixedGainFilter, FixedGains]":
        """The filter that it becomes once P0 is forgotten, and that filter's parameters."""
        gains, _ = accelerometer_steady(jnp.asarray(params.Q) / params.R, self.dt)
        return FixedGainFilter(self.dt, self.shape), gains

    def derive(self, params: KownackiNoise) -> dict[str, Array]:
        """Steady gains and bandwidth."""
        return _derived(accelerometer_steady(jnp.asarray(params.Q) / params.R, self.dt))


@dataclass(frozen=True)
class GyroscopeFilter:
    """Model (9), a uniformly varying rate: measured and output is omega, in the unit of z.

    With the determinant D of the covariance over R, a measurement takes P22 to (P22 + D) / S and
    D to D / S, S = P11 + 1; the transition keeps D, and the noise adds q (P11 + P22) + q^2 to it.

    Attributes:
        dt: sample time T in s.
        shape: shape of one sample, ``()``; ``(s,)`` where s signals pass through the same gains.
    """

    dt: float
    shape: tuple[int, ...] = ()

    derived = _DERIVED
    params, inputs, outputs = KownackiNoise, MEASURED, FILTERED
    states = {  # noqa: RUF012
        "omega": Channel("unit", "measured quantity"),
        "epsilon": Channel("unit/s", "its derivative"),
    }

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: KownackiNoise) -> RateState:
        """At zero, with the covariance P0."""
        P = jnp.asarray(params.P0) / params.R
        still = jnp.zeros(self.shape, P.dtype)
        p11, p12, p22 = P[0, 0], P[0, 1], P[1, 1]
        det = (p11 - p12) * p22 + p12 * (p22 - p12)  # exactly 0 where all are equal
        return RateState(still, still, p11, p12, p22, det)

    def step(
        self, params: KownackiNoise, state: RateState, inputs: Array
    ) -> tuple[RateState, Array]:
        """Take one sample; NaN is a missing one."""
        T = self.dt
        missing = jnp.any(jnp.isnan(inputs))
        q = params.Q * T**2 / params.R
        p11 = state.p11 + T * (2 * state.p12 + T * state.p22)
        p12 = state.p12 + T * state.p22
        det = state.det + q * (p11 + state.p22 + q)
        p11, p22 = p11 + q, state.p22 + q
        shrink = jnp.where(missing, 1.0, 1 / (p11 + 1))
        p22 = jnp.where(missing, p22, (p22 + det) * shrink)
        p11, p12, det = p11 * shrink, p12 * shrink, det * shrink
        omega = state.omega + T * state.epsilon
        y = jnp.where(missing, 0.0, inputs - omega)
        omega, epsilon = omega + p11 * y, state.epsilon + p12 * y
        return RateState(omega, epsilon, p11, p12, p22, det), omega

    def steady(self, params: KownackiNoise) -> "tuple[FixedGainFilter, FixedGains]":
        """The filter that it becomes once P0 is forgotten, and that filter's parameters."""
        gains, _ = gyroscope_steady(jnp.asarray(params.Q) / params.R, self.dt)
        return FixedGainFilter(self.dt, self.shape), gains

    def derive(self, params: KownackiNoise) -> dict[str, Array]:
        """Steady gains and bandwidth."""
        return _derived(gyroscope_steady(jnp.asarray(params.Q) / params.R, self.dt))


class FixedGains(NamedTuple):
    """Constant gains."""

    K1: Annotated[
        ArrayLike,
        Param(
            "",
            "gain on the measured quantity",
            typical=0.1,
            low=1e-6,
            high=1.0,
            smaller="the output is smoother and lags",
            larger="the output follows the measurements",
            per_sample=True,
        ),
    ]
    K2: Annotated[
        ArrayLike,
        Param(
            "1/s",
            "gain on its derivative; 0 for a filter without one",
            typical=0.5,
            low=1e-6,
            high=1e3,
            smaller="the derivative is smoother and lags",
            larger="the derivative follows the measurements",
            per_sample=True,
        ),
    ]


@dataclass(frozen=True)
class FixedGainFilter:
    """The steady form of either filter, once P0 is forgotten: two numbers instead of a covariance.

    The form for a small machine: no division, and single precision is enough.

    Attributes:
        dt: sample time T in s.
        shape: shape of one sample, ``()``; ``(s,)`` where s signals pass through the same gains.
    """

    dt: float
    shape: tuple[int, ...] = ()

    params, inputs, outputs = FixedGains, MEASURED, FILTERED
    states = {  # noqa: RUF012
        "level": Channel("unit", "measured quantity"),
        "slope": Channel("unit/s", "its derivative"),
    }

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: FixedGains) -> tuple[Array, Array]:
        """At zero: the measured quantity and its derivative."""
        still = jnp.zeros(self.shape, jnp.asarray(params.K1).dtype)
        return still, still

    def step(
        self, params: FixedGains, state: tuple[Array, Array], inputs: Array
    ) -> tuple[tuple[Array, Array], Array]:
        """Take one sample; NaN is a missing one."""
        level, slope = state
        level = level + self.dt * slope
        y = jnp.where(jnp.any(jnp.isnan(inputs)), 0.0, inputs - level)
        level = level + params.K1 * y
        return (level, slope + params.K2 * y), level


class SteadyState(NamedTuple):
    """The steady state of a filter, once P0 is forgotten.

    Attributes:
        gains: the gains of the :class:`FixedGainFilter` that it becomes.
        bandwidth_hz: frequency at which the response has fallen by 3 dB.
    """

    gains: FixedGains
    bandwidth_hz: Array


def _derived(steady: SteadyState) -> dict[str, Array]:
    (K1, K2), bandwidth = steady
    return {"K1": jnp.asarray(K1), "K2": jnp.asarray(K2), "bandwidth": bandwidth}


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
    return SteadyState(FixedGains(K, jnp.zeros_like(K)), bandwidth)


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
    return SteadyState(FixedGains(K1, K2), _gyroscope_bandwidth(K1, K2, T))


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
