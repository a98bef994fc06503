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


@dataclass(frozen=True)
class Lanes:
    """A filter on k records at once, all with the same parameters.

    Inputs and outputs have time first and the records second, ``(N, k, ...)``; shorter records are
    padded with NaN.

    Attributes:
        filter: the filter.
        count: how many records, k.

    >>> from filters import Complementary, ComplementaryGain, AngleSample, run
    >>> two = Lanes(Complementary(dt=0.1), 2)
    >>> samples = AngleSample(jnp.zeros((5, 2)), jnp.ones((5, 2)))
    >>> run(two, ComplementaryGain(jnp.array(0.1), jnp.array(0.0)), samples)[1][0].tolist()
    [0.5, 0.5]
    """

    filter: AnyFilter
    count: int
    same_params = True

    def init(self, params: Any) -> Any:
        """The same start for every record."""
        start = self.filter.init(params)
        return jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, (self.count, *leaf.shape)), start)

    def step(self, params: Any, state: Any, inputs: Any) -> tuple[Any, Any]:
        """Take one sample of every record."""
        each = jax.vmap(self.filter.step, in_axes=(None, 0, 0))
        stepped: tuple[Any, Any] = each(params, state, inputs)
        return stepped
