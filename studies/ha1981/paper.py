"""Values and formulas printed by Ha, Kim and Choi, in feet and seconds."""

from typing import NamedTuple

import numpy as np

FOOT = 0.3048
"""A foot in metres."""
Q_A = 0.04
"""Spectral density of W_a, (ft/s^2)^2 s."""
Q_B = 3.24
"""Variance of the altitude's noise, ft^2."""
SIGMA2_AB = 4.0
"""Variance of the bias at t = 0, (ft/s^2)^2 (III); II.2 uses the same number as the bound."""
SIGMA2_HR = 100.0
"""Variance of the given altitude, ft^2."""
BOUND = 4e-4
"""Bound of the bias's variance, (ft/s^2)^2. The paper gives no meaningful one; this is ours."""
TS = 5.0
"""The design value of Ts, s; the printed gains are those."""


class Steady(NamedTuple):
    """The paper's closed forms for Kgh -> 0.

    Attributes:
        K1, K2, K3: gains.
        A, B: the numbers they are computed from.
    """

    K1: float
    K2: float
    K3: float
    A: float
    B: float


def steady_gains(q_a: float, q_b: float, Ts: float) -> Steady:
    """K1inf, K2inf and K3inf after (18), with q_a a spectral density.

    >>> [round(k, 6) for k in steady_gains(0.04, 3.24, 5.0)[:3]]
    [0.0, 0.113031, 0.793028]
    """
    A = q_a * (Ts**2 + np.sqrt(Ts**4 / 3 + 16 * q_b * Ts / q_a)) / 2
    B = np.sqrt(A**2 - 4 * q_a * q_b * Ts)
    noise = 2 * q_a * q_b * Ts
    K2, K3 = (A - B) / (2 * q_b), 1 - noise / (A * B + B**2 + noise)
    return Steady(0.0, *map(float, (K2, K3, A, B)))


def printed_noise(q_a: float, k_gh: float, Ts: float) -> np.ndarray:
    """The covariance Q printed below (12), of (dV, dh), ``(2, 2)``.

    It is the integrand of white noise's covariance with a stray Ts below the middle entries; its
    determinant, q_a^2 (cosh sinh)^2 (1 - 1/Ts^2) / Kgh, is negative for Ts < 1.

    Raises:
        ValueError: where it is not a covariance, with its eigenvalue.
    """
    w = np.sqrt(k_gh)
    middle = np.sinh(2 * w * Ts) / (2 * Ts * w)
    corner = np.sinh(w * Ts) ** 2 / k_gh
    Q = q_a * np.array([[np.cosh(w * Ts) ** 2, middle], [middle, corner]])
    lowest = float(np.linalg.eigvalsh(Q)[0])
    if lowest < 0:
        raise ValueError(
            f"the Q printed below (12) has the eigenvalue {lowest:.6g} at Ts = {Ts:g} s; use the "
            "covariance of white noise (Van Loan)"
        )
    return Q
