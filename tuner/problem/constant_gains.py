"""Whether a long record is worth the short way of filters whose gains settle."""

from functools import partial
from typing import Any

import jax
import numpy as np
from jax import Array

from filters import LinearKalman, Settling, bare, summed
from objectives import Data, InnovationLikelihood
from tuner.native.wanted import Static

WORTH = 2e6
"""Samples times (2 + n) squared, for n states, from which compiling it takes less than it saves."""
LEAST = 0.5
"""Share of the samples that have to be taken the short way at the start of a search."""


def share_of_constant_gains(
    static: Static, z: np.ndarray, data: Data, *, wanted: bool = False
) -> float:
    """Share of a record that a filter's likelihood takes the short way; 0 where it does not pay.

    Args:
        static: of the problem.
        z: the point, ``(n,)``, at which a search begins.
        data: of the problem.
        wanted: whether it is taken where it does not pay, too.
    """
    inner = bare(static.filter)
    linear = isinstance(inner, LinearKalman) or hasattr(inner, "linear")
    if not linear or not isinstance(static.objective, InnovationLikelihood):
        return 0.0
    samples = data.samples
    if not wanted and samples * (2 + _states(static, z)) ** 2 < WORTH:
        return 0.0
    share = float(_short(static, z, data)) / samples
    return share if wanted or share >= LEAST else 0.0


def _states(static: Static, z: np.ndarray) -> int:
    """Length of the longest array in the filter's state."""
    filter: Any = static.filter
    state = jax.eval_shape(lambda z: filter.init(static.built(z)), z)
    return max(leaf.shape[-1] if leaf.ndim else 1 for leaf in jax.tree.leaves(state))


@partial(
    jax.jit, static_argnums=0, compiler_options={"xla_backend_optimization_level": 0}
)  # it runs once
def _short(static: Static, z: Any, data: Data) -> Array | int:
    """Number of samples that are taken the short way."""
    objective: Any = static.objective
    filter: Any = static.filter
    found = summed(Settling(filter), static.built(z), data, objective.added)
    return 0 if found is None else found[1]
