"""One number for several records."""

from dataclasses import dataclass
from typing import Any, Literal

import jax
import jax.numpy as jnp
from jax import Array

from objectives.score import Measure


@dataclass(frozen=True)
class Records:
    """An objective over records that run side by side (:class:`filters.Batched`).

    Attributes:
        measure: the objective of one record, a plain function of outputs and truth.
        weights: of the records, any positive numbers; equal ones if left out.
        over: the weighted mean, or the worst of the weighted values.
    """

    measure: Measure
    weights: tuple[float, ...] | None = None
    over: Literal["mean", "worst"] = "mean"

    def __call__(self, outputs: Any, truth: Any) -> Array:
        """One number, ``()``."""
        values = self.each(outputs, truth)
        weights = jnp.ones(len(values)) if self.weights is None else jnp.asarray(self.weights)
        if weights.shape != values.shape:
            raise ValueError(f"{len(weights)} weights for {len(values)} records; give one for each")
        if self.over == "worst":
            return jnp.max(weights * values)
        return weights @ values / weights.sum()

    def each(self, outputs: Any, truth: Any) -> Array:
        """The values of the single records, ``(k,)``."""
        return jax.vmap(self.measure, in_axes=1)(outputs, truth)
