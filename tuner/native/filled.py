"""The results of loops in C as trees of arrays."""

import ctypes
from math import prod
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import AnyFilter
from objectives import Data, Objective, is_fold

MEMORY = 7
"""Operations that take as long as storing a number of each sample and loading it again."""


def kept_of(filter: AnyFilter, objective: Objective, params: Any, data: Data) -> Any:
    """Shapes and types of the values kept of a sample."""
    state = jax.eval_shape(filter.init, params)
    one = jax.tree.map(lambda leaf: jax.ShapeDtypeStruct(leaf.shape[1:], leaf.dtype), data)
    if not is_fold(objective):
        return jax.eval_shape(filter.step, params, state, one.inputs)[1]

    def kept(params: Any, state: Any, sample: Data) -> Any:
        _, output = filter.step(params, state, sample.inputs)
        return objective.update(objective.init(), output, sample.truth)[1]

    return jax.eval_shape(kept, params, state, one)


def filled(
    shapes: Any, numbers: Array, before: tuple[int, ...], keeps: list[bool] | None = None
) -> Any:
    """A tree filled with numbers; zeros in leaves that are not kept."""
    leaves, tree = jax.tree.flatten(shapes)
    out, at = [], 0
    for k, leaf in enumerate(leaves):
        if keeps is not None and not keeps[k]:
            out.append(jnp.zeros((*before, *leaf.shape), leaf.dtype))
            continue
        part = numbers[..., at : at + prod(leaf.shape)]
        out.append(part.reshape(*before, *leaf.shape).astype(leaf.dtype))
        at += prod(leaf.shape)
    return jax.tree.unflatten(tree, out)


def address(array: np.ndarray) -> int:
    """The address of a contiguous array."""
    assert array.flags.c_contiguous
    if array.size and array.flags.writeable:  # in a third of the time
        return ctypes.addressof(ctypes.c_char.from_buffer(array.data))
    return array.ctypes.data
