"""What has to be decided, and how, for a change of a constant to reach a result."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from tuner.code.decided import NOTHING, Decided, Facts
from tuner.code.graph import Graph
from tuner.code.mutants import CHANGE, Mutant
from tuner.code.operations import STEPPED

_ORDERS = ("lt", "le", "gt", "ge")


class Way(NamedTuple):
    """The way from a constant to the results.

    Attributes:
        needed: the decisions without which a change moves no result.
        turned: the operations that decide otherwise, where nothing else moves a result.
    """

    needed: Decided
    turned: frozenset[int]


class Ways:
    """The ways from constants to the results of a step.

    Args:
        graph: of the step.
        order: its nodes.
        roots: its results.
    """

    def __init__(self, graph: Graph, order: Sequence[int], roots: Sequence[int]) -> None:
        self._graph, self._roots = graph, roots
        self._users = users_of(graph, order)
        self._facts = Facts(graph, self._users)

    def way(self, one: Mutant) -> Way | None:
        """The way from a constant; None: a change reaches no result, whatever is decided.

        Where a node is not what it was, then one of its operands is not, and what chooses between
        its operands has chosen that one; a product with zero stays zero. Of several ways to a
        result counts what all have in common. All numbers are finite, or missing.
        """
        nodes = self._graph.nodes
        if self._scales_its_own_limit(one):
            return None
        found, moving, turned = dict[int, Decided](), set[int](), set[int]()
        for k in self._after(one.node):
            ways = list(self._own(one) if k == one.node else self._ways(k, found))
            if not ways:
                continue
            found[k] = frozenset.intersection(*ways)
            if k == one.node or not moving.isdisjoint(nodes[k].args):
                (turned if nodes[k].op in STEPPED else moving).add(k)
        ends = [found[root] for root in self._roots if root in found]
        needed = self._facts.closed(frozenset.intersection(*ends)) if ends else None
        if needed is None:
            return None
        smooth = any(root in moving for root in self._roots)
        return Way(needed, frozenset(() if smooth else turned))

    def for_each(self, order: Sequence[int]) -> dict[int, Decided]:
        """What has to be decided for each operation to matter, but for what it decides itself.

        Args:
            order: the nodes of the step.
        """
        found = dict.fromkeys(self._roots, NOTHING)
        for k in reversed(order):
            if k not in found:
                users = self._users[k]
                way = _common(way for user in users for way in self._on(found, k, user))
                if way is not None:
                    found[k] = way
        return found

    def _on(self, found: Mapping[int, Decided], k: int, user: int) -> Iterator[Decided]:
        """What is needed for each way of a node by one of the operations that use it."""
        for at, part in enumerate(self._graph.nodes[user].args):
            if part == k and user in found:
                way = self._through(found[user], user, at, {k: NOTHING})
                if way is not None:
                    yield way

    def _scales_its_own_limit(self, one: Mutant) -> bool:
        """Whether a number is only compared with a share of itself: its sign decides."""
        nodes = self._graph.nodes
        node, share = nodes[one.node], float(nodes[nodes[one.node].args[one.at]].value)
        own, users = {one.node, *node.args} - {node.args[one.at]}, self._users.get(one.node, ())
        if node.op != "mul" or not 0 < share * (1 + CHANGE) < 1:
            return False
        return one.node not in self._roots and all(
            nodes[k].op in _ORDERS and set(nodes[k].args) == own for k in users
        )

    def _after(self, first: int) -> list[int]:
        """The nodes that depend on one, itself included, in order."""
        seen, open_ = {first}, [first]
        while open_:
            more = [k for k in self._users.get(open_.pop(), ()) if k not in seen]
            seen.update(more)
            open_ += more
        return sorted(seen)

    def _own(self, one: Mutant) -> Iterator[Decided]:
        node, way = self._graph.nodes[one.node], NOTHING
        own = self._through(way, one.node, one.at, {node.args[one.at]: way})
        if own is not None:
            yield own

    def _ways(self, k: int, found: dict[int, Decided]) -> Iterator[Decided]:
        for at, part in enumerate(self._graph.nodes[k].args):
            if part in found:
                way = self._through(found[part], k, at, found)
                if way is not None:
                    yield way

    def _through(
        self, way: Decided, k: int, at: int, found: Mapping[int, Decided]
    ) -> Decided | None:
        """The way on by an operand of an operation; None: it ends there."""
        node = self._graph.nodes[k]
        if node.op == "choose" and at > 0:
            return self._facts.joined(way, node.args[0], at == 1)
        if len(node.args) == 2:
            other = node.args[1 - at]
            if node.op in ("and", "or") and other not in found:
                return self._facts.joined(way, other, node.op == "and")
            if node.op == "mul" or (node.op == "div" and at == 1):
                return self._unless_zero(way, other)
        return way

    def _unless_zero(self, way: Decided, k: int) -> Decided | None:
        """With what has to be decided for a factor that may be chosen to be zero not to be it."""
        node, found = self._graph.nodes[k], way
        if node.op == "choose":
            for at in (1, 2):
                if self._graph.is_constant(node.args[at], 0):
                    return self._facts.joined(way, node.args[0], at == 2)
            return way
        count = {"mul": 2, "neg": 1, "div": 1}.get(node.op, 0)
        for part in node.args[:count]:
            more = self._unless_zero(found, part)
            if more is None:
                return None
            found = more
        return found


def _common(ways: Iterator[Decided]) -> Decided | None:
    """What all of several ways need; None: there is none."""
    found = next(ways, None)
    while found:
        way = next(ways, None)
        if way is None:
            break
        found &= way
    return found


def users_of(graph: Graph, order: Sequence[int]) -> dict[int, list[int]]:
    """The operations that use each node."""
    found: dict[int, list[int]] = {}
    for k in order:
        for part in set(graph.nodes[k].args):
            found.setdefault(part, []).append(k)
    return found
