"""Constraints on a solution besides the parameters' own limits: a quantity below a bound."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from jax import Array

ALLOWED = 1e-6
"""A constraint is satisfied if its quantity exceeds the bound by less than this share of it."""


@dataclass(frozen=True)
class Constraint:
    """A quantity that may not exceed a bound.

    Attributes:
        name: its name in results, such as "variance".
        measure: like an objective: from a filter's outputs (without a filter, the parameters) and
            the truth to one number, differentiable.
        most: the bound.
        unit: of both.

    Raises:
        ValueError: where the bound is not finite.
    """

    name: str
    measure: Callable[[Any, Any], Array]
    most: float
    unit: str = ""

    def __post_init__(self) -> None:
        if not np.isfinite(self.most):
            raise ValueError(f"the bound of {self.name} must be finite, got {self.most:g}")

    def excess(self, measured: Array) -> Array:
        """Excess of a quantity over the bound, as a share of it; of 1 where the bound is 0."""
        return (measured - self.most) / (abs(self.most) or 1.0)
