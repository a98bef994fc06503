"""Coordinates that a model itself suggests: its own units, and those of a covariance."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tuner.observers.lmi.model import Model

SMALLEST = 1e-8
"""Variances below this share of the largest count as none where coordinates are chosen."""


@dataclass(frozen=True)
class Units:
    """Coordinates in which a model's entries are near one: x = states @ x inside, and so on."""

    time: float
    states: np.ndarray
    measurements: np.ndarray
    errors: np.ndarray

    def inside(self, model: Model) -> Model:
        """The model in these coordinates."""
        T, S, y = self.time, self.states, self.measurements
        return Model(
            A=T * np.linalg.solve(S, model.A @ S),
            C=model.C @ S / y[:, None],
            W=T * self.covariance_inside(model.W),
            V=model.V / y / y[:, None] / T,
            M=model.M @ S / self.errors[:, None],
            S=np.linalg.solve(S, model.S) / y,
            discrete=model.discrete,
        )

    def covariance_inside(self, outside: np.ndarray) -> np.ndarray:
        """A covariance of the states in these coordinates."""
        return np.asarray(np.linalg.solve(self.states, np.linalg.solve(self.states, outside).T))

    def covariance(self, inside: np.ndarray) -> np.ndarray:
        """A covariance in the user's units; all inf where it is."""
        if not np.isfinite(inside).all():
            return inside
        return np.asarray(self.states @ inside @ self.states.T)

    def gain(self, inside: np.ndarray) -> np.ndarray:
        """A gain in the user's units."""
        return np.asarray(self.states @ inside / self.measurements / self.time)

    def whitened(self, X: np.ndarray) -> "Units":
        """Coordinates in which a covariance X, given in these, is the unit matrix.

        Directions without variance keep a share of the largest one.
        """
        values, vectors = np.linalg.eigh((X + X.T) / 2)
        root = np.sqrt(np.maximum(values, SMALLEST * max(values[-1], SMALLEST)))
        return replace(self, states=self.states @ (vectors * root))


@dataclass(frozen=True)
class Scaled:
    """A model, and the same in coordinates of its own.

    Attributes:
        outer: the model as it was given.
        units: the coordinates.
    """

    outer: Model
    units: Units

    @cached_property
    def inner(self) -> Model:
        """The model in these coordinates."""
        return self.units.inside(self.outer)

    def whitened(self, X: np.ndarray) -> "Scaled":
        """The same in coordinates in which a covariance X, given in these, is the unit matrix."""
        return Scaled(self.outer, self.units.whitened(X))

    def poles(self, gain: np.ndarray) -> np.ndarray:
        """Poles under a gain of the inner model, for the outer one."""
        return self.inner.poles(gain) / self.units.time

    def covariance(self, gain: np.ndarray) -> np.ndarray:
        """Covariance of the outer model's error under a gain of the inner one."""
        return self.units.covariance(self.inner.covariance(gain))


def scaled(model: Model, errors: np.ndarray | None = None) -> Scaled:
    """A model in its own units.

    Args:
        model: the model.
        errors: units of the errors M e, ``(k,)``; without them, one for all that suits the model.
    """
    return Scaled(model, _own(model, errors))


def _own(model: Model, errors: np.ndarray | None) -> Units:
    """Units in which the logarithms of all entries that are not zero are least, squared.

    They follow the user's units exactly: in other ones, the model inside is the same.
    """
    n, m, k = model.sizes
    # Unknowns: logarithms of the units of time, states, measurements, and errors where not given.
    unit = np.eye(2 + n + m)
    T, x, y, e = unit[0], unit[1 : 1 + n], unit[1 + n : 1 + n + m], unit[-1]
    rows: list[np.ndarray] = []
    logs: list[float] = []

    def add(matrix: np.ndarray, row: Callable[[int, int], np.ndarray]) -> None:
        for i, j in np.argwhere(matrix):
            rows.append(row(i, j))
            logs.append(-float(np.log(abs(matrix[i, j]))))

    add(model.A, lambda i, j: T + x[j] - x[i])
    add(model.C, lambda i, j: x[j] - y[i])
    add(np.diag(np.diag(model.W)), lambda i, j: T - x[i] - x[j])
    add(np.diag(np.diag(model.V)), lambda i, j: -T - y[i] - y[j])
    if errors is None:
        add(model.M, lambda i, j: x[j] - e)
    else:
        add(model.M / errors[:, None], lambda i, j: x[j])
    matrix = np.array(rows)
    if model.discrete:
        matrix[:, 0] = 0.0
    found = np.exp(np.linalg.lstsq(matrix, np.array(logs))[0])
    own = np.full(k, found[-1]) if errors is None else errors
    return Units(float(found[0]), np.diag(found[1 : 1 + n]), found[1 + n : 1 + n + m], own)
