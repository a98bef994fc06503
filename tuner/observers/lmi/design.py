"""A system, the errors of its observer that count, and their variances under a gain."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from objectives import LinearSystem


@dataclass(frozen=True)
class Design:
    """The system of an observer, and the errors that it is designed for.

    Attributes:
        system: the system.
        M: the errors that count, M e, ``(k, n)``.
    """

    system: LinearSystem
    M: np.ndarray

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Numbers of states, measurements and errors that count."""
        return len(self.system.A), len(self.system.C), len(self.M)

    def covariance(self, gain: np.ndarray) -> np.ndarray:
        """Steady covariance of the error under a gain, ``(n, n)``; inf without stability."""
        F = self.system.A - gain @ self.system.C
        stable = np.isfinite(F).all() and self.system.decay(gain) > 1e-12 * np.linalg.norm(F)
        P = self.system.covariance(gain) if stable else F
        return P if stable and np.isfinite(P).all() else np.full_like(F, np.inf)

    def variances(self, covariance: np.ndarray) -> np.ndarray:
        """Variances of M e, ``(k,)``."""
        if not np.isfinite(covariance).all():
            return np.full(len(self.M), np.inf)
        return np.asarray(np.einsum("ki,ij,kj->k", self.M, covariance, self.M))

    def variances_under(self, gain: np.ndarray) -> np.ndarray:
        """Variances of M e in steady state under a gain, ``(k,)``."""
        return self.variances(self.covariance(gain))

    def total(self, gain: np.ndarray) -> float:
        """The sum of these variances."""
        return float(self.variances_under(gain).sum())


def design_of(system: LinearSystem, errors: ArrayLike) -> Design:
    """A system with the errors that count, checked.

    Args:
        system: the system.
        errors: M, ``(k, n)``.

    Raises:
        ValueError: where the errors do not fit the system, or are not finite.
    """
    M = np.asarray(errors, float)
    n = len(system.A)
    if M.ndim != 2 or not M.size or M.shape[1] != n:
        raise ValueError(f"the errors M have the shape {M.shape}; {n} states need (k, {n})")
    if not np.isfinite(M).all():
        raise ValueError(f"the errors M hold {M[~np.isfinite(M)][0]}; give finite numbers")
    return Design(system, M)
