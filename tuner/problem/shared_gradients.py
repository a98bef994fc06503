"""One program for the gradients of problems that tune other parameters of one filter."""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import AnyFilter
from objectives import Data, Objective, Way, score_and_gradient
from objectives.in_numpy import in_numpy
from tuner.problem.programs import Static
from tuner.stored_programs import QUICKLY, stored_jit


@dataclass(frozen=True)
class SharedGradients:
    """Gradients by a filter's parameters, which NumPy works out from a point, and their tangents.

    The program knows neither what is tuned nor how parameters follow from it: problems with equal
    ones of these, objectives of one kind and data of one shape share it.

    Attributes:
        filter: of the problem, or another that finds the same of the same parameters and data.
        tangents: that a gradient carries, at least one for each coordinate; the others are 0.
    """

    filter: AnyFilter
    tangents: int

    def value_and_gradient(
        self, static: Static, way: Way, z: np.ndarray, data: Data
    ) -> tuple[float, np.ndarray]:
        """The objective of a problem and its gradient at z ``(n,)``.

        Raises:
            ValueError: for fewer tangents than coordinates.
        """
        if self.tangents < z.size:
            raise ValueError(
                f"a gradient by {z.size} coordinates needs as many tangents, not {self.tangents}"
            )
        params, slopes = in_numpy(_Sloped(static, self.tangents), z)
        found = value_and_slopes_of(self.filter, static.objective, way, params, slopes, data)
        return float(found[0]), np.asarray(found[1])[: z.size]


@dataclass(frozen=True)
class _Sloped:
    """A filter's parameters at a point, and their derivatives by each coordinate, stacked first."""

    static: Static
    tangents: int

    def __call__(self, z: Array) -> tuple[Any, Any]:
        """Both; of the derivatives as many as there are tangents."""
        none = jnp.zeros((self.tangents - z.size, z.size))
        along = jax.vmap(lambda way: jax.jvp(self.static.built, (z,), (way,))[1])
        return self.static.built(z), along(jnp.concatenate([jnp.eye(z.size), none]))


@stored_jit(3, **QUICKLY)
def value_and_slopes_of(
    filter: AnyFilter, objective: Objective, way: Way, params: Any, slopes: Any, data: Data
) -> tuple[Array, Array]:
    """The objective of a filter's parameters, and its derivative along each tangent of them."""
    count = len(jax.tree.leaves(slopes)[0])

    def moved(by: Array) -> Any:
        return jax.tree.map(lambda p, slope: p + jnp.tensordot(by, slope, axes=1), params, slopes)

    return score_and_gradient(filter, objective, moved, jnp.zeros(count), data, way=way)
