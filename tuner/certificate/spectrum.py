"""Curvature of an objective around a point."""

from typing import NamedTuple

import numpy as np

from tuner.certificate.kkt import Held
from tuner.certificate.yardstick import Yardstick
from tuner.problem.problem import Problem


class Spectrum(NamedTuple):
    """Curvature of an objective around a point, in units of its yardstick.

    Attributes:
        curvatures: eigenvalues of the Hessian, ascending, ``(k,)``.
        directions: their eigenvectors, one per column, ``(n, k)``; k < n where constraints hold.
        hessian: of the objective itself, ``(n, n)``; None where it was not computed.
    """

    curvatures: np.ndarray
    directions: np.ndarray
    hessian: np.ndarray | None


def spectrum(problem: Problem, yard: Yardstick, z: np.ndarray, held: Held) -> Spectrum:
    """Curvature of a problem around a point ``(n,)`` along its active constraints.

    With constraints it is the Lagrangian that curves. NaN where the objective is not a number.
    """
    if not held.tangent.size:
        return Spectrum(np.zeros(0), held.tangent, None)
    own = problem.hessian(z) / yard.unit
    hessian = own
    if held.weights.any():
        hessian = own + problem.constraint_hessian(z, held.weights)
    if not np.isfinite(hessian).all():
        return Spectrum(np.full(len(z), np.nan), np.eye(len(z)), None)
    curvatures, directions = np.linalg.eigh(held.tangent.T @ hessian @ held.tangent)
    return Spectrum(curvatures, held.tangent @ directions, own)


def unknown_spectrum(size: int) -> Spectrum:
    """The spectrum of a problem of ``size`` coordinates whose curvature was not computed."""
    return Spectrum(np.zeros(0), np.zeros((size, 0)), None)
