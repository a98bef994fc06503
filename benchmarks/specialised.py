"""Formulas where some decisions are known: whether a change of a constant leaves them the same."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import product
from typing import Literal, TypeAlias

import numpy as np

from benchmarks.identities import Identities
from tuner.code.array_functions import is_rounded
from tuner.code.array_step import Step
from tuner.code.graph import Graph
from tuner.code.mutants import CHANGE, Mutant
from tuner.code.needed import Way
from tuner.code.nodes import Node
from tuner.code.operations import COMPARE, Kind

Told: TypeAlias = Literal["same", "but for rounding"]
"""A change moves no result; or it does by rounding alone."""
_Written: TypeAlias = Mapping[int, int]
"""Nodes of the formulas where some decisions are known, by those of the step."""
_Facts: TypeAlias = frozenset[tuple[int, bool]]
_MOST_TURNED, _MOST_SPLIT, _NEAR = 3, 6, 6
"""Most comparisons that a constant may turn; conditions that cases are made of, and how many
operations before the constant they may be."""
_DOMAINS: Mapping[str, tuple[float, float]] = {
    "asin": (-1.0, 1.0),
    "acos": (-1.0, 1.0),
    "atanh": (-1.0, 1.0),
    "acosh": (1.0, np.inf),
    "sqrt": (0.0, np.inf),
    "log": (0.0, np.inf),
    "log1p": (-1.0, np.inf),
}
"""Where functions have a value: elsewhere they are NaN."""
_KEPT = frozenset(["choose", "pow", "convert", "eq", "ne", "lt", "le", "gt", "ge", "and", "or"])
"""Operations on NaN whose result may be another."""
_TYPES: Mapping[Kind, np.dtype] = {
    "real": np.dtype(float),
    "whole": np.dtype(int),
    "truth": np.dtype(bool),
}


class Specialised:
    """The formulas of a step, written again for known decisions.

    Args:
        step: the filter's.
    """

    def __init__(self, step: Step) -> None:
        self._step, self._nodes = step, step.graph.nodes
        self._graph = Graph(step.graph.precision, halves=False)
        self._identities = Identities(self._graph)
        self._plain = dict[_Facts, _Written]()

    def tells(self, one: Mutant, way: Way) -> Told | None:
        """What is proven of a change of a constant; None: nothing.

        Where what the change needs is decided as it needs it, the formulas with and without the
        change are the same; or they are in exact arithmetic, as where a sum that is multiplied by
        the constant is zero but for rounding. What a limit decides makes no difference, or none
        where a function that follows has no value beyond it; then only a number that is the limit
        itself remains, which rounding decides.

        Args:
            one: the constant.
            way: its way to the results.
        """
        if one.limit:
            return None
        after = self._step.after([one.node])
        facts = frozenset((k, truth) for k, truth in way.needed if k not in after)
        if way.turned:
            return self._turned(one, sorted(way.turned), facts)
        order = [k for k in self._step.order if k in after]
        told = self._changed(one, order, facts)
        conditions = self._conditions(one, after, facts) if told is None else []
        for k in conditions:
            cases = [self._changed(one, order, facts | {(k, truth)}) for truth in (True, False)]
            if all(cases):
                return "same" if cases == ["same", "same"] else "but for rounding"
        return told

    def _changed(self, one: Mutant, order: Sequence[int], facts: _Facts) -> Told | None:
        """The same of a change that is not to turn a decision."""
        plain, moved, told = self._written(facts), dict[int, int](), "same"
        for k in order:
            if k != one.node and moved.keys().isdisjoint(self._nodes[k].args):
                continue
            if (k, True) in facts or (k, False) in facts:
                continue
            given = [moved.get(part, plain[part]) for part in self._nodes[k].args]
            if k == one.node:
                given[one.at] = self._changed_constant(one)
            found = self._apply(self._nodes[k], given)
            if found == plain[k]:
                continue
            if self._identities.same(found, plain[k]):
                told = "but for rounding"
                continue
            moved[k] = found
        if not moved.keys().isdisjoint(self._step.roots):
            return None
        return "same" if told == "same" else "but for rounding"

    def _changed_constant(self, one: Mutant) -> int:
        number = float(self._nodes[self._nodes[one.node].args[one.at]].value)
        with np.errstate(over="ignore"):
            return self._graph.constant(number * (1 + CHANGE))

    def _conditions(self, one: Mutant, after: Collection[int], facts: _Facts) -> list[int]:
        """The unknown conditions of what is chosen close before a constant."""
        found, level = list[int](), {one.node}
        known = {k for k, _ in facts}
        for _ in range(_NEAR):
            for k in sorted(level):
                condition = self._nodes[k].args[0] if self._nodes[k].op == "choose" else None
                if condition is not None and condition not in {*known, *found, *after}:
                    found.append(condition)
            level = {part for k in level for part in self._nodes[k].args}
        return found[:_MOST_SPLIT]

    def _turned(self, one: Mutant, turned: Sequence[int], facts: _Facts) -> Told | None:
        """The same of a constant that only turns comparisons."""
        if len(turned) > _MOST_TURNED or any(self._nodes[k].op not in COMPARE for k in turned):
            return None
        cases = [facts | {*zip(turned, case, strict=True)} for case in _cases(len(turned))]
        told = self._alike([self._written(one) for one in cases])
        between = self._between(one) if told is None and turned == [one.node] else {}
        if told is None and between:
            told = self._alike([self._anew(case, between) for case in cases])
            return told and "but for rounding"
        return told

    def _alike(self, cases: Sequence[_Written]) -> Told | None:
        """Whether all results are the same in each case."""
        first, told = cases[0], "same"
        for other in cases[1:]:
            for root in self._step.roots:
                if first[root] != other[root]:
                    told = "but for rounding"
                    if not self._identities.same(first[root], other[root]):
                        return None
        return "same" if told == "same" else "but for rounding"

    def _between(self, one: Mutant) -> dict[int, list[tuple[float, float]]]:
        """Where numbers are whose comparison with a limit comes out otherwise by its change.

        Nothing where such a number may be the limit itself without rounding.
        """
        node = self._nodes[one.node]
        limit = float(self._nodes[node.args[one.at]].value)
        x, low, high = node.args[1 - one.at], *sorted((limit, limit * (1 + CHANGE)))
        found = {x: [(low, high)]}
        if self._nodes[x].op == "abs" and low > 0:
            (x,) = self._nodes[x].args
            found[x] = [(low, high), (-high, -low)]
        return found if is_rounded(self._nodes[x]) else {}

    def _written(self, facts: _Facts) -> _Written:
        if facts not in self._plain:
            self._plain[facts] = self._anew(facts, {})
        return self._plain[facts]

    def _anew(
        self, facts: _Facts, between: Mapping[int, Sequence[tuple[float, float]]]
    ) -> _Written:
        """All nodes, where these decisions are known, and that some numbers are between others."""
        known, found = dict(facts), dict[int, int]()
        for k in self._step.order:
            node = self._nodes[k]
            if k in known:
                found[k] = self._graph.constant(known[k])
            elif node.op == "constant":
                found[k] = self._graph.constant(node.value)
            elif node.op == "input":
                found[k] = self._graph.input(node.value, node.kind)
            else:
                given = [found[part] for part in node.args]
                places = {found[x]: ends for x, ends in between.items() if x in found}
                if node.op in _DOMAINS and _outside(_DOMAINS[node.op], places.get(given[0], ())):
                    found[k] = self._graph.constant(np.nan)
                else:
                    found[k] = self._apply(node, given)
        return found

    def _apply(self, node: Node, given: Sequence[int]) -> int:
        graph = self._graph
        if node.op == "choose":
            condition, yes, no = given
            return graph.choose(condition, no, yes)
        if node.op == "convert":
            return graph.convert(given[0], _TYPES[node.kind])
        if any(self._is_missing(k) for k in given):
            if node.op in COMPARE:
                return graph.constant(node.op == "ne")
            if node.op not in _KEPT and node.kind == "real":
                return graph.constant(np.nan)
        return graph.apply(node.op, *given)

    def _is_missing(self, k: int) -> bool:
        one = self._graph.nodes[k]
        return one.op == "constant" and one.kind == "real" and bool(np.isnan(one.value))


def _cases(count: int) -> Iterator[tuple[bool, ...]]:
    return product((True, False), repeat=count)


def _outside(domain: tuple[float, float], places: Sequence[tuple[float, float]]) -> bool:
    """Whether a number that is between some ends is where a function has no value."""
    least, most = domain
    return bool(places) and all(high <= least or low >= most for low, high in places)
