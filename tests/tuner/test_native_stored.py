"""What a pass over a record stores: against every possible choice, and how it is fetched."""

import re
from itertools import chain, combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tuner.code.graph import Graph
from tuner.native.fetching import fetching
from tuner.native.stored import cheapest

STORED, QUICK, SLOW = 4, 1, 20
"""What it costs to store a number, and to compute one again: also by a quotient or a call."""


@st.composite
def graphs(draw: st.DrawFn) -> tuple[Graph, list[int]]:
    """A few operations on two numbers of a state, and those of them that are needed."""
    graph = Graph()
    nodes = [graph.input(("s", k)) for k in range(2)]
    for _ in range(draw(st.integers(1, 6))):
        x, y = draw(st.sampled_from(nodes)), draw(st.sampled_from(nodes))
        op = draw(st.sampled_from(["add", "mul", "div", "sqrt"]))
        nodes.append(graph.apply(op, *([x] if op == "sqrt" else [x, y])))
    nodes = [k for k in dict.fromkeys(nodes) if graph.nodes[k].op != "constant"]
    needed = draw(st.lists(st.sampled_from(nodes), min_size=1, max_size=3, unique=True))
    return graph, needed


def effort(graph: Graph, needed: list[int], stored: set[int]) -> float:
    """The cost of a choice; without end where an input that is not stored is needed."""
    again, ahead = set[int](), [k for k in needed if k not in stored]
    while ahead:
        k = ahead.pop()
        if k not in again:
            again.add(k)
            ahead += [part for part in graph.nodes[k].args if part not in stored]
    ops = [graph.nodes[k].op for k in again]
    if "input" in ops:
        return np.inf
    return STORED * len(stored) + sum(SLOW if op in ("div", "sqrt") else QUICK for op in ops)


@given(graphs())
def test_no_other_choice_costs_less(case: tuple[Graph, list[int]]) -> None:
    graph, needed = case
    free = {k for k, node in enumerate(graph.nodes) if node.op == "constant"}
    order = [k for k in graph.reached(needed) if k not in free]
    choices = chain.from_iterable(combinations(order, n) for n in range(len(order) + 1))
    without_constants = [k for k in needed if k not in free]
    least = min(
        effort(graph, without_constants, set(one) | free) - STORED * len(free) for one in choices
    )
    found = set(cheapest(graph, without_constants, free))
    assert effort(graph, without_constants, found | free) - STORED * len(free) == least


def test_what_is_free_is_not_stored() -> None:
    graph = Graph()
    x, u = graph.input(("s", 0)), graph.input(("u", 0))
    apart = graph.apply("sub", u, x)
    assert cheapest(graph, [u, apart], {u}) == [apart]
    assert cheapest(graph, [], {u}) == []


@pytest.mark.parametrize("stored", [0, 1, 8, 9, 210])
def test_each_line_of_a_sample_to_come_is_fetched_once(stored: int) -> None:
    statements = "a = 1;\nfor (;;) {\n    b = 2;\n}\nc = a\n    + 3;"
    text = fetching(statements, stored)
    fetched = [int(k) for k in re.findall(r"__builtin_prefetch\(ahead \+ (\d+)\);", text)]
    assert fetched == list(range(0, stored, 8))
    rest = [line for line in text.split("\n") if "ahead" not in line]
    assert "\n".join(rest) == statements


def test_fetches_lie_between_statements() -> None:
    lines = fetching("a = 1;\nfor (;;) {\n    b = 2;\n}\nc = a\n    + 3;", 24).split("\n")
    after = [lines[k + 1] for k, line in enumerate(lines) if "prefetch" in line]
    assert after == ["a = 1;", "for (;;) {", "c = a"]
