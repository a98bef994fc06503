"""Statements in the order in which a processor can begin them.

It looks ahead by some hundred operations and begins whichever is ready. Where what others wait for
stands late, or all that is ready stands together, it has nothing to do most of the time. A compiler
mostly keeps the order in which statements are written, above all across branches.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from heapq import heappop, heappush
from typing import TypeAlias

from tuner.code.expression import CALLS
from tuner.code.graph import Graph
from tuner.native.cycles import (
    BOTH,
    LOADED,
    SUMS,
    Recursion,
    Times,
    carried_over,
    cycles,
    factors,
    is_sum,
)

MOST_LIVE = 20
"""Numbers that wait to be used; where there are more, some are used up first."""
_AT_ONCE = {"multiply": 2, "add": 2, "other": 3}
"""Operations of a kind that begin in one cycle."""
_AHEAD = -150
"""How far before the end of a sample the next one begins at most, in cycles."""
_MULTIPLIED = frozenset({"mul", "div", "sqrt", *CALLS})
_Item: TypeAlias = tuple[int, int]
"""An operation with when it should begin."""


def scheduled(
    graph: Graph, nodes: Sequence[int], carried: Recursion, ends: Iterable[int]
) -> list[int]:
    """Nodes in the order in which to compute them.

    Args:
        graph: of the nodes.
        nodes: those to compute, each after those that it depends on; all others are known.
        carried: the numbers of the state.
        ends: nodes that are needed at the end of a sample, besides the state after it.

    >>> graph = Graph()
    >>> x, u = graph.input(("s", 0)), graph.input(("u", 0))
    >>> square, root = graph.apply("mul", u, u), graph.apply("sqrt", x)
    >>> after = graph.apply("mul", root, square)
    >>> scheduled(graph, [square, root, after], [(x, after)], []) == [root, square, after]
    True
    """
    plan = _Plan(graph, nodes, carried, ends)
    return [k for unit in _Processor(plan).order() for k in plan.unit(unit)]


class _Plan:
    """A sample's operations; a product that is multiplied as it is added is part of its sum.

    Attributes:
        nodes: the operations, in an order in which they can be computed.
        operands: of each of them.
        users: of each of them, those that it is an operand of.
        left: number of its uses, the end of the sample included.
        ready: when the numbers of the state are ready.
        latest: when each operation has to begin, so that no sample is late.
    """

    def __init__(
        self, graph: Graph, nodes: Sequence[int], carried: Recursion, ends: Iterable[int]
    ) -> None:
        self._graph = graph
        kept = {*ends, *(after for _, after in carried)}
        self._product = self._products(nodes, kept)
        inner = set(self._product.values())
        self.nodes = [k for k in nodes if k not in inner]
        self.operands = {k: self._of(k) for k in self.nodes}
        self.users: dict[int, list[int]] = {k: [] for k in self.nodes}
        for k in self.nodes:
            for part in self.own(k):
                self.users[part].append(k)
        self.left = {k: len(users) + (k in kept) for k, users in self.users.items()}
        self.ready = carried_over(carried, self._times)
        self.latest = self._deadlines(carried)

    def unit(self, k: int) -> list[int]:
        """The nodes of an operation."""
        return [self._product[k], k] if k in self._product else [k]

    def own(self, k: int) -> list[int]:
        """The operands that are computed."""
        return [part for part in self.operands[k] if part in self.users]

    def cycles(self, k: int) -> int:
        """How long an operation takes."""
        return BOTH if k in self._product else cycles(self._graph.nodes[k].op)

    def kind(self, k: int) -> str:
        """The part of a processor that an operation takes."""
        op = self._graph.nodes[k].op
        if k in self._product or op in _MULTIPLIED:
            return "multiply"
        return "add" if op in SUMS else "other"

    def _products(self, nodes: Sequence[int], kept: set[int]) -> dict[int, int]:
        """The product of a sum, by sums; of two products one."""
        graph = self._graph
        uses = Counter(kept) + Counter(part for k in nodes for part in graph.nodes[k].args)
        some = factors(graph, nodes, uses).intersection(nodes)
        sums = [k for k in nodes if is_sum(graph, k)]
        return {k: part for k in sums for part in graph.nodes[k].args if part in some}

    def _of(self, k: int) -> list[int]:
        args, product = self._graph.nodes[k].args, self._product.get(k)
        if product is not None:
            args = (*self._graph.nodes[product].args, *(part for part in args if part != product))
        return list(dict.fromkeys(args))

    def _times(self, ready: Times) -> dict[int, int]:
        """When each operation is over, if it waits for its operands alone."""
        times = dict(ready)
        for k, parts in self.operands.items():
            begin = max((times.get(part, LOADED) for part in parts), default=LOADED)
            times[k] = begin + self.cycles(k)
        return times

    def _deadlines(self, carried: Recursion) -> dict[int, int]:
        times = self._times(self.ready)
        last = max((times.get(after, LOADED) for _, after in carried), default=0)
        due = {after: last + self.ready[before] for before, after in carried}
        found: dict[int, int] = {}
        for k in reversed(self.nodes):
            by = min((found[user] for user in self.users[k]), default=last)
            found[k] = min(by, due.get(k, last)) - self.cycles(k)
        return found


class _Processor:
    """A processor that begins operations, one after another.

    Of those that are ready it takes the one that has to begin first. Where many numbers wait it
    takes an operation that is the last use of one of them, ready or not.

    Attributes:
        time: the cycle.
        free: how many more of each kind begin in it.
        live: how many numbers wait.
        left: how often each number is still needed.
        missing: how many operands of an operation have not begun.
        begin: when its operands are ready, as far as they have begun.
        later: operations whose operands have begun, and are not ready yet.
        now: those whose operands are ready, by kind.
        possible: all of them; ending: those that are a last use.
    """

    def __init__(self, plan: _Plan) -> None:
        begin = min(plan.ready.values(), default=0)
        self.plan, self.time, self.live = plan, max(_AHEAD, begin), 0
        self.left, self.begun = dict(plan.left), set[int]()
        self.missing = {k: len(plan.own(k)) for k in plan.nodes}
        self.begin = {
            k: max((plan.ready.get(part, LOADED) for part in parts), default=LOADED)
            for k, parts in plan.operands.items()
        }
        self.free = dict(_AT_ONCE)
        self.now = {kind: list[_Item]() for kind in _AT_ONCE}
        self.later, self.possible, self.ending = list[_Item](), list[_Item](), list[_Item]()
        for k in plan.nodes:
            if not self.missing[k]:
                self._open(k)

    def order(self) -> list[int]:
        """The operations in the order in which it begins them."""
        found: list[int] = []
        while len(found) < len(self.plan.nodes):
            k = self._ending() if self.live >= MOST_LIVE else self._ready()
            self._start(k)
            found.append(k)
        return found

    def _ready(self) -> int:
        """The operation that has to begin first, of those that can now."""
        while True:
            while self.later and self.later[0][0] <= self.time:
                _, k = heappop(self.later)
                heappush(self.now[self.plan.kind(k)], (self.plan.latest[k], k))
            queues = [self.now[kind] for kind, free in self.free.items() if free]
            found = [item for queue in queues if (item := self._first(queue))]
            if found:
                return min(found)[1]
            self._tick()

    def _ending(self) -> int:
        """One that is the last use of a number; or else the one that can begin first."""
        item = self._first(self.ending) or self._first(self.possible)
        assert item is not None, "an operation waits for itself"
        if not self.free[self.plan.kind(item[1])]:
            self._tick()
        return item[1]

    def _first(self, queue: list[_Item]) -> _Item | None:
        """The first operation of a queue that has not begun."""
        while queue and queue[0][1] in self.begun:
            heappop(queue)
        return queue[0] if queue else None

    def _tick(self) -> None:
        self.time += 1
        self.free = dict(_AT_ONCE)

    def _start(self, k: int) -> None:
        """Begin an operation, after which others can."""
        self.begun.add(k)
        self.free[self.plan.kind(k)] -= 1
        for part in self.plan.own(k):
            self.left[part] -= 1
            self.live -= not self.left[part]
            if self.left[part] == 1:
                for user in self.plan.users[part]:
                    self._look(user)
        self.live += self.left[k] > 0
        done = max(self.time, self.begin[k]) + self.plan.cycles(k)
        for user in self.plan.users[k]:
            self.begin[user] = max(self.begin[user], done)
            self.missing[user] -= 1
            if not self.missing[user]:
                self._open(user)

    def _open(self, k: int) -> None:
        """Its operands are there, or under way."""
        heappush(self.later, (self.begin[k], k))
        heappush(self.possible, self._item(k))
        self._look(k)

    def _look(self, k: int) -> None:
        """Note an operation that is the last use of a number."""
        open_ = k not in self.begun and not self.missing[k]
        if open_ and any(self.left[part] == 1 for part in self.plan.own(k)):
            heappush(self.ending, self._item(k))

    def _item(self, k: int) -> "_Item":
        return max(self.begin[k], self.plan.latest[k]), k
