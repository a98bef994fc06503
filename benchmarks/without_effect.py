"""Constants of a formula that have no effect on any result, whatever the state: by cases."""

import time
from collections.abc import Iterator, Sequence

import numpy as np

from tuner.code.array_step import Step
from tuner.code.graph import Graph
from tuner.code.mutants import Mutant
from tuner.code.operations import Kind

_SECONDS = 60.0
"""Processor time for one filter."""
_TYPES: dict[Kind, np.dtype] = {
    "real": np.dtype(float),
    "whole": np.dtype(int),
    "truth": np.dtype(bool),
}


def without_effect(step: Step, mutants: Sequence[Mutant]) -> set[Mutant]:
    """Those of these constants that no result depends on.

    Each becomes a variable. Where some condition of the step is taken as true, and again as false,
    the simplified formulas of all results have to be free of that variable: it is multiplied by
    zero, or not chosen. A product with zero is zero here, whatever the other factor is.
    """
    asked = {one: k for k, one in enumerate(mutants) if not one.limit}
    proven = set(asked) - _needed(step, asked, {})
    begun = time.process_time()
    for condition in _conditions(step, set(asked)):
        rest = {one: k for one, k in asked.items() if one not in proven}
        if not rest or time.process_time() - begun > _SECONDS:
            break
        either = _needed(step, rest, {condition: True})
        if either != set(rest):
            either |= _needed(step, rest, {condition: False})
        proven |= set(rest) - either
    return proven


def _conditions(step: Step, asked: set[Mutant]) -> Iterator[int]:
    """What decides between two numbers of which one depends on such a constant, nearest first."""
    nodes = step.graph.nodes
    distance: dict[int, int] = {one.node: 0 for one in asked}
    found: dict[int, int] = {}
    for k in step.order:
        near = [distance[part] for part in nodes[k].args if part in distance]
        if near:
            distance[k] = min([*near, distance.get(k, min(near) + 1) - 1]) + 1
        if nodes[k].op == "choose" and (k in distance):
            condition = nodes[k].args[0]
            found[condition] = min(found.get(condition, distance[k]), distance[k])
    yield from sorted(found, key=lambda k: (found[k], k))


def _needed(step: Step, asked: dict[Mutant, int], known: dict[int, bool]) -> set[Mutant]:
    """The constants that the results depend on, where the outcomes of some conditions are known."""
    old, new = step.graph, Graph(step.graph.precision)
    written: dict[int, int] = {}
    for k in step.order:
        node = old.nodes[k]
        if k in known:
            written[k] = new.constant(known[k])
        elif node.op == "constant":
            written[k] = new.constant(node.value)
        elif node.op == "input":
            written[k] = new.input(node.value, node.kind)
        else:
            args = [
                new.input(("changed", asked[Mutant(k, at)]))
                if Mutant(k, at) in asked
                else written[part]
                for at, part in enumerate(node.args)
            ]
            if node.op == "choose":
                written[k] = new.choose(args[0], args[2], args[1])
            elif node.op == "convert":
                written[k] = new.convert(args[0], _TYPES[node.kind])
            else:
                written[k] = new.apply(node.op, *args)
    names = {new.nodes[k].value for k in new.reached(written[root] for root in step.roots)}
    return {one for one, k in asked.items() if ("changed", k) in names}
