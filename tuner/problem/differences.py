"""A matrix of second derivatives by differences of an exact gradient."""

from collections.abc import Callable

import numpy as np


def differences(
    gradient: Callable[[np.ndarray], np.ndarray], z: np.ndarray, step: float
) -> np.ndarray:
    """The Hessian at z ``(n,)``, ``(n, n)``, by central differences of a gradient ``(n,)``.

    >>> differences(lambda z: np.array([4.0, 6.0]) * z, np.ones(2), 1e-3).round(9).tolist()
    [[4.0, 0.0], [0.0, 6.0]]
    """
    size = len(z)
    rows = [(gradient(z + h) - gradient(z - h)) / (2 * step) for h in step * np.eye(size)]
    matrix = np.reshape(rows, (size, size))
    return (matrix + matrix.T) / 2
