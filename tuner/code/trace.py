"""A filter traced: its step and its start as a graph, with the fields of its structs."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from tuner.code.fields import Field, fields_of
from tuner.code.interpreter import Arrays
from tuner.code.literal import Precision

LARGEST = 2000
"""Most numbers of a state: a larger covariance alone would fill a controller's memory."""


@dataclass(frozen=True, eq=False)
class Traced:
    """A filter's traced functions, in the target's precision.

    Attributes:
        step: of parameters, state and inputs; then the next state and the outputs, flat.
        start: of parameters.
        values: of the parameters, flat.
        params, state, inputs, outputs: the fields.
        kept: which outputs are included.
        precision: the type of real numbers.
    """

    step: Any
    start: Any
    values: Arrays
    params: list[Field]
    state: list[Field]
    inputs: list[Field]
    outputs: list[Field]
    kept: list[bool]
    precision: Precision

    @property
    def dtype(self) -> type[np.floating]:
        """The type of real numbers."""
        return np.float64 if self.precision == "double" else np.float32


def traced(
    filter: Any,
    params: Any,
    sample: Any,
    precision: Precision = "double",
    keep: Collection[str] | None = None,
) -> Traced:
    """Trace a filter in the target's precision.

    Args:
        filter: the filter.
        params: its parameters.
        sample: its inputs at one sample.
        precision: of its real numbers.
        keep: names of the outputs to be included; None: all.

    Raises:
        ValueError: for a state that is too large.
    """
    dtype = np.float64 if precision == "double" else np.float32
    params, sample = in_precision(params, dtype), in_precision(sample, dtype)
    start, state = jax.make_jaxpr(filter.init, return_shape=True)(params)
    size = sum(int(np.prod(leaf.shape)) for leaf in jax.tree.leaves(state))
    if size > LARGEST:
        raise ValueError(
            f"the state of {type(filter).__name__} is {size} numbers, and C is written for at most "
            f"{LARGEST}; export the numbers alone, as json"
        )
    empty = jax.tree.map(lambda leaf: np.zeros(leaf.shape, leaf.dtype), state)
    empty = in_precision(empty, dtype)
    step, (_, outputs) = jax.make_jaxpr(filter.step, return_shape=True)(params, empty, sample)
    outs = fields_of(filter, "outputs", outputs)
    return Traced(
        step,
        start,
        [np.asarray(leaf) for leaf in jax.tree.leaves(params)],
        fields_of(filter, "params", params),
        fields_of(filter, "state", state),
        fields_of(filter, "inputs", sample),
        outs,
        [keep is None or one.name in keep for one in outs],
        precision,
    )


def in_precision(tree: Any, dtype: type[np.floating]) -> Any:
    """Arrays in a precision; whole numbers and truth values stay."""

    def one(leaf: Any) -> np.ndarray:
        array = np.asarray(leaf)
        with np.errstate(over="ignore"):
            return array.astype(dtype) if array.dtype.kind == "f" else array

    return jax.tree.map(one, tree)
