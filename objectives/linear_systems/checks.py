"""Checks that matrices are a covariance, and covariances and dynamics a linear system."""

from collections.abc import Mapping, Sequence

import numpy as np

ROUNDING = 1e-9
"""Tolerance for rounding, or few printed digits, where each variance is 1."""
SINGULAR = 1e-12
"""An eigenvalue below it counts as 0, where each variance is 1."""


def covariance(value: object, *, definite: bool = False) -> np.ndarray:
    """Check a covariance matrix: square, symmetric and positive (semi-)definite.

    It is judged in units in which each variance is 1, so that no unit decides.

    Args:
        value: nested sequences or an array, ``(n, n)``.
        definite: whether zero eigenvalues are refused as well.

    Returns:
        The matrix as float64, exactly symmetric.

    Raises:
        ValueError: says what is wrong, with the shape or the eigenvalue.

    >>> covariance([[1.0, 2.0], [2.0, 1.0]])
    Traceback (most recent call last):
    ValueError: must be positive semi-definite, but has the eigenvalue -1
    """
    matrix = np.array(value, dtype=float)
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or not matrix.size:
        raise ValueError(f"must be a square matrix, got the shape {matrix.shape}")
    if not np.isfinite(matrix).all():
        raise ValueError("must be finite")
    unit = _correlation(matrix)
    if not np.allclose(unit, unit.T, rtol=0, atol=ROUNDING):
        raise ValueError("must be symmetric")
    lowest = np.linalg.eigvalsh(unit)[0]
    if lowest < -ROUNDING or (definite and lowest <= SINGULAR):
        kind = "definite" if definite else "semi-definite"
        shown = np.linalg.eigvalsh(matrix)[0]
        raise ValueError(f"must be positive {kind}, but has the eigenvalue {shown:g}")
    return np.asarray((matrix + matrix.T) / 2)


def is_definite(matrix: np.ndarray) -> bool:
    """Whether a covariance has no direction without variance."""
    return bool(np.linalg.eigvalsh(_correlation(matrix))[0] > SINGULAR)


def check_shapes(matrices: Mapping[str, np.ndarray], states: Sequence[str]) -> None:
    """Refuse matrices A, C, W, V and S that do not form a linear system.

    Raises:
        ValueError: for entries that are not finite, shapes that do not fit, or too few names.
    """
    for name, matrix in matrices.items():
        if matrix.ndim != 2 or not matrix.size:
            raise ValueError(f"{name} has the shape {matrix.shape}; give a matrix")
        if not np.isfinite(matrix).all():
            wrong = matrix[~np.isfinite(matrix)][0]
            raise ValueError(f"{name} holds {wrong}; give finite numbers")
    n, m = len(matrices["A"]), len(matrices["C"])
    wanted = {"A": (n, n), "C": (m, n), "W": (n, n), "V": (m, m), "S": (n, m)}
    for name, matrix in matrices.items():
        if matrix.shape != wanted[name]:
            raise ValueError(
                f"{name} has the shape {matrix.shape}; {n} states and {m} measurements need "
                f"{wanted[name]}"
            )
    if states and len(states) != n:
        raise ValueError(f"{len(states)} names ({', '.join(states)}) for {n} states; give one each")


def noise(W: np.ndarray, V: np.ndarray, S: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """W and V, exactly symmetric.

    Raises:
        ValueError: where one is no covariance, or all three together are none.
    """
    checked = []
    for name, matrix in (("W", W), ("V", V)):
        try:
            checked.append(covariance(matrix))
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    if S.any():
        try:
            covariance(np.block([[W, S], [S.T, V]]))
        except ValueError as error:
            raise ValueError(
                f"W and V cannot share S, for [[W, S], [S', V]] {error}; give a smaller S"
            ) from None
    return checked[0], checked[1]


def _correlation(matrix: np.ndarray) -> np.ndarray:
    """A covariance scaled to a unit diagonal; directions without variance stay as they are."""
    deviation = np.sqrt(np.abs(np.diag(matrix)))
    unit = np.where(deviation > 0, deviation, 1.0)
    return np.asarray(matrix / unit / unit[:, None])
