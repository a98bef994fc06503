"""Unobservable and undriven subspaces of a linear model.

Decisions are taken in units in which the entries of the model are alike, so the units of states
and of time do not decide.
"""

from typing import NamedTuple

import numpy as np
import scipy.linalg

from objectives.linear_systems.model import LinearSystem
from objectives.linear_systems.scaling import balance

MOST_SLACK = 1e-6
"""Largest tolerance of an eigenvalue, as a share of the rates: rounding of a chain of two."""
_EPS = float(np.finfo(np.float64).eps)
_NOTHING = 1e-10  # of a scaled model's entries: far above rounding, far below any use


class Subspace(NamedTuple):
    """An invariant subspace in scaled states.

    Attributes:
        values: eigenvalues in it, ``(k,)``.
        basis: orthonormal, ``(n, k)``.
        scale: x = scale * scaled, ``(n,)``.
    """

    values: np.ndarray
    basis: np.ndarray
    scale: np.ndarray


def unobservable(system: LinearSystem) -> Subspace:
    """The unobservable subspace, decaying modes included.

    >>> A, C = [[-1.0, 0.0], [0.0, -2.0]], [[1.0, 0.0]]
    >>> found = unobservable(LinearSystem(A, C, np.eye(2), [[1.0]]))
    >>> found.values.tolist(), found.basis.ravel().tolist()
    ([-2.0], [0.0, 1.0])
    """
    basis, inner, size, scale, _ = _hidden(system.A, system.C, system.discrete)
    rest = 1.0 if system.discrete else 0.0
    values = np.linalg.eigvals(inner) * size + rest if inner.size else np.zeros(0)
    return Subspace(values, basis, scale)


def unseen(system: LinearSystem) -> Subspace:
    """The undetectable subspace: unobservable, and not decaying."""
    return _lasting(system.A, system.C, system.discrete, grows=True)


def undriven(system: LinearSystem) -> Subspace:
    """Neutral modes that no noise drives: combinations y = scaled / scale."""
    values, basis, scale = _lasting(system.A.T, system.W, system.discrete, grows=False)
    return Subspace(values, basis, 1 / scale)


class _Hidden(NamedTuple):
    """The invariant subspace in the kernel of C: its basis, and A within it, over its size."""

    basis: np.ndarray
    inner: np.ndarray
    size: float
    scale: np.ndarray
    rounding: float


def _hidden(A: np.ndarray, C: np.ndarray, discrete: bool) -> _Hidden:
    rates = A - np.eye(len(A)) if discrete else A
    scale = _scale(rates, C)
    rates = rates / scale[:, None] * scale
    size = float(np.abs(rates).max(initial=0.0))
    rounding = _EPS * max(1.0, 1 / size) if discrete and size > 0 else _EPS
    unit = rates / size if size > 0 else rates
    basis = _unobservable(unit, C * scale, max(_NOTHING, 1e3 * rounding))
    return _Hidden(basis, basis.T @ unit @ basis, size, scale, rounding)


def _lasting(A: np.ndarray, C: np.ndarray, discrete: bool, grows: bool) -> Subspace:
    """The invariant subspace of A in the kernel of C whose modes do not decay."""
    basis, inner, size, scale, rounding = _hidden(A, C, discrete)
    if not inner.size:
        return Subspace(np.zeros(0), basis, scale)
    slack = _slack(inner, rounding)

    def kept(value: complex) -> bool:
        over = value.real + (size * abs(value) ** 2 / 2 if discrete else 0.0)
        reach = slack * (1 + (size * abs(value) if discrete else 0.0))
        return bool(over >= -reach if grows else abs(over) <= reach)

    _, vectors, count = scipy.linalg.schur(inner.astype(complex), output="complex", sort=kept)
    form = vectors[:, :count].conj().T @ inner @ vectors[:, :count]
    chosen = vectors[:, :count]
    values = np.diag(form) * size + (1.0 if discrete else 0.0)
    return Subspace(values, basis @ chosen, scale)


def _slack(inner: np.ndarray, rounding: float) -> float:
    """Perturbation of an eigenvalue by rounding: large if left and right vectors are orthogonal."""
    _, left, right = scipy.linalg.eig(inner, left=True)
    angle = np.abs((left.conj() * right).sum(axis=0)).min()
    return float(min(64 * rounding / max(angle, _EPS), max(MOST_SLACK, 64 * rounding)))


def _unobservable(A: np.ndarray, C: np.ndarray, nothing: float) -> np.ndarray:
    """Orthonormal basis of the largest subspace of C's kernel that A maps into itself."""
    rows = np.abs(C).max(axis=1, keepdims=True)
    basis = _kernel(C / np.where(rows > 0, rows, 1.0), nothing)
    while basis.shape[1]:
        moved = A @ basis
        kernel = _kernel(moved - basis @ (basis.T @ moved), nothing)
        if kernel.shape[1] == basis.shape[1]:
            break
        basis = basis @ kernel
    return basis


def _kernel(M: np.ndarray, nothing: float) -> np.ndarray:
    _, sizes, vectors = np.linalg.svd(M)
    return np.asarray(vectors[int((sizes > nothing).sum()) :].T)


def _scale(A: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Units of the states as powers of two, which do not round, independent of the poles."""
    between = A - np.diag(np.diag(A))
    return np.asarray(2.0 ** np.round(np.log2(balance(between, C).states)))
