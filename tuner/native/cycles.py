"""When a processor has the numbers of a sample, where each waits for those before it."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TypeAlias

from tuner.code.expression import CALLS
from tuner.code.graph import Graph

Recursion: TypeAlias = Sequence[tuple[int, int]]
"""Nodes of each number of the state, before and after a sample."""
Times: TypeAlias = Mapping[int, int]
"""When each of some nodes is ready, in cycles."""

ADD, MULTIPLY, BOTH = 3, 3, 4
"""Cycles of a sum, of a product, and of a product that is added at once."""
_DIVIDE, _CALL, _OTHER = 13, 32, 1
LOADED = -1000
"""When a number is ready that no earlier sample is waited for."""
SUMS = ("add", "sub", "neg")
_SAMPLES = 4
"""Samples after which the numbers of the state become ready in their final order."""


def cycles(op: str) -> int:
    """How long an operation takes, on today's processors.

    >>> cycles("mul"), cycles("sin"), cycles("input")
    (3, 32, 0)
    """
    if op in ("constant", "input"):
        return 0
    if op in SUMS:
        return ADD
    if op == "mul":
        return MULTIPLY
    if op in ("div", "sqrt"):
        return _DIVIDE
    return _CALL if op in CALLS else _OTHER


def is_sum(graph: Graph, entry: int) -> bool:
    """Whether a node is a sum, a difference or a negative of real numbers."""
    node = graph.nodes[entry]
    return node.kind == "real" and node.op in SUMS


def factors(graph: Graph, order: Iterable[int], uses: Counter[int]) -> set[int]:
    """Products that can be multiplied as they are added: each is needed in one sum alone.

    Args:
        graph: of the nodes.
        order: those that are computed.
        uses: how often each of them is needed.
    """
    terms = {part for k in order if is_sum(graph, k) for part in graph.nodes[k].args}
    return {k for k in terms if uses[k] == 1 and graph.nodes[k].op == "mul"}


def carried_over(carried: Recursion, times: Callable[[Times], Times]) -> dict[int, int]:
    """When the numbers of the state are ready, once a recursion has gone on for some samples.

    The last of them is ready at 0: a sample begins when the one before it has all of them.

    Args:
        carried: the numbers of the state.
        times: when the nodes of a sample are ready, given when the numbers of the state are.
    """
    ready = dict.fromkeys((before for before, _ in carried), 0)
    for _ in range(_SAMPLES):
        found = times(ready)
        ends = {before: found.get(after, LOADED) for before, after in carried}
        last = max(ends.values(), default=0)
        ready = {before: max(LOADED, end - last) for before, end in ends.items()}
    return ready
