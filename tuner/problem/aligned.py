"""Records in memory as XLA reads it: where they lie, it does not copy them in every call."""

from typing import Any, TypeVar

import jax
import numpy as np

T = TypeVar("T")
_BYTES = 64
"""XLA reads arrays in place that begin at a multiple of so many bytes."""
_SMALL = 64 << 10
"""Arrays of fewer bytes are copied at once, by the calling thread: that costs nothing."""


def aligned(record: T) -> T:
    """A record whose large arrays begin where XLA reads them in place, without gaps.

    An array that begins elsewhere is copied in every evaluation, by another thread: the caller
    waits for it, and several callers wake each other on one processor. It is copied once here.

    Args:
        record: arrays, a pytree; those of XLA itself stay as they are.

    >>> both = np.zeros(20_001)
    >>> one, other = aligned((both, both[1:]))
    >>> one.ctypes.data % 64, other.ctypes.data % 64
    (0, 0)
    """
    leaves, tree = jax.tree.flatten(record)
    found = [_aligned(leaf) for leaf in leaves]
    same = all(one is leaf for one, leaf in zip(found, leaves, strict=True))
    return record if same else jax.tree.unflatten(tree, found)


def _aligned(leaf: Any) -> Any:
    if not isinstance(leaf, np.ndarray) or leaf.nbytes < _SMALL:
        return leaf
    if leaf.flags.c_contiguous and leaf.ctypes.data % _BYTES == 0:
        return leaf
    memory = np.empty(leaf.nbytes + _BYTES, np.uint8)
    begin = -memory.ctypes.data % _BYTES
    found = memory[begin : begin + leaf.nbytes].view(leaf.dtype).reshape(leaf.shape)
    found[...] = leaf
    return found
