"""A traced function as a list of operations, with calls inlined and constants folded.

Loops remain. Unneeded operations are left out.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from jax.extend import core

from tuner.code.interpreter import aval_of, inner_of
from tuner.code.primitives import interpreter
from tuner.code.rearrangements import MOVES, PLACED
from tuner.code.refused import NoCounterpartError, check_type


@dataclass(frozen=True, eq=False)
class Slot:
    """A result that is known only at run time.

    Attributes:
        shape: of the array.
        dtype: of its entries.
    """

    shape: tuple[int, ...]
    dtype: np.dtype


Atom: TypeAlias = Slot | np.ndarray
"""A result, or numbers."""


@dataclass(frozen=True, eq=False)
class Operation:
    """One operation.

    Attributes:
        name: of JAX's primitive.
        equation: as JAX traced it, for its parameters.
        inputs: its operands.
        outputs: its results.
        source: where it was traced; None for functions that JAX caches across calls.
    """

    name: str
    equation: Any
    inputs: tuple[Atom, ...]
    outputs: tuple[Slot, ...]
    source: Any = None


@dataclass(frozen=True)
class StraightLine:
    """Operations in their order.

    Attributes:
        operations: the needed ones.
        results: of the function.
        last: number of the last operation that needs a slot; of results, one beyond all.
        uses: numbers of the operations that take a slot; one beyond all for each result.
    """

    operations: list[Operation]
    results: list[Atom]
    last: dict[Slot, int]
    uses: dict[Slot, list[int]]


def straight_line(
    closed: core.ClosedJaxpr, given: Sequence[Atom], wanted: Collection[int] | None = None
) -> StraightLine:
    """The operations of a traced function.

    Args:
        closed: the function.
        given: its operands.
        wanted: numbers of the results that are needed; None: all.
    """
    writer = _Writer()
    results = writer.closed(closed, given)
    kept = results if wanted is None else [results[k] for k in sorted(wanted)]
    return needed(writer.operations, kept)


def needed(operations: Sequence[Operation], results: list[Atom]) -> StraightLine:
    """The needed operations, and when each result is needed last."""
    live = {atom for atom in results if isinstance(atom, Slot)}
    kept: list[Operation] = []
    for operation in reversed(operations):
        if live.intersection(operation.outputs):
            live |= {atom for atom in operation.inputs if isinstance(atom, Slot)}
            kept.append(operation)
    kept.reverse()
    uses: dict[Slot, list[int]] = {}
    for number, operation in enumerate(kept):
        for atom in operation.inputs:
            if isinstance(atom, Slot):
                uses.setdefault(atom, []).append(number)
    for atom in results:
        if isinstance(atom, Slot):
            uses.setdefault(atom, []).append(len(kept))
    return StraightLine(kept, results, {slot: max(where) for slot, where in uses.items()}, uses)


def work(operations: Sequence[Operation]) -> int:
    """Approximate number of scalar operations; moves count as none."""
    total = 0
    for one in operations:
        params, size = one.equation.params, sum(math.prod(slot.shape) for slot in one.outputs)
        if one.name == "scan":
            slots = [Slot(v.aval.shape, v.aval.dtype) for v in params["jaxpr"].jaxpr.invars]
            total += params["length"] * work(straight_line(params["jaxpr"], slots).operations)
        elif one.name == "dot_general":
            axes, _ = params["dimension_numbers"]
            total += 2 * size * math.prod(one.inputs[0].shape[k] for k in axes[0])
        elif one.name.startswith("reduce_") and one.name != "reduce_precision":
            total += math.prod(one.inputs[0].shape)
        elif one.name not in MOVES and one.name not in PLACED:
            total += size
    return total


@dataclass
class _Writer:
    operations: list[Operation] = field(default_factory=list)
    remembered: bool = False

    def closed(self, closed: core.ClosedJaxpr, given: Sequence[Atom]) -> list[Atom]:
        known: dict[Any, Atom] = {}
        known.update(zip(closed.jaxpr.constvars, map(np.asarray, closed.consts), strict=True))
        known.update(zip(closed.jaxpr.invars, given, strict=True))

        def read(atom: Any) -> Atom:
            if isinstance(atom, core.Literal):
                return np.asarray(atom.val, aval_of(atom).dtype)
            return known[atom]

        for equation in closed.jaxpr.eqns:
            found = self._equation(equation, [read(atom) for atom in equation.invars])
            known.update(zip(equation.outvars, found, strict=True))
        return [read(atom) for atom in closed.jaxpr.outvars]

    def _equation(self, equation: Any, given: list[Atom]) -> list[Atom]:
        inner = inner_of(equation)
        if inner is not None:
            before, self.remembered = self.remembered, True
            found = self.closed(inner, given)
            self.remembered = before
            return found
        numbers = [atom for atom in given if isinstance(atom, np.ndarray)]
        if len(numbers) == len(given):
            return list(interpreter(_NO_ENTRIES).known(equation, numbers))
        for out in equation.outvars:
            check_type(equation.primitive.name, out.aval.dtype)
        if equation.primitive.name == "cond":
            return self._cond(equation, given)
        return self._write(equation.primitive.name, equation, given, equation.outvars)

    def _cond(self, equation: Any, given: list[Atom]) -> list[Atom]:
        branches = equation.params["branches"]
        if isinstance(given[0], np.ndarray):
            chosen = int(np.clip(given[0], 0, len(branches) - 1))
            return self.closed(branches[chosen], given[1:])
        if len(branches) != 2:
            raise NoCounterpartError("a switch of more than two ways has no counterpart in loops")
        no, yes = (self.closed(branch, given[1:]) for branch in branches)
        found: list[Atom] = []
        for one, other, out in zip(no, yes, equation.outvars, strict=True):
            found += self._write("select_n", equation, [given[0], one, other], [out])
        return found

    def _write(
        self, name: str, equation: Any, given: list[Atom], outs: Sequence[Any]
    ) -> list[Atom]:
        slots = tuple(Slot(tuple(out.aval.shape), np.dtype(out.aval.dtype)) for out in outs)
        source = None if self.remembered else equation.source_info
        self.operations.append(Operation(name, equation, tuple(given), slots, source))
        return list(slots)


_NO_ENTRIES: Any = None
