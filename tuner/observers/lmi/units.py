"""Coordinates that follow from a system: its own units, and those of a covariance."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from objectives.linear_systems.scaling import balance
from tuner.observers.lmi.design import Design

SMALLEST = 1e-8
"""Variances below this share of the largest count as none where coordinates are chosen."""


@dataclass(frozen=True)
class Scaled:
    """A design, and the same in coordinates of its own: x = states @ x inside, and so on.

    Attributes:
        outer: the design as it was given.
        time: unit of time, s; the sample time where the system is discrete.
        states: basis of the states, ``(n, n)``.
        measurements: unit of each, ``(m,)``.
        errors: unit of each error that counts, ``(k,)``.
    """

    outer: Design
    time: float
    states: np.ndarray
    measurements: np.ndarray
    errors: np.ndarray

    @cached_property
    def inner(self) -> Design:
        """The design in these coordinates."""
        system = self.outer.system.in_units(self.states, self.measurements, self.time)
        return Design(system, self.outer.M @ self.states / self.errors[:, None])

    @property
    def per(self) -> float:
        """The unit of poles and gains: that of time; 1 where they are of a sample."""
        return 1.0 if self.outer.system.discrete else self.time

    def gain(self, inside: np.ndarray) -> np.ndarray:
        """A gain of the inner design, for the outer one."""
        return np.asarray(self.states @ inside / self.measurements / self.per)

    def poles(self, inside: np.ndarray) -> np.ndarray:
        """Poles under a gain of the inner design, for the outer one."""
        return self.inner.system.poles(inside) / self.per

    def covariance(self, inside: np.ndarray) -> np.ndarray:
        """Covariance of the outer design's error under a gain of the inner one; all inf if none."""
        P = self.inner.covariance(inside)
        return np.asarray(self.states @ P @ self.states.T) if np.isfinite(P).all() else P

    def covariance_inside(self, outside: np.ndarray) -> np.ndarray:
        """A covariance of the outer states, for the inner ones."""
        return np.asarray(np.linalg.solve(self.states, np.linalg.solve(self.states, outside).T))

    def whitened(self, X: np.ndarray) -> "Scaled":
        """The same in coordinates in which a covariance X, given in these, is the identity.

        Directions without variance keep a share of the largest one.
        """
        values, vectors = np.linalg.eigh((X + X.T) / 2)
        root = np.sqrt(np.maximum(values, SMALLEST * max(values[-1], SMALLEST)))
        return replace(self, states=self.states @ (vectors * root))


def scaled(design: Design, errors: np.ndarray | None = None) -> Scaled:
    """A design in its own units.

    Args:
        design: the design.
        errors: units of the errors M e, ``(k,)``; without them, one for all that suits the system.
    """
    s, M = design.system, design.M
    fixed = np.ones(len(M)) if errors is None else errors
    own = balance(
        s.A, s.C, s.W, s.V, M / fixed[:, None],
        fixed_time=s.discrete, fixed_errors=errors is not None,
    )  # fmt: skip
    return Scaled(
        outer=design,
        time=s.dt or own.time,
        states=np.diag(own.states),
        measurements=own.measurements,
        errors=np.full(len(M), own.errors) if errors is None else errors,
    )
