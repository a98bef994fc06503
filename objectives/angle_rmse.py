"""Errors of angles over a whole record or a phase of it."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import jax.numpy as jnp
from jax import Array

from objectives.kinds import Kind
from objectives.squares import Squares


class HasAngles(Protocol):
    """Outputs of a filter for roll and pitch."""

    @property
    def angles(self) -> Array:
        """Rad, ``(..., k)``."""
        ...


@dataclass(frozen=True)
class AngleRmse:
    """Root of the mean square error of k angles together, deg: their squares are added.

    The truth is ``(N, k)``, or has the records in between, which then count as one long record;
    :class:`Records` takes the mean of the single records instead. Samples whose truth is NaN do not
    count: so a phase is scored (:func:`masked`). It sums in the time loop, and keeps nothing.
    """

    kind: ClassVar[Kind] = "root mean square"

    def init(self) -> Squares:
        """The empty sum."""
        return Squares.none()

    def added(self, output: HasAngles, truth: Array) -> tuple[Array, Array]:
        """The squares of a sample's angles, rad^2, 0 where it does not count; whether it counts."""
        missing = jnp.isnan(truth).any(axis=-1, keepdims=True)
        # Masked before it is squared: a NaN would reach the derivative.
        error = jnp.where(missing, 0.0, output.angles - jnp.where(missing, 0.0, truth))
        seen = jnp.broadcast_to(~missing[..., 0], error.shape[:-1])
        return (error**2).sum(axis=-1), seen

    def update(self, total: Squares, output: HasAngles, truth: Array) -> tuple[Squares, None]:
        """Add one sample."""
        return total.plus(*self.added(output, truth)), None

    def value(self, total: Squares, kept: None) -> Array:
        """The root mean square, ``()``; NaN where nothing counts."""
        return jnp.degrees(total.root_mean())

    def __call__(self, outputs: HasAngles, truth: Array) -> Array:
        """The same of stacked outputs."""
        return self.value(self.update(self.init(), outputs, truth)[0], None)
