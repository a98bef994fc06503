"""A point of a design: an observer, its variances, and matrices of gains as parameters."""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import ArrayLike

from objectives import LinearSystem
from tuner.problem.parameters import Limited, Parameter
from tuner.problem.problem import Problem
from tuner.problem.programs import Static


class Observer(NamedTuple):
    """A point of a design.

    Attributes:
        decay: the decay rate that is asked of the slowest pole, 1/s.
        L: gain, ``(n, m)``.
        P: steady covariance of the error under it, ``(n, n)``.
    """

    decay: Array
    L: Array
    P: Array


@dataclass(frozen=True, eq=False)
class Variance:
    """The variance that a design is about, as objective or constraint.

    Attributes:
        error: weights of the error that counts, ``(n,)``.
    """

    error: np.ndarray

    @classmethod
    def of(cls, system: LinearSystem, error: ArrayLike) -> "Variance":
        """The variance of an error of a system.

        Raises:
            ValueError: where the weights do not fit the states, or are all zero.
        """
        row = np.asarray(error, float)
        n = len(system.A)
        if row.shape != (n,) or not np.isfinite(row).all() or not row.any():
            raise ValueError(
                f"the error that counts is {row.tolist()}; give {n} finite weights of the states "
                f"{', '.join(system.states)}, not all zero"
            )
        return cls(row)

    def under(self, P: np.ndarray) -> float:
        """Variance of the error that counts, for a covariance P of all errors, ``(n, n)``."""
        return float(self.error @ P @ self.error)

    def __call__(self, observer: Observer, _: None) -> Array:
        """Variance of the error that counts, ``()``."""
        row = jnp.asarray(self.error)
        return row @ observer.P @ row


@dataclass(frozen=True, eq=False)
class Spread:
    """Mean ratio of the states' variances to those of a reference.

    Attributes:
        weights: of the states' variances, ``(n,)``.
    """

    weights: np.ndarray

    @classmethod
    def beyond(cls, system: LinearSystem, L: np.ndarray) -> "Spread":
        """Relative to the variances under a gain; a state without error there does not count."""
        variances = np.diag(system.covariance(L))
        counts = variances > 1e-12 * variances.max()
        return cls(counts / np.where(counts, variances, 1.0) / counts.sum())

    def __call__(self, observer: Observer, _: None) -> Array:
        """The mean ratio of variances, ``()``."""
        mean: Array = jnp.asarray(self.weights) @ jnp.diagonal(observer.P)
        return mean


def gain_of(problem: Problem, z: np.ndarray) -> np.ndarray:
    """The gain L ``(n, m)`` at a point of one of these problems."""
    return np.asarray(_gain(problem.static, jnp.asarray(z)))


@jax.jit(static_argnums=0)
def _gain(static: Static, z: Array) -> Array:
    observer: Observer = static.built(z)
    return observer.L


@dataclass(frozen=True)
class Entries:
    """A matrix whose entries are tuned one by one.

    Attributes:
        symbol: prefix of the entries' names.
        shape: of the matrix.
    """

    symbol: str
    shape: tuple[int, int]

    def parameters(self, start: np.ndarray, unit: np.ndarray) -> dict[str, Parameter]:
        """A parameter for every entry.

        Args:
            start: where the search begins, of the shape.
            unit: in which an entry is tuned, positive, of the shape.
        """
        found: dict[str, Parameter] = {}
        for at, name in self._names():
            value, scale = float(start[at]), float(unit[at])
            reach = 1e3 * max(abs(value), scale)
            # The ends belong to the search: a solution there is not an optimum.
            found[name] = Limited(value, -reach, reach, scale=scale, limited=False)
        return found

    def named(self, matrix: np.ndarray) -> dict[str, float]:
        """The entries of a matrix by name."""
        return {name: float(matrix[at]) for at, name in self._names()}

    def matrix(self, values: dict[str, Array]) -> Array:
        """The matrix of the entries' values."""
        entries = [values[name] for _, name in self._names()]
        return jnp.stack(entries).reshape(self.shape) if entries else jnp.zeros(self.shape)

    def _names(self) -> list[tuple[tuple[int, int], str]]:
        single = self.shape[1] == 1
        return [
            ((i, j), f"{self.symbol}{i + 1}" if single else f"{self.symbol}{i + 1}_{j + 1}")
            for i in range(self.shape[0])
            for j in range(self.shape[1])
        ]
