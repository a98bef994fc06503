"""A filter run in a precision on a few samples, in a row or each from a state of its own."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from filters import run
from objectives.in_numpy import in_numpy
from tuner.code.states import Arrays
from tuner.code.trace import in_precision
from tuner.stored_programs import stored_jit

SAMPLES = 50
"""Number of samples."""
_FAST_COMPILATION = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}
"""Compiler options for a few samples, whose run takes less time than compilation."""


@dataclass(frozen=True)
class _Restarted:
    """A filter whose state before a sample may be given; its outputs hold the next one as well."""

    filter: Any

    def init(self, params: Any) -> Any:
        return self.filter.init(params)

    def step(self, params: Any, state: Any, inputs: Any) -> tuple[Any, Any]:
        sample, restart, given = inputs
        before = jax.tree.map(lambda new, own: jnp.where(restart, new, own), given, state)
        after, outputs = self.filter.step(params, before, sample)
        return after, (after, outputs)


@dataclass(frozen=True, eq=False)
class ReferenceFilter:
    """A filter with its parameters, run in a precision."""

    filter: Any
    params: Any
    dtype: type[np.floating]

    @cached_property
    def _start(self) -> Any:
        return jax.tree.map(
            np.asarray, in_numpy(self.filter.init, in_precision(self.params, self.dtype))
        )

    @property
    def start(self) -> Arrays:
        """The state before the first sample, flat, as real numbers."""
        return [np.asarray(leaf, self.dtype) for leaf in jax.tree.leaves(self._start)]

    def run(
        self, samples: Any, states: Arrays | None = None, begin: Arrays | None = None
    ) -> tuple[Arrays, Arrays]:
        """The state after each sample and the outputs, flat, as real numbers.

        Args:
            samples: time first.
            states: before each sample, a field each; None: samples follow one another.
            begin: the state before the first of them then; None: the filter's own.
        """
        count = len(jax.tree.leaves(samples)[0])
        leaves, tree = jax.tree.flatten(self._start)
        before = begin or leaves
        given = states or [np.broadcast_to(leaf, (count, *leaf.shape)) for leaf in before]
        as_they_are = [x.astype(leaf.dtype) for x, leaf in zip(given, leaves, strict=True)]
        restart = np.full(count, states is not None)
        restart[0] |= begin is not None
        rows = samples, restart, jax.tree.unflatten(tree, as_they_are)
        padded = jax.tree.map(lambda leaf: _padded(np.asarray(leaf), SAMPLES), rows)
        found = _run(
            _Restarted(self.filter),
            in_precision(self.params, self.dtype),
            in_precision(padded, self.dtype),
        )
        after, outputs = (
            [np.asarray(x, self.dtype)[:count] for x in jax.tree.leaves(part)] for part in found
        )
        return after, outputs

    def met(self, states: Arrays) -> Arrays:
        """The state before the first sample, and after each, in their own types."""
        leaves = jax.tree.leaves(self._start)
        return [
            np.concatenate([leaf[None], x.astype(leaf.dtype)])
            for leaf, x in zip(leaves, states, strict=True)
        ]


def _padded(rows: np.ndarray, count: int) -> np.ndarray:
    """Rows to a given number of them, so that one compilation serves all."""
    return np.concatenate([rows, np.repeat(rows[-1:], max(0, count - len(rows)), axis=0)])


@stored_jit(1, **_FAST_COMPILATION)
def _run(filter: Any, params: Any, samples: Any) -> Any:
    return run(filter, params, samples)[1]
