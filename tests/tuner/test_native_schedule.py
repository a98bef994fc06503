"""Sums and statements in the order in which a processor can begin them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tuner.code.by_numpy import InNumPy
from tuner.code.graph import Graph
from tuner.native import schedule
from tuner.native.cycles import cycles
from tuner.native.earliest import earliest
from tuner.native.schedule import scheduled

SAMPLES = 40


def drawn(seed, size):
    """A graph of sums and products of two numbers of a state and three of a sample."""
    draw, graph = np.random.default_rng(seed), Graph()
    state = [graph.input(("s", k)) for k in range(2)]
    nodes = [*state, *(graph.input(("u", k)) for k in range(3))]
    for _ in range(size):
        op = draw.choice(["add", "sub", "mul", "neg"], p=[0.35, 0.2, 0.35, 0.1])
        chosen = draw.choice(len(nodes), 1 if op == "neg" else 2)
        nodes.append(graph.apply(str(op), *(nodes[k] for k in chosen)))
    return graph, [(state[0], nodes[-1]), (state[1], nodes[-2])]


def values(graph, roots):
    """The roots where each input is a random number of its own."""
    order = graph.reached(roots)
    numbers = {}
    for k in order:
        name = graph.nodes[k].value
        if graph.nodes[k].op == "input":
            numbers[k] = np.random.default_rng([ord(name[0][0]), name[1]]).uniform(0.5, 1.0, 3)
    found = InNumPy(graph, order, roots).values(numbers)
    return np.array([np.broadcast_to(found[root], 3) for root in roots])


def period(graph, carried):
    """Cycles from sample to sample, on a processor that begins all that is ready."""
    ready = {before: 0 for before, _ in carried}
    ends = []
    for _ in range(SAMPLES):
        times = dict(ready)
        for k in graph.reached([k for pair in carried for k in pair]):
            node = graph.nodes[k]
            if k not in times:
                begin = max((times[part] for part in node.args), default=-(10**9))
                times[k] = begin + cycles(node.op)
        ready = {before: times[after] for before, after in carried}
        ends.append(max(ready.values()))
    return (ends[-1] - ends[SAMPLES // 2]) / (SAMPLES - 1 - SAMPLES // 2)


@given(st.integers(0, 10**6), st.integers(2, 60))
@settings(max_examples=60, deadline=None)
def test_sums_in_order_are_the_same_sums(seed, size):
    graph, carried = drawn(seed, size)
    ends = [after for _, after in carried]
    new, known = earliest(graph, carried, [])
    np.testing.assert_allclose(
        values(new, [known[k] for k in ends]), values(graph, ends), rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("count", [3, 8, 20])
def test_a_long_sum_waits_for_its_last_term_alone(count):
    graph = Graph()
    x, total = graph.input(("s", 0)), graph.input(("u", 0))
    carried_by = graph.apply("mul", x, total)
    for k in range(count):
        total = graph.apply("add", total if k else carried_by, graph.input(("u", 1 + k)))
    carried = [(x, total)]
    new, known = earliest(graph, carried, [])
    again = [(known[x], known[total])]
    assert period(graph, carried) == 3 + 3 * count
    assert period(new, again) == 3 + 3


def test_what_is_subtracted_stays_subtracted():
    graph = Graph()
    a, b, c, d = (graph.input(("u", k)) for k in range(4))
    first = graph.apply("sub", graph.apply("mul", a, b), graph.apply("mul", c, d))
    found = graph.apply("neg", graph.apply("add", graph.apply("sub", first, a), d))
    new, known = earliest(graph, [], [found])
    np.testing.assert_allclose(values(new, [known[found]]), values(graph, [found]), rtol=1e-14)


@given(st.integers(0, 10**6), st.integers(2, 120), st.integers(1, 40))
@settings(max_examples=60, deadline=None)
def test_each_statement_comes_once_and_after_those_it_needs(seed, size, live):
    graph, carried = drawn(seed, size)
    nodes = [k for k in graph.reached(k for pair in carried for k in pair) if graph.nodes[k].args]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(schedule, "MOST_LIVE", live)
        found = scheduled(graph, nodes, carried, [])
    assert sorted(found) == nodes
    at = {k: place for place, k in enumerate(found)}
    needs = [(part, k) for k in nodes for part in graph.nodes[k].args if part in at]
    assert all(at[part] < at[k] for part, k in needs)


def in_turn(graph, order):
    """Cycles that a processor takes that begins two operations in one, and none before another."""
    done, now, begun = {}, 0, 0
    for k in order:
        ready = max((done.get(part, 0) for part in graph.nodes[k].args), default=0)
        if begun == 2 or ready > now:
            now, begun = max(now + (begun == 2), ready), 0
        begun += 1
        done[k] = now + cycles(graph.nodes[k].op)
    return max(done.values())


def test_independent_chains_are_taken_in_turns():
    graph, order, carried = Graph(), [], []
    for k in range(6):
        x = before = graph.input(("s", k))
        for _ in range(8):
            x = graph.apply("mul", x, graph.input(("u", k)))
            order.append(x)
        carried.append((before, x))
    found = scheduled(graph, order, carried, [])
    assert in_turn(graph, order) == 6 * 7 * 3 + 3
    assert in_turn(graph, found) == 8 * 3 + 2


def test_few_numbers_wait_where_registers_are_few(monkeypatch):
    graph, order = Graph(), []
    loaded = [graph.input(("u", k)) for k in range(60)]
    squares = [graph.apply("mul", x, x) for x in loaded]
    roots = [graph.apply("sqrt", x) for x in squares]
    order = [*squares, *roots]

    def most(found):
        left, waiting, peak = set(squares), set(), 0
        for k in found:
            waiting = waiting | {k} if k in left else waiting - set(graph.nodes[k].args)
            peak = max(peak, len(waiting))
        return peak

    assert most(order) == 60
    monkeypatch.setattr(schedule, "MOST_LIVE", 8)
    assert most(scheduled(graph, order, [], [])) == 8
