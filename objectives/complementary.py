"""Errors of a complementary filter due to its sensors, over frequency and in variance.

The filter follows a rate, and is drawn to a measured angle by K1 times the difference and by K1 K2
times its integral (:class:`filters.PiComplementary`). Its error is then
(s b + (K1 s + K1 K2) n) / (s^2 + K1 s + K1 K2), b being the error of the rate and n that of the
angle. Source: You and Lee, (1), (7), (8), (15); the variances are the integrals of the transfers.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jax import Array

from objectives.squares import root


class Transfer(NamedTuple):
    """Complex amplification of sensor errors into the error of the angle, of omega's shape.

    Attributes:
        gyroscope: of an error of the rate, s.
        accelerometer: of an error of the measured angle, 1.
    """

    gyroscope: Array
    accelerometer: Array


class SensorNoise(NamedTuple):
    """Densities of white noises, two-sided: the variance of their integral over one second.

    Attributes:
        rate: of the rate, rad^2/s.
        walk: of the rate's bias, a random walk, rad^2/s^3.
        angle: of the measured angle, rad^2 s: a variance a sample times the sample time.
    """

    rate: Array | float = 0.0
    walk: Array | float = 0.0
    angle: Array | float = 0.0


class ComplementaryLoop(NamedTuple):
    """A complementary filter by its gains; K2 = 0 makes it first-order, with time constant 1/K1.

    Everything is differentiable in the gains, and of their shape. Gains of another sign make a
    filter that is not stable: damping and frequency are NaN then, and the variance is infinite.

    Attributes:
        K1: 1/s, positive.
        K2: 1/s, not negative.
    """

    K1: Array | float
    K2: Array | float

    @classmethod
    def critical(cls, tau: Array) -> "ComplementaryLoop":
        """(15): both poles at -1/tau, so K1 = 2/tau and K2 = K1/4.

        >>> [float(gain) for gain in ComplementaryLoop.critical(jnp.array(40.0))]
        [0.05, 0.0125]
        """
        return cls(2 / tau, 1 / (2 * tau))

    @classmethod
    def first_order(cls, tau: Array) -> "ComplementaryLoop":
        """One pole at -1/tau."""
        return cls(1 / tau, jnp.zeros_like(tau))

    @property
    def natural_frequency(self) -> Array:
        """Rad/s; 0 where K2 is."""
        return jnp.where(self._stable, root(jnp.asarray(self.K1 * self.K2)), jnp.nan)

    @property
    def damping(self) -> Array:
        """Sqrt(K1/K2)/2, 1 where (15) holds; infinite where K2 = 0."""
        second = jnp.asarray(self.K2) > 0
        ratio = root(self.K1 / jnp.where(second, self.K2, 1.0)) / 2
        return jnp.where(self._stable, jnp.where(second, ratio, jnp.inf), jnp.nan)

    @property
    def _stable(self) -> Array:
        return (jnp.asarray(self.K1) > 0) & (jnp.asarray(self.K2) >= 0)

    @property
    def poles(self) -> Array:
        """Both poles, complex, ``(..., 2)``, the faster first; 0 stands for an unused integral.

        At a double pole their derivative is not finite: they split as a square root.
        """
        spread = jnp.sqrt(jnp.asarray(self.K1**2 - 4 * self.K1 * self.K2).astype(complex))
        fast = -(self.K1 + spread) / 2
        return jnp.stack([fast, self.K1 * self.K2 / fast], axis=-1)

    def transfer(self, omega: Array) -> Transfer:
        """Transfer of sinusoidal errors, omega in rad/s, broadcast against the gains.

        >>> both = ComplementaryLoop.critical(jnp.array(40.0)).transfer(jnp.array(0.0))
        >>> [float(abs(part)) for part in both]
        [0.0, 1.0]
        """
        s = 1j * omega
        # Over s where K2 = 0, so that the first order has its value at omega = 0.
        second = jnp.asarray(self.K2) > 0
        steady = self.K1 * self.K2
        top = jnp.where(second, self.K1 * s + steady, self.K1)
        bottom = jnp.where(second, s**2 + self.K1 * s + steady, s + self.K1)
        return Transfer(jnp.where(second, s, 1.0) / bottom, top / bottom)

    def variance(self, noise: SensorNoise) -> Array:
        """Steady variance of the angle's error, rad^2; infinite for a random walk at K2 = 0.

        >>> float(ComplementaryLoop(jnp.array(0.5), jnp.array(0.5)).variance(SensorNoise(rate=2.0)))
        2.0
        """
        second = jnp.asarray(self.K2) > 0
        walk = jnp.asarray(noise.walk)
        drift = walk / (2 * self.K1**2 * jnp.where(second, self.K2, 1.0))
        drift = jnp.where(second, drift, jnp.where(walk > 0, jnp.inf, 0.0))
        white = (noise.rate / self.K1 + (self.K1 + self.K2) * noise.angle) / 2
        return jnp.where(self._stable, white + drift, jnp.inf)

    def bias_error(self, bias: Array) -> Array:
        """The steady error due to a constant rate bias, rad: 0, or bias / K1 where K2 = 0."""
        return jnp.where(jnp.asarray(self.K2) > 0, 0.0, bias / self.K1)

    def ramp_error(self, slope: Array) -> Array:
        """The steady error due to a rate error growing by slope rad/s^2, rad, (8); see K2 = 0."""
        second = jnp.asarray(self.K2) > 0
        left = slope / (self.K1 * jnp.where(second, self.K2, 1.0))
        return jnp.where(second, left, jnp.where(slope == 0, 0.0, jnp.sign(slope) * jnp.inf))
