"""What an observer is designed for, what a gain comes to there, and which models are refused."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Model:
    """What an observer is designed for.

    Attributes:
        A: dynamics, ``(n, n)``; 1/s, or per sample where discrete.
        C: what is measured, ``(m, n)``.
        W: noise of the states, ``(n, n)``, positive semidefinite: spectral density in unit^2/Hz
            (two-sided), or covariance per sample.
        V: noise of the measurements, ``(m, m)``, the same; may be zero or singular.
        M: the errors that count, M e, ``(k, n)``.
        S: what both noises share, ``(n, m)``: E w v'.
        discrete: whether the model is one of samples.
    """

    A: np.ndarray
    C: np.ndarray
    W: np.ndarray
    V: np.ndarray
    M: np.ndarray
    S: np.ndarray
    discrete: bool

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Numbers of states, measurements and errors that count."""
        return len(self.A), len(self.C), len(self.M)

    @property
    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """A, C, W, V and M."""
        return self.A, self.C, self.W, self.V, self.M

    def poles(self, gain: np.ndarray) -> np.ndarray:
        """Eigenvalues of A - L C, ``(n,)`` complex, the slowest first."""
        poles = np.linalg.eigvals(self.A - gain @ self.C)
        speed = np.abs(poles) if self.discrete else poles.real
        return np.asarray(poles[np.argsort(-speed, kind="stable")])

    def decay(self, pole: complex) -> float:
        """Decay rate of a pole: -Re, or -ln |.| per sample."""
        return float(-np.log(max(abs(pole), TINY)) if self.discrete else -pole.real)

    def rate(self, gain: np.ndarray) -> float:
        """Decay rate of the slowest pole."""
        return self.decay(self.poles(gain)[0])

    def covariance(self, gain: np.ndarray) -> np.ndarray:
        """Steady covariance of the error under a gain, by its Lyapunov equation; inf if none."""
        from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

        F = self.A - gain @ self.C
        if not np.isfinite(F).all() or not self.rate(gain) > 1e-12 * np.linalg.norm(F):
            return np.full_like(self.A, np.inf)
        shared = self.S @ gain.T
        noise = self.W + gain @ self.V @ gain.T - shared - shared.T
        steady = solve_discrete_lyapunov if self.discrete else solve_continuous_lyapunov
        P = steady(F, noise if self.discrete else -noise)
        return np.asarray((P + P.T) / 2)

    def variances(self, covariance: np.ndarray) -> np.ndarray:
        """Variances of M e, ``(k,)``."""
        if not np.isfinite(covariance).all():
            return np.full(len(self.M), np.inf)
        return np.asarray(np.einsum("ki,ij,kj->k", self.M, covariance, self.M))

    def variances_under(self, gain: np.ndarray) -> np.ndarray:
        """Variances of M e in steady state under a gain, ``(k,)``."""
        return self.variances(self.covariance(gain))

    def total(self, gain: np.ndarray) -> float:
        """Their sum."""
        return float(self.variances_under(gain).sum())


def observer_model(
    A: ArrayLike, C: ArrayLike, W: ArrayLike, V: ArrayLike, M: ArrayLike, discrete: bool = False
) -> Model:
    """A model of independent noises, checked.

    Args:
        A, C, W, V, M, discrete: see :class:`Model`.

    Raises:
        ValueError: for shapes that do not fit, and noise that is no covariance.
    """
    given = {"A": A, "C": C, "W": W, "V": V, "M": M}
    arrays = {name: np.asarray(value, float) for name, value in given.items()}
    for name, array in arrays.items():
        if array.ndim != 2 or not array.size:
            raise ValueError(f"{name} has shape {array.shape}; give a matrix")
        if not np.isfinite(array).all():
            raise ValueError(f"{name} holds {array[~np.isfinite(array)][0]}; give finite numbers")
    n, m, k = len(arrays["A"]), len(arrays["C"]), len(arrays["M"])
    needed = {"A": (n, n), "C": (m, n), "W": (n, n), "V": (m, m), "M": (k, n)}
    for name, shape in needed.items():
        if arrays[name].shape != shape:
            raise ValueError(f"{name} has shape {arrays[name].shape}, but needs {shape}")
    for name in ("W", "V"):
        arrays[name] = _covariance(name, arrays[name])
    return Model(**arrays, S=np.zeros((n, m)), discrete=discrete)


def _covariance(name: str, matrix: np.ndarray) -> np.ndarray:
    scale = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    unit = matrix / np.where(scale > 0, scale, 1.0) / np.where(scale > 0, scale, 1.0)[:, None]
    if not np.allclose(unit, unit.T, rtol=0.0, atol=1e-9):
        raise ValueError(f"{name} is not symmetric: {matrix.tolist()}")
    lowest = np.linalg.eigvalsh((unit + unit.T) / 2)[0]
    if lowest < -1e-9 * len(matrix):
        raise ValueError(
            f"{name} has a negative eigenvalue ({lowest:.3g} of its diagonal), so it is no "
            "covariance; give a positive semidefinite matrix"
        )
    return np.asarray((matrix + matrix.T) / 2)


def hidden(model: Model) -> list[complex]:
    """Poles of the modes that do not show in the measurements, by Hautus' test."""
    found = []
    for pole in np.linalg.eigvals(model.A):
        seen = np.vstack([model.A - pole * np.eye(len(model.A)), model.C])
        parts = np.linalg.svd(seen, compute_uv=False)
        if parts[-1] < 1e-10 * parts[0]:
            found.append(complex(pole))
    return found


def refuse_undetectable(model: Model, unit: float) -> None:
    """Refuse a mode that neither decays nor shows in the measurements.

    Args:
        model: the model, in units of its own.
        unit: its unit of time.

    Raises:
        ValueError: names its pole in the user's unit of time.
    """
    for pole in hidden(model):
        if abs(pole) >= 1 if model.discrete else pole.real >= 0:
            named = pole if pole.imag else pole.real
            raise ValueError(
                f"a mode of A that does not decay does not show in C (pole {named / unit:.6g}), "
                "so no observer is stable; measure what contains it or leave it out"
            )
