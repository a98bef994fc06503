"""Factorisations of small matrices, and solving with them."""

from collections.abc import Callable
from typing import Any

import numpy as np


def _stacked(function: Callable[..., tuple[np.ndarray, ...]]) -> Callable[..., Any]:
    """A function of matrices, over all axes before the last two."""

    def over(*given: np.ndarray, **params: Any) -> list[np.ndarray]:
        lead = given[0].shape[:-2]
        if not lead:
            return list(function(*given, **params))
        each = [function(*(x[at] for x in given), **params) for at in np.ndindex(lead)]
        return [np.reshape(part, lead + part[0].shape) for part in zip(*each, strict=True)]

    return over


def _lu(x: np.ndarray, **_: Any) -> tuple[np.ndarray, ...]:
    """The factors in one matrix, the rows that were swapped, and the order that follows."""
    a, (m, n) = np.array(x), x.shape
    order, pivots = np.arange(m), np.zeros(min(m, n), int)
    for k in range(min(m, n)):
        p = k + int(np.argmax(np.nan_to_num(np.abs(a[k:, k]), nan=-1.0)))
        pivots[k] = p
        a[[k, p]], order[[k, p]] = a[[p, k]], order[[p, k]]
        if a[k, k] != 0:
            a[k + 1 :, k] /= a[k, k]
        a[k + 1 :, k + 1 :] -= np.outer(a[k + 1 :, k], a[k, k + 1 :])
    return a, pivots, order


def _triangular(
    a: np.ndarray,
    b: np.ndarray,
    *,
    left_side: bool,
    lower: bool,
    transpose_a: bool,
    conjugate_a: bool,
    unit_diagonal: bool,
) -> tuple[np.ndarray]:
    matrix = np.conj(a) if conjugate_a else a
    if not left_side:  # x a = b, so a' x' = b'
        matrix, b = matrix.T, b.T
        lower = not lower
    if transpose_a:
        matrix, lower = matrix.T, not lower
    x, n = np.array(b), len(matrix)
    for k in range(n) if lower else reversed(range(n)):
        done = slice(0, k) if lower else slice(k + 1, n)
        x[k] = x[k] - matrix[k, done] @ x[done]
        if not unit_diagonal:
            x[k] = x[k] / matrix[k, k]
    return (x if left_side else x.T,)


def _cholesky(x: np.ndarray, **_: Any) -> tuple[np.ndarray]:
    """Of what has no factor NaN, as in JAX."""
    try:
        return (np.linalg.cholesky(x),)
    except np.linalg.LinAlgError:
        return (np.full_like(x, np.nan),)


def _eigen(
    x: np.ndarray, *, compute_left_eigenvectors: bool, compute_right_eigenvectors: bool, **_: Any
) -> tuple[np.ndarray, ...]:
    """Eigenvalues, and eigenvectors of length 1; of what is not finite NaN, as in JAX."""
    wanted = compute_left_eigenvectors + compute_right_eigenvectors
    if not np.isfinite(x).all():
        return np.full(len(x), complex(np.nan, np.nan)), *wanted * [x * complex(np.nan, np.nan)]
    if not wanted:
        return (np.linalg.eigvals(x).astype(complex),)
    from scipy.linalg import eig

    values, *vectors = eig(x, left=compute_left_eigenvectors, right=compute_right_eigenvectors)
    return values, *(each.astype(complex) for each in vectors)


def _only(function: Callable[..., list[np.ndarray]]) -> Callable[..., np.ndarray]:
    return lambda *given, **params: function(*given, **params)[0]


LINALG: dict[str, Callable[..., Any]] = {
    "lu": _stacked(_lu),
    "triangular_solve": _only(_stacked(_triangular)),
    "cholesky": _only(_stacked(_cholesky)),
    "eig": _stacked(_eigen),
}
