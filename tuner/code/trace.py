"""A filter traced: its step and its start as a graph, with the fields of its structs."""

import itertools
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import jax
import numpy as np

from tuner.code.fields import Field, fields_of, halved
from tuner.code.graph import Graph
from tuner.code.literal import Precision
from tuner.code.primitives import walk
from tuner.code.walk import Arrays, objects

Label: TypeAlias = tuple[Any, tuple[int, ...], int]
"""Where a node was traced, which entry of the result it is, and the operation's number."""
LARGEST = 2000
"""A state of more numbers is refused: its covariance alone would fill a controller's memory."""
_VIEWS = frozenset(
    "reshape broadcast_in_dim transpose expand_dims squeeze slice stop_gradient copy pad "
    "convert_element_type select_and_gather_add concatenate stack unstack split gather".split()
)
"""What gives no name to what it moves."""


@dataclass(frozen=True, eq=False)
class Traced:
    """A filter's functions as JAX traced them, in the precision that they are for.

    Attributes:
        step: of parameters, state and inputs; then the next state and the outputs, flat.
        start: of parameters.
        values: of the parameters, flat.
        params, state, inputs, outputs: the fields.
        kept: which outputs are put out.
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


@dataclass(frozen=True, eq=False)
class Program:
    """A traced filter as a graph.

    Attributes:
        graph: of its step and its start.
        params, state, inputs, outputs: the fields.
        known: nodes of the fields that come in, by group.
        start: nodes of the state before the first sample.
        after: nodes of the state after a sample.
        out: nodes of the outputs.
        tunable: whether the parameters come in, or are numbers.
        labels: where each node was traced.
    """

    graph: Graph
    params: list[Field]
    state: list[Field]
    inputs: list[Field]
    outputs: list[Field]
    known: dict[str, Arrays]
    start: Arrays
    after: Arrays
    out: Arrays
    tunable: bool
    precision: Precision
    labels: dict[int, list[Label]] = field(default_factory=dict)


def traced(
    filter: Any,
    params: Any,
    sample: Any,
    precision: Precision = "double",
    keep: Collection[str] | None = None,
) -> Traced:
    """Trace a filter in the precision that it is for.

    Args:
        filter: the filter.
        params: its parameters.
        sample: its inputs at one sample.
        precision: of its real numbers.
        keep: names of the outputs that are put out; None: all.

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


def as_graph(traced: Traced, *, tunable: bool = False, most: int | None = None) -> Program:
    """The graph of a traced filter; loops within a step are unrolled.

    Symmetric matrices of the state are kept by halves: what is taken to be symmetric has to stay
    so by a step, so that by induction it always is.

    Args:
        traced: the filter.
        tunable: whether parameters come in, or are the numbers that they are.
        most: operations; None: any number.

    Raises:
        TooLargeError: for more operations than that.
        ValueError: for an operation that has no counterpart.
    """
    first = walk(Graph()).closed(traced.start, traced.values)
    half = {f.name for f, x in zip(traced.state, first, strict=True) if _square(f) and _even(x)}
    while True:
        program = _attempt(traced, half, tunable, most)
        states = zip(program.state, program.after, strict=True)
        wrong = {f.name for f, after in states if f.half and not symmetric(program.graph, after)}
        half -= wrong
        if not wrong:
            return program


def _attempt(traced: Traced, half: set[str], tunable: bool, most: int | None) -> Program:
    graph = Graph(traced.dtype, most=most)
    labels: dict[int, list[Label]] = {}
    way = walk(graph, _labelling(graph, labels))
    state = halved(traced.state, half)
    params = traced.values
    if tunable:
        params = [_inputs(graph, "params", one) for one in traced.params]
    before = [_inputs(graph, "state", one) for one in state]
    inputs = [_inputs(graph, "in", one) for one in traced.inputs]
    start = objects(graph, way.closed(traced.start, params))
    found = objects(graph, way.closed(traced.step, [*params, *before, *inputs]))
    after, out = found[: len(state)], found[len(state) :]
    told = [
        Field(f.name, f.shape, f.kind, f.meaning, _square(f) and symmetric(graph, nodes))
        for f, nodes in zip(traced.outputs, out, strict=True)
    ]
    kept = [k for k, wanted in enumerate(traced.kept) if wanted]
    return Program(
        graph,
        traced.params,
        state,
        traced.inputs,
        [told[k] for k in kept],
        {"params": params if tunable else [], "state": before, "in": inputs},
        start,
        after,
        [out[k] for k in kept],
        tunable,
        traced.precision,
        labels,
    )


def _square(field: Field) -> bool:
    return len(field.shape) == 2 and field.shape[0] == field.shape[1] > 1


def _even(start: np.ndarray) -> bool:
    return bool(np.allclose(start, start.T, rtol=1e-6, atol=0))


def symmetric(graph: Graph, nodes: np.ndarray) -> bool:
    """Whether a matrix of nodes is symmetric, but for rounding."""
    return all(
        graph.points.same(nodes[i, j], nodes[j, i]) for i in range(len(nodes)) for j in range(i)
    )


def _inputs(graph: Graph, group: str, field: Field) -> np.ndarray:
    out = np.empty(field.shape, object)
    for index in np.ndindex(field.shape):
        out[index] = graph.input((group, field.place(index)), field.kind)
    return out


def _labelling(
    graph: Graph, labels: dict[int, list[Label]]
) -> Callable[[Any, Arrays], None]:
    count = itertools.count()

    def told(equation: Any, found: Arrays) -> None:
        number = next(count)
        if equation.primitive.name in _VIEWS:
            return
        for array in found:
            if array.dtype == object:
                for index in np.ndindex(array.shape):
                    if graph.nodes[array[index]].args:
                        labels.setdefault(array[index], []).append((equation.source_info, index, number))

    return told
