"""Units that follow from a linear system itself, whichever units the user chose."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np


class Balance(NamedTuple):
    """Units in which the entries of matrices are near one.

    Attributes:
        time: of time.
        states: of each state, ``(n,)``.
        measurements: of each measurement, ``(m,)``.
        errors: of all errors that count.
    """

    time: float
    states: np.ndarray
    measurements: np.ndarray
    errors: float


def balance(
    A: np.ndarray,
    C: np.ndarray,
    W: np.ndarray | None = None,
    V: np.ndarray | None = None,
    M: np.ndarray | None = None,
    *,
    fixed_time: bool = False,
    fixed_errors: bool = False,
) -> Balance:
    """Units in which the logarithms of all entries that are not zero are least, squared.

    Args:
        A: dynamics, ``(n, n)``, per unit of time.
        C: measurements, ``(m, n)``.
        W, V: densities of their noise, whose variances count; None: they do not count.
        M: errors that count, ``(k, n)``.
        fixed_time: whether the unit of time stays, as for a system of samples.
        fixed_errors: whether the errors' unit stays.

    >>> balance(np.array([[0.0, 0.0], [1e6, 0.0]]), np.array([[0.0, 1.0]])).states.round(3).tolist()
    [0.004, 15.849]
    """
    n, m = len(A), len(C)
    unit = np.eye(2 + n + m)
    T, x, y, e = unit[0] * (not fixed_time), unit[1 : 1 + n], unit[1 + n : -1], unit[-1]
    e = e * (not fixed_errors)
    rows: list[np.ndarray] = []
    logs: list[float] = []

    def add(matrix: np.ndarray, row: Callable[[int, int], np.ndarray]) -> None:
        for i, j in np.argwhere(matrix):
            rows.append(row(i, j))
            logs.append(-float(np.log(abs(matrix[i, j]))))

    add(A, lambda i, j: T + x[j] - x[i])
    add(C, lambda i, j: x[j] - y[i])
    if W is not None:
        add(np.diag(np.diag(W)), lambda i, j: T - x[i] - x[j])
    if V is not None:
        add(np.diag(np.diag(V)), lambda i, j: -T - y[i] - y[j])
    if M is not None:
        add(M, lambda i, j: x[j] - e)
    if not rows:
        return Balance(1.0, np.ones(n), np.ones(m), 1.0)
    found = np.exp(np.linalg.lstsq(np.array(rows), np.array(logs))[0])
    return Balance(float(found[0]), found[1 : 1 + n], found[1 + n : -1], float(found[-1]))
