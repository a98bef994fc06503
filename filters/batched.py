"""Several records in one time loop, side by side."""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from filters.protocol import AnyFilter


@dataclass(frozen=True)
class Batched:
    """A filter on k records at once: every leaf of its parameters has the records as first axis.

    Inputs and outputs have time first and the records second, ``(N, k, ...)``; shorter records are
    padded, with a truth of NaN where they are over. The lanes share the processor's vectors.

    Attributes:
        filter: the filter.
    """

    filter: AnyFilter

    def init(self, params: Any) -> Any:
        """The states before the first sample."""
        return jax.vmap(self.filter.init)(params)

    def step(self, params: Any, state: Any, inputs: Any) -> tuple[Any, Any]:
        """Take one sample of every record."""
        stepped: tuple[Any, Any] = jax.vmap(self.filter.step)(params, state, inputs)
        return stepped


def shared(params: Any, count: int) -> Any:
    """Parameters that all of ``count`` records share, as :class:`Batched` takes them.

    >>> shared({"gain": jnp.ones(3)}, 2)["gain"].shape
    (2, 3)
    """
    return jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, (count, *jnp.shape(leaf))), params)
