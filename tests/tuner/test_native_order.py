"""What a compiled loop begins a sample ahead."""

from tuner.code.graph import Graph
from tuner.native.loop import Carried, Loop
from tuner.native.pipelining import pipelined


def gained(graph, addend):
    """A variance that is divided by a sum: p / (p + addend)."""
    variance = graph.input(("s", 0))
    after = graph.apply("div", variance, graph.apply("add", variance, addend))
    return Loop(graph, [Carried(variance, graph.constant(1.0), after)], [[variance]], [], 0)


def test_a_division_by_what_the_state_gives_begins_a_sample_ahead():
    graph = Graph()
    found = pipelined(gained(graph, graph.input(("p", 0))))
    quotient, variance = found.carried
    nodes = found.graph.nodes
    assert nodes[quotient.start].op == nodes[quotient.after].op == "div"
    assert variance.after == quotient.input
    assert nodes[quotient.after].args[0] == quotient.input
    assert found.total == [[variance.input]]


def test_a_division_by_what_the_next_sample_brings_does_not():
    graph = Graph()
    loop = gained(graph, graph.input(("u", 0)))
    assert pipelined(loop) is loop
