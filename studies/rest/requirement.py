"""A requirement on a filter, and the gain of x+ = x + K (z - x) that meets it.

Exponential smoothing, which is what a local level's Kalman filter becomes, has one gain. All that
is asked here gets easier with a larger gain, and its noise grows with it, so the least noise has
the least gain that will do; or the record's own gain, where this is larger.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import ArrayLike

Kind: TypeAlias = Literal["settles_s", "bandwidth_hz", "latency_s"]
SETTLED = 0.02
"""Share of a step that may be missing when it has settled."""


@dataclass(frozen=True)
class Requirement:
    """One requirement on a filter.

    Attributes:
        kind: settling time, bandwidth, or largest lag.
        value: in s or Hz.
        dt: sample time of the filter, s.

    Raises:
        ValueError: where no discrete filter meets it.
    """

    kind: Kind
    value: float
    dt: float

    def __post_init__(self) -> None:
        if self.kind == "settles_s" and self.samples < 1:
            raise ValueError(
                f"no filter settles within {self.value:g} s: samples come every {self.dt:g} s; ask "
                "for a sample's time or more, or sample faster"
            )
        if self.kind == "bandwidth_hz" and self.value >= 0.5 / self.dt:
            raise ValueError(
                f"no filter of samples at {1 / self.dt:g} Hz passes {self.value:g} Hz: half the "
                "rate is the most that they hold; ask for less, or sample faster"
            )

    @property
    def samples(self) -> int:
        """Samples within the allowed settling time."""
        return int(np.floor(self.value / self.dt * (1 + 1e-9)))

    @property
    def span_s(self) -> float:
        """Settling time of the filter with the least gain, s."""
        return settling(self.gain, self.dt) if self.gain < 1 else self.dt

    @property
    def gain(self) -> float:
        """The least gain that meets it, in closed form."""
        match self.kind:
            case "settles_s":
                return float(-np.expm1(np.log(SETTLED) / self.samples))
            case "bandwidth_hz":
                # (2 - c) - sqrt((2 - c)^2 - 1) with c = cos(2 pi f dt), nothing subtracted.
                less = 2 * np.sin(np.pi * self.value * self.dt) ** 2
                return float(np.sqrt(less * (2 + less)) - less)
            case _:
                return self.dt / (self.value + self.dt)

    @property
    def most(self) -> float:
        """Upper limit of :meth:`measure`."""
        match self.kind:
            case "settles_s":
                return self.samples * self.dt
            case "bandwidth_hz":
                return 2.0
            case _:
                return self.value

    def measure(self, gain: Array, _: None) -> Array:
        """Settling time or lag, s; or the attenuation in power of a sine of the frequency."""
        match self.kind:
            case "settles_s":
                return self.dt * jnp.log(SETTLED) / jnp.log1p(-gain)
            case "bandwidth_hz":
                less = 2 * jnp.sin(jnp.pi * self.value * self.dt) ** 2
                return 1 + 2 * (1 - gain) * less / gain**2
            case _:
                return self.dt * (1 - gain) / gain

    @property
    def words(self) -> str:
        """The requirement in words."""
        match self.kind:
            case "settles_s":
                return f"settles to {100 * SETTLED:g} % within {self.value:g} s"
            case "bandwidth_hz":
                return f"passes {self.value:g} Hz to -3 dB"
            case _:
                return f"lags {self.value:g} s behind a steady change"


def settling(gain: float, dt: float) -> float:
    """Settling time of a step to 2 %, s.

    >>> round(settling(0.02, 0.01), 2)
    1.94
    """
    return float(dt * np.ceil(np.log(SETTLED) / np.log1p(-gain) - 1e-9))


def bandwidth(gain: float, dt: float) -> float:
    """Frequency at which a sine is attenuated by 3 dB, Hz; half the sample rate where none is.

    >>> round(bandwidth(Requirement("bandwidth_hz", 2.0, 0.01).gain, 0.01), 12)
    2.0
    """
    square = gain**2 / (4 * (1 - gain)) if gain < 1 else np.inf
    return float(np.arcsin(np.sqrt(min(square, 1.0))) / (np.pi * dt))


def latency(gain: ArrayLike, dt: float) -> np.ndarray:
    """Lag of the output behind a ramp, s: the group delay at low frequencies."""
    K = np.asarray(gain, float)
    return np.asarray(dt * (1 - K) / K)


def error_variance(gain: ArrayLike | Array, R: float, Q: float) -> Array:
    """Error variance about a random walk: noise of the output, and its lag behind the walk.

    From e+ = (1 - K) (e - w) + K v, with the variances Q of w and R of v a sample.
    """
    K = jnp.asarray(gain)
    return (K**2 * R + (1 - K) ** 2 * Q) / (K * (2 - K))


def kalman_gain(R: float, Q: float) -> float:
    """The gain of least error variance: that of the steady Kalman filter, K^2 / (1 - K) = Q / R.

    >>> round(kalman_gain(1.0, 0.5), 12)
    0.5
    """
    root = np.sqrt(Q / R)
    return float(2 * root / (root + np.sqrt(Q / R + 4)))


def knee(R: float, Q: float, dt: float) -> float:
    """The latency whose doubling lowers the noise by a tenth, s.

    The variance is about N^2 / (2 D) + K^2 D / 2, so with D* = N / K, where it is least, the knee
    lies at D* sqrt((0.5 - 0.81) / (0.81 - 2)); infinite without a walk.
    """
    if Q == 0:
        return np.inf
    return float(dt * np.sqrt(R / Q) * np.sqrt((0.81 - 0.5) / (2 - 0.81)))
