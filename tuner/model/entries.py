"""Numbers and expressions of a document as nodes: lists, matrices, and tables by name."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tuner.model.algebra import fold, names_in
from tuner.model.covariance import Covariance, Rows
from tuner.model.expression import ZERO, ExpressionError, Node, Number, parse
from tuner.model.findings import Findings, brief
from tuner.model.lines import Path
from tuner.names import unknown


@dataclass(frozen=True)
class Scope:
    """The names that an entry may contain.

    Attributes:
        kinds: the kind of each known name, in words.
        allowed: the kinds that an entry may contain.
    """

    kinds: Mapping[str, str]
    allowed: frozenset[str]


@dataclass
class Entries:
    """A reader of entries, which keeps each as it was written, for its units.

    Attributes:
        findings: where errors go.
        kinds: the kind of each known name, in words.
        written: the expressions as they were written, by node, before they were folded.
    """

    findings: Findings
    kinds: Mapping[str, str]
    written: dict[Path, Node] = field(default_factory=dict)

    def scope(self, *allowed: str) -> Scope:
        """The scope of names of some kinds."""
        return Scope(self.kinds, frozenset(allowed))

    def one(self, path: Path, value: Any, scope: Scope) -> Node:
        """A number or an expression; 0 where it is neither, which is an error."""
        if isinstance(value, int | float) and not isinstance(value, bool):
            found = _float(value)
            if math.isfinite(found):
                self.written[path] = Number(found)
                return Number(found)
            self.findings.add(path, f"is {brief(value)}; give a finite number")
            return ZERO
        if not isinstance(value, str):
            self.findings.add(path, f"is {brief(value)}; give a number, or an expression in quotes")
            return ZERO
        try:
            node = parse(value)
            self._check(path, node, scope)
            self.written[path] = node
            return fold(node)
        except ExpressionError as error:
            self.findings.add(path, str(error))
            return ZERO

    def _check(self, path: Path, node: Node, scope: Scope) -> None:
        for name in sorted(names_in(node)):
            kind = scope.kinds.get(name)
            if kind is None:
                known = [n for n, kind in scope.kinds.items() if kind in scope.allowed]
                self.findings.add(path, str(unknown("name", name, known)))
            elif kind not in scope.allowed:
                may = ", ".join(
                    sorted(f"{each}s" if each != "dt" else each for each in scope.allowed)
                )
                self.findings.add(
                    path, f"contains {name}, {_article(kind)}; it may contain numbers, {may}"
                )

    def vector(
        self, path: Path, value: Any, names: Sequence[str], scope: Scope, *, rest: Any = None
    ) -> tuple[Node, ...]:
        """One entry for each name: a list in their order, a table by name, or the one there is.

        Args:
            path: where it stands.
            value: what stands there.
            names: what the entries belong to.
            scope: the names that entries may hold.
            rest: what a table may leave out; None: nothing.
        """
        if isinstance(value, Mapping):
            self.findings.keys(path, value, names)
            lacking = [name for name in names if name not in value]
            if lacking and rest is None:
                self.findings.add(path, f"has no {', '.join(lacking)}; give an entry for each")
            return tuple(
                self.one((*path, name), value.get(name, rest or 0.0), scope) for name in names
            )
        if not isinstance(value, list):
            if len(names) == 1:
                return (self.one(path, value, scope),)
            self.findings.add(path, f"is {brief(value)}; give {_each(names)}")
            return (ZERO,) * len(names)
        if len(value) != len(names):
            self.findings.add(path, f"has the length {len(value)}; give {_each(names)}")
            return (ZERO,) * len(names)
        return tuple(self.one((*path, i), each, scope) for i, each in enumerate(value))

    def matrix(self, path: Path, value: Any, rows: int, columns: int | None, scope: Scope) -> Rows:
        """Rows of entries; a plain list is the one row or column that there is.

        Args:
            path: where it stands.
            value: what stands there.
            rows: required number.
            columns: required number; None: any, equal in all rows.
            scope: the names that entries may hold.
        """
        nothing = ((ZERO,) * (columns or 1),) * rows
        wanted = "1 row" if rows == 1 else f"{rows} rows"
        wanted += f" of {columns}" if columns else ""
        if not isinstance(value, list):
            value = [[value]]
        elif not any(isinstance(row, list) for row in value):
            value = [value] if rows == 1 else [[each] for each in value]
        if len(value) != rows or not all(isinstance(row, list) for row in value):
            self.findings.add(path, f"has the length {len(value)}; give {wanted}, one list each")
            return nothing
        width = columns or len(value[0])
        for i, row in enumerate(value):
            if len(row) != width or not row or width > 200:
                self.findings.add((*path, i), f"is a row of {len(row)}; give {wanted}")
                return nothing
        return tuple(
            tuple(self.one((*path, i, j), each, scope) for j, each in enumerate(row))
            for i, row in enumerate(value)
        )

    def covariance(
        self, path: Path, value: Any, names: Sequence[str], scope: Scope, *, rest: Any = None
    ) -> Covariance:
        """A covariance: one number for all, a list or table of variances, or the whole matrix.

        Args:
            path: where it stands.
            value: what stands there.
            names: what the variances belong to.
            scope: the names that entries may hold.
            rest: what a table may leave out; None: nothing.
        """
        if isinstance(value, list) and any(isinstance(row, list) for row in value):
            rows = self.matrix(path, value, len(names), len(names), scope)
            found = Covariance.of(rows)
            for i, j in np.ndindex(len(rows), len(rows)):
                if j < i and rows[i][j] != rows[j][i]:
                    fault = "differs from its mirror image; a covariance is symmetric"
                    self.findings.add((*path, i, j), fault)
        elif isinstance(value, list | Mapping):
            found = Covariance.diagonal(self.vector(path, value, names, scope, rest=rest))
        else:
            found = Covariance.diagonal([self.one(path, value, scope)] * len(names))
        for node in found.variances:
            if isinstance(node, Number) and node.value < 0:
                self.findings.add(path, f"has the variance {node.value:g}; it cannot be negative")
        return found


def _float(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _each(names: Sequence[str]) -> str:
    return f"one for each of {', '.join(names)}" if names else "none"


def _article(kind: str) -> str:
    return {"input": "an input", "dt": "the sample time"}.get(kind, f"a {kind}")
