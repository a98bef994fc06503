"""The gains of a tracking filter by their usual names: alpha, beta, gamma."""

from math import factorial

import numpy as np

_GREEK = ("alpha", "beta", "gamma")
_SAME = 1e-9


def tracker_gains(F: np.ndarray, C: np.ndarray, K: np.ndarray, dt: float) -> dict[str, float]:
    """Alpha, beta and gamma where the model is a position with one or two derivatives.

    K is (alpha, beta / dt, gamma / (2 dt^2)): Bar-Shalom, Li and Kirubarajan 2001, 6.5.

    Args:
        F: transition, ``(n, n)``.
        C: measurement matrix, ``(m, n)``.
        K: gain on a measurement, ``(n, m)``.
        dt: sample time, s.

    Returns:
        Two or three numbers by name; nothing for another model.

    >>> F, C = np.array([[1.0, 2.0], [0.0, 1.0]]), np.array([[1.0, 0.0]])
    >>> tracker_gains(F, C, np.array([[0.7], [0.2]]), dt=2.0)
    {'alpha': 0.7, 'beta': 0.4}
    """
    n = len(F)
    if n not in (2, 3) or K.shape[1] != 1:
        return {}
    chain = np.array(
        [[dt ** (j - i) / factorial(j - i) if j >= i else 0.0 for j in range(n)] for i in range(n)]
    )
    first = np.eye(n)[:1]
    if not (np.allclose(F, chain, rtol=_SAME, atol=0) and np.array_equal(C, first)):
        return {}
    return {name: float(K[i, 0]) * dt**i * factorial(i) for i, name in enumerate(_GREEK[:n])}
