"""Numbers that are compared: worked out by what they depend on alone."""

from types import SimpleNamespace

import numpy as np

from tuner.code.array_step import Step
from tuner.code.compared import Compared, ComparedNumbers, reaches
from tuner.code.graph import Graph

COUNT = 6


def several_chains():
    """A step of four sums of powers that share their first factor, and the last of each chain."""
    graph = Graph()
    x, y = graph.input(("in", "x")), graph.input(("in", "y"))
    common = graph.apply("mul", x, graph.apply("sin", y))
    ends = []
    for k in range(4):
        node = common
        for turn in range(k + 2):
            node = graph.apply("add", graph.apply("mul", node, x), graph.constant(1.5 + k + turn))
        ends.append(node)
    program = SimpleNamespace(graph=graph, state=[], after=[], outputs=[], out=[])
    step = Step(program)
    step.__dict__["roots"] = [graph.apply("add", ends[0], graph.apply("mul", ends[1], ends[2]))]
    step.__dict__["roots"].append(ends[3])
    return step, (x, y), ends


def test_each_pair_is_worked_out_in_its_own_steps():
    step, inputs, ends = several_chains()
    pairs = [
        Compared(0, ends[2], ends[0]),
        Compared(1, ends[3], 0.5),
        Compared(2, ends[0], ends[1]),
    ]
    pairs.append(pairs[0])
    draw = np.random.default_rng(0)
    for asked in (pairs, pairs[1:], pairs[::-1], pairs[:1]):
        given = {int(k): draw.normal(size=COUNT * len(asked)) for k in inputs}
        found = ComparedNumbers(step, pairs).in_own_steps(given, asked)
        whole = step.all_values(given)
        for at, pair in enumerate(asked):
            rows = slice(at * COUNT, (at + 1) * COUNT)
            for side, one in enumerate((pair.x, pair.limit)):
                right = whole[one][rows] if isinstance(one, int) else np.full(COUNT, one)
                assert found[side, rows].tolist() == right.tolist()


def test_what_a_number_depends_on_is_what_the_graph_says():
    step, _, ends = several_chains()
    found = reaches(step.graph, step.order, ends)
    for end in ends:
        assert found[end] == sum(1 << k for k in step.graph.reached([end]))


def test_pairs_that_share_little_are_worked_out_apart(monkeypatch):
    step, inputs, ends = several_chains()
    monkeypatch.setattr("tuner.code.compared._OVERHEAD", 0)
    asked = []
    made = step.part
    step.__dict__["part"] = lambda order, ends: asked.append(len(order)) or made(order, ends)
    given = {int(k): np.ones(2 * COUNT) for k in inputs}
    pairs = [Compared(k, ends[k], 1.0) for k in (0, 3)]
    ComparedNumbers(step, pairs).in_own_steps(given, pairs)
    assert asked == [len(step.graph.reached([end])) for end in (ends[0], ends[3])]


def test_what_changes_alone_is_worked_out_again():
    step, inputs, _ = several_chains()
    given = {int(k): np.linspace(0.5, 1.5, COUNT) for k in inputs}
    known = step.all_values(given)
    plain = [known[root] for root in step.roots]
    for lane, one in enumerate(step.mutants):
        rows = step.results(known, step.mutants)
        alone = step.results(known, [one])
        for whole, single, right in zip(rows, alone, plain, strict=True):
            mine = np.broadcast_to(whole, (len(step.mutants), COUNT))[lane]
            assert mine.tolist() == np.broadcast_to(single, (1, COUNT))[0].tolist()
            if single.ndim == 1:  # the constant is not before it
                assert single.tolist() == right.tolist()
