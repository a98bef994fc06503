"""Errors of any output, by the name of its channel."""

from dataclasses import dataclass
from math import pi
from typing import Any, ClassVar, Literal

import jax.numpy as jnp
from jax import Array

from filters import channel_facts
from filters.declared import declaration
from objectives.kinds import Kind
from objectives.squares import Squares


@dataclass(frozen=True)
class ChannelRmse:
    """Root mean square error of one output of a filter, in the output's unit.

    The truth has the output's shape, time first; records side by side count as one long record. A
    number whose truth is NaN does not count. The squares of a vector's parts are added. It sums in
    the time loop, and keeps nothing.

    Attributes:
        name: of the output; ``""``: the outputs are one array themselves.
        error: ``"number"``: by difference; ``"angle"``: in rad, by difference within half a turn.
        parts: of the vector; 1 for a single number.

    Raises:
        ValueError: for another kind, for parts below 1, for outputs without that name, and for a
            truth of another shape.

    >>> error = ChannelRmse("", "angle")
    >>> round(float(error(jnp.array([3.1, 0.0]), jnp.array([3.1 - 2 * pi, jnp.nan]))), 12)
    0.0
    """

    name: str
    error: Literal["number", "angle"] = "number"
    parts: int = 1

    kind: ClassVar[Kind] = "root mean square"

    def __post_init__(self) -> None:
        if self.error not in ("number", "angle"):
            raise ValueError(
                f"ChannelRmse: {self.name!r} is of kind {self.error!r}; it takes a number or an "
                "angle, AttitudeRmse takes an attitude, and a detail has no truth"
            )
        if self.parts < 1:
            raise ValueError(f"ChannelRmse: {self.name!r} has {self.parts} parts; give 1 or more")

    @classmethod
    def of(cls, filter: Any, name: str) -> "ChannelRmse":
        """The error of an output as a filter, or its class, declares it.

        Raises:
            ValueError: for a name that is none of its outputs, or an output of another kind.
        """
        facts = channel_facts(filter, "outputs")
        if name not in facts:
            there = ", ".join(facts)
            raise ValueError(f"ChannelRmse: {name!r} is not among the outputs; there are: {there}")
        alone = not isinstance(declaration(filter, "outputs"), type)
        kind: Any = facts[name].kind  # another one is refused as it is made
        return cls("" if alone else name, kind, max(1, len(facts[name].axes)))

    def init(self) -> Squares:
        """The empty sum."""
        return Squares.none()

    def added(self, output: Any, truth: Array) -> tuple[Array, Array]:
        """The square of each number's error, 0 where it does not count, and whether it counts."""
        estimate = self._named(output)
        if estimate.shape != truth.shape:
            raise ValueError(
                f"ChannelRmse: {self.name!r} has the shape {estimate.shape} and its truth "
                f"{truth.shape}; give a truth for every number"
            )
        seen = ~jnp.isnan(truth)
        # Masked before it is squared: a NaN would reach the derivative.
        error = jnp.where(seen, estimate - jnp.where(seen, truth, 0.0), 0.0)
        if self.error == "angle":
            error = error - 2 * pi * jnp.round(error / (2 * pi))
        return error**2, seen

    def update(self, total: Squares, output: Any, truth: Array) -> tuple[Squares, None]:
        """Add one sample."""
        return total.plus(*self.added(output, truth)), None

    def value(self, total: Squares, kept: None) -> Array:
        """The root mean square, ``()``; NaN where nothing counts."""
        return jnp.sqrt(float(self.parts)) * total.root_mean()

    def __call__(self, outputs: Any, truth: Array) -> Array:
        """The same of stacked outputs."""
        return self.value(self.update(self.init(), outputs, truth)[0], None)

    def _named(self, outputs: Any) -> Array:
        if self.name and not hasattr(outputs, self.name):
            raise ValueError(
                f"ChannelRmse: {type(outputs).__name__} has no output {self.name!r}; give the name "
                'of one, or "" where the outputs are one array'
            )
        found: Array = getattr(outputs, self.name) if self.name else outputs
        return found


@dataclass(frozen=True)
class InnovationRmse:
    """Root mean square of a filter's innovations, a number, in their unit.

    The outputs need ``innovation``, ``(m,)``. A number counts where the truth, ``(m,)`` or one for
    all, is not NaN, and where the filter outputs a ``variance`` that is not 0 if it outputs one.
    """

    kind: ClassVar[Kind] = "root mean square"

    def init(self) -> Squares:
        """The empty sum."""
        return Squares.none()

    def added(self, output: Any, truth: Array) -> tuple[Array, Array]:
        """The square of each number, 0 where it does not count, and whether it counts."""
        seen = jnp.broadcast_to(~jnp.isnan(truth), output.innovation.shape)
        if hasattr(output, "variance"):
            seen = seen & (output.variance != 0)
        return jnp.where(seen, output.innovation, 0.0) ** 2, seen

    def update(self, total: Squares, output: Any, truth: Array) -> tuple[Squares, None]:
        """Add one sample."""
        return total.plus(*self.added(output, truth)), None

    def value(self, total: Squares, kept: None) -> Array:
        """The root mean square, ``()``; NaN where nothing counts."""
        return total.root_mean()
