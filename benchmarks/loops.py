"""The filter as Python loops: a reference to 40 digits, and the usual code in NumPy."""

from decimal import Decimal, localcontext
from typing import Any

import numpy as np


def scalar_loop(z: Any, R: Any, Q: Any, dt: Any) -> list[Any]:
    """The filter written out, in whatever arithmetic its arguments bring.

    Python numbers, decimals, or arrays of them: several signals, several (R, Q).
    """
    q, one = Q * dt**2, R / R
    a = b = c = one
    x0 = x1 = 0 * (one * z[0])
    out = []
    for sample in z:
        a, b, c = a + dt * (2 * b + dt * c) + q, b + dt * c, c + q
        k0, k1 = a / (a + R), b / (a + R)
        a, b, c = R * k0, R * k1, c - k1 * b
        level = x0 + dt * x1
        y = sample - level
        x0, x1 = level + k0 * y, x1 + k1 * y
        out.append(x0)
    return out


def matrix_loop(z: np.ndarray, R: float, Q: float, dt: float) -> np.ndarray:
    """The textbook: NumPy matrices and a loop."""
    F, H, W = np.array([[1.0, dt], [0.0, 1.0]]), np.array([[1.0, 0.0]]), Q * dt**2 * np.eye(2)
    x, P, out = np.zeros(2), np.ones((2, 2)), np.empty(len(z))
    for k, sample in enumerate(z):
        x, P = F @ x, F @ P @ F.T + W
        K = (P @ H.T / (H @ P @ H.T + R))[:, 0]
        x = x + K * (sample - x[0])
        P = P - np.outer(K, P[0])
        out[k] = x[0]
    return out


def exact(z: np.ndarray, R: float, Q: float, dt: float) -> np.ndarray:
    """The filter to 40 digits, rounded at the end."""
    with localcontext(prec=40):
        numbers = [Decimal(value) for value in (R, Q, dt)]
        found = scalar_loop([Decimal(value) for value in z.tolist()], *numbers)
    return np.array(found, dtype=float)
