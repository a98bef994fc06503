"""A traced filter as a graph of scalars."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from jax.extend.core import jaxpr_as_fun

from objectives.in_numpy import in_numpy
from tuner.code.fields import Field, halved
from tuner.code.graph import Graph
from tuner.code.interpreter import Arrays, objects
from tuner.code.literal import Precision
from tuner.code.primitives import interpreter
from tuner.code.trace import Traced

Label: TypeAlias = tuple[Any, tuple[int, ...], int]
"""Where a node was traced, its entry in the result, and the operation's number."""
_VIEWS = frozenset(
    [
        "reshape",
        "broadcast_in_dim",
        "transpose",
        "expand_dims",
        "squeeze",
        "slice",
        "stop_gradient",
        "copy",
        "pad",
        "convert_element_type",
        "select_and_gather_add",
        "concatenate",
        "stack",
        "unstack",
        "split",
        "gather",
    ]
)
"""Operations that only move values, and give them no name."""
_ROUNDING = 1e-2
"""Difference of the halves of a matrix, over its largest number, that no rounding makes."""


@dataclass(frozen=True, eq=False)
class Program:
    """A traced filter as a graph.

    Attributes:
        graph: of its step and its start.
        params, state, inputs, outputs: the fields.
        known: nodes of the input fields, by group.
        start: nodes of the state before the first sample.
        after: nodes of the state after a sample.
        out: nodes of the outputs.
        tunable: whether the parameters are adjustable, or constants.
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


def as_graph(traced: Traced, *, tunable: bool = False, most: int | None = None) -> Program:
    """The graph of a traced filter; loops within a step are unrolled.

    Symmetric matrices of the state are stored as halves: one assumed symmetric has to remain
    so in a step, so that by induction it always is.

    Args:
        traced: the filter.
        tunable: whether parameters are adjustable, or constants.
        most: limit of operations; None: none.

    Raises:
        TooLargeError: for more operations than that.
        ValueError: for an operation that has no counterpart.
    """
    first = interpreter(Graph()).closed(traced.start, traced.values)
    half = {f.name for f, x in zip(traced.state, first, strict=True) if _square(f) and _even(x)}
    if len(half) > 1:  # each that does not stay so takes a graph more
        half -= _uneven(traced, first)
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
    way = interpreter(graph, _labelling(graph, labels))
    state = halved(traced.state, half)
    params = traced.values
    if tunable:
        params = [_inputs(graph, "params", one) for one in traced.params]
    before = [_inputs(graph, "state", one) for one in state]
    inputs = [_inputs(graph, "in", one) for one in traced.inputs]
    start = objects(graph, way.closed(traced.start, params))
    found = objects(graph, way.closed(traced.step, [*params, *before, *inputs]))
    after, out = found[: len(state)], found[len(state) :]
    outputs = [
        Field(f.name, f.shape, f.kind, f.meaning, _square(f) and symmetric(graph, nodes))
        for f, nodes in zip(traced.outputs, out, strict=True)
    ]
    kept = [k for k, wanted in enumerate(traced.kept) if wanted]
    return Program(
        graph,
        traced.params,
        state,
        traced.inputs,
        [outputs[k] for k in kept],
        {"params": params if tunable else [], "state": before, "in": inputs},
        start,
        after,
        [out[k] for k in kept],
        tunable,
        traced.precision,
        labels,
    )


def _uneven(traced: Traced, first: Arrays) -> set[str]:
    """Matrices that are symmetric before a step, by other numbers, and not after it."""
    draw = np.random.default_rng(0)

    def moved(field: Field, near: np.ndarray) -> np.ndarray:
        if field.kind != "real":
            return np.asarray(near)
        by = draw.normal(size=field.shape)
        return np.asarray(near + (by + by.T if _square(field) else by), near.dtype)

    kinds = {"real": traced.dtype, "whole": np.int32, "truth": np.bool_}
    before = [moved(f, x) for f, x in zip(traced.state, first, strict=True)]
    inputs = [moved(f, np.zeros(f.shape, kinds[f.kind])) for f in traced.inputs]
    found = in_numpy(jaxpr_as_fun(traced.step), *traced.values, *before, *inputs)
    pairs = zip(traced.state, found[: len(before)], strict=True)
    return {f.name for f, x in pairs if _square(f) and _apart(np.asarray(x))}


def _apart(after: np.ndarray) -> bool:
    """Whether the halves of a matrix differ by more than rounding, where it has numbers."""
    size = np.abs(after).max()
    return bool(np.isfinite(size) and np.abs(after - after.T).max() > _ROUNDING * size)


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


def _labelling(graph: Graph, labels: dict[int, list[Label]]) -> Callable[[Any, Arrays], None]:
    count = itertools.count()

    def observer(equation: Any, found: Arrays) -> None:
        number = next(count)
        if equation.primitive.name in _VIEWS:
            return
        for array in found:
            if array.dtype == object:
                for index in np.ndindex(array.shape):
                    if graph.nodes[array[index]].args:
                        labels.setdefault(int(array[index]), []).append(
                            (equation.source_info, index, number)
                        )

    return observer
