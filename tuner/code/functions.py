"""A graph of a filter as functions of C: statement by statement, without loops."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from tuner.code.fields import Field
from tuner.code.flat import Statements, wrapped
from tuner.code.graph import Graph
from tuner.code.implementation import Implementation, declarations, defaults, step, unused
from tuner.code.interpreter import Arrays
from tuner.code.program import Program

Cells = list[tuple[str, int]]
"""Places in memory with the nodes to be stored there."""


def implementation(program: Program, stem: str, values: Arrays) -> Implementation:
    """A filter's functions.

    Args:
        program: the filter.
        stem: prefix of its types and functions.
        values: of its parameters, for ``defaults`` where it is tunable.
    """
    parts = [
        ("state", "The state of the filter between samples.", program.state),
        ("input", "The inputs of a sample; NaN where a measurement is missing.", program.inputs),
        ("output", "The outputs after a sample.", program.outputs),
    ]
    if program.tunable:
        parts.append(("params", "Its parameters.", program.params))
    step_cells = _step_cells(program)
    hoisted = _hoisted(program, [node for _, node in step_cells]) if program.tunable else []
    member = f"{program.precision} derived[{max(len(hoisted), 1)}];" if program.tunable else None
    head = declarations(stem, program.precision, parts, member)
    tables = {node: f"tables->derived[{k}]" for k, node in enumerate(hoisted)}
    lines = [*_tunable(program, stem, hoisted, values), *_init(program, stem), ""]
    body = _body(program, step_cells, tables)
    lines += [step(stem, program.tunable)]
    used = ("state", "in", "out", *(("tables",) if program.tunable else ()))
    lines += ["{", *body, *unused(body, used), "}"]
    live = program.graph.reached(node for _, node in step_cells)
    count = sum(program.graph.nodes[k].op not in ("constant", "input") for k in live)
    return Implementation(
        stem,
        program.precision,
        program.state,
        program.inputs,
        program.outputs,
        program.params if program.tunable else [],
        list(head),
        lines,
        count,
    )


def _tunable(program: Program, stem: str, hoisted: list[int], values: Arrays) -> Iterator[str]:
    if not program.tunable:
        return
    yield from defaults(stem, program.precision, program.params, values)
    yield f"void {stem}_set({stem}_tables *tables, const {stem}_params *params)"
    yield "{"
    places: Cells = [(f"tables->derived[{k}]", node) for k, node in enumerate(hoisted)]
    body = _body(program, places, {})
    yield from (*body, *unused(body, ("tables", "params")), "}", "")


def _init(program: Program, stem: str) -> Iterator[str]:
    more = f", const {stem}_params *params" if program.tunable else ""
    yield f"void {stem}_init({stem}_state *state{more})"
    yield "{"
    body = _body(program, list(_cells("state", program.state, program.start)), {})
    names = ("state", "params") if program.tunable else ("state",)
    yield from (*body, *unused(body, names), "}")


def _body(program: Program, cells: Cells, given: dict[int, str]) -> list[str]:
    """Statements that compute nodes, and then store them."""
    graph = program.graph
    made = Statements(graph, program.labels, program.precision, _reference, given)
    made.add(node for _, node in cells)
    ends = [wrapped(f"    {place} = {made.expressions.text(node)};") for place, node in cells]
    gap = [""] if made.lines and ends else []
    lines = made.lines[1:] if made.lines[:1] == [""] else made.lines
    return [*lines, *gap, *ends]


def _reference(value: Any) -> str:
    group, place = value
    return f"{group}->{place}"


def _step_cells(program: Program) -> Cells:
    """The next state and the outputs, without unchanged entries."""
    state = _cells("state", program.state, program.after)
    found = [
        (place, node)
        for place, node in state
        if program.graph.nodes[node].op != "input"
        or _reference(program.graph.nodes[node].value) != place
    ]
    return [*found, *_cells("out", program.outputs, program.out)]


def _cells(group: str, fields: Iterable[Field], nodes: Arrays) -> Iterator[tuple[str, int]]:
    for field, array in zip(fields, nodes, strict=True):
        for index in field.entries():
            yield f"{group}->{field.place(index)}", int(array[index])


def _hoisted(program: Program, roots: list[int]) -> list[int]:
    """Subexpressions of a step that depend on the parameters alone."""
    graph = program.graph
    alone = _of_parameters(graph)
    live = graph.reached(roots)
    edges = {k for entry in live if not alone[entry] for k in graph.nodes[entry].args}
    return sorted(
        k
        for k in edges | set(roots)
        if alone[k] and graph.nodes[k].op != "constant" and graph.nodes[k].kind == "real"
    )


def _of_parameters(graph: Graph) -> np.ndarray:
    alone = np.zeros(len(graph.nodes), bool)
    for k, node in enumerate(graph.nodes):
        if node.op == "input":
            alone[k] = node.value[0] == "params"
        else:
            alone[k] = all(alone[j] for j in node.args)
    return alone
