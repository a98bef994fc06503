"""Operations in order as statements with loops; a loop within a step remains one."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np
from jax.extend import core

from tuner.code.block import Block
from tuner.code.bulk import BY_ENTRY, SUMS, by_entry, product, summed
from tuner.code.memory import Held, Listed, View, rows_first, times, total
from tuner.code.operations import kind_of
from tuner.code.refused import no_counterpart
from tuner.code.straight_line import Atom, Operation, Slot, StraightLine, straight_line
from tuner.code.strides import JOINED, MOVED, SCATTERED, joined, moved, scattered
from tuner.code.written_out import written_out

SMALL = 32
"""Largest arrays of a loop whose body is written entry by entry."""
Writer: TypeAlias = Callable[[Block, Operation, list[Held]], Held]
"""A writer of one operation."""
_SIMPLE: tuple[tuple[frozenset[str], Writer], ...] = (
    (BY_ENTRY, by_entry),
    (frozenset(SUMS), summed),
    (frozenset({"dot_general"}), product),
    (JOINED, joined),
)
_STREAMED = BY_ENTRY | SUMS.keys()


class LoopStatements:
    """A writer of operations into a block.

    Args:
        block: the target.
        held: memory that is never free.
        writers: of operations that are written in another way than here, by their names.
    """

    def __init__(
        self,
        block: Block,
        held: frozenset[str] = frozenset(),
        writers: Mapping[str, Writer] | None = None,
    ) -> None:
        self.block, self.held, self.writers = block, held, writers or {}

    def run(self, code: StraightLine, known: Mapping[Slot, Held]) -> list[Held]:
        """The results of operations.

        Args:
            code: the operations.
            known: results so far.
        """
        values: dict[Slot, Held] = dict(known)
        for number, operation in enumerate(code.operations):
            values = {slot: x for slot, x in values.items() if code.last.get(slot, -1) >= number}
            later = _buffers(x for slot, x in values.items() if code.last[slot] > number)
            here = _buffers(values[a] for a in operation.inputs if isinstance(a, Slot))
            dying = here - later - self.held
            given = [self._held(atom, values) for atom in operation.inputs]
            begun = len(self.block.lines)
            found = self._operation(operation, given, dying, later | here | self.held)
            for slot, x in zip(operation.outputs, found, strict=True):
                if slot in code.uses:
                    values[slot] = self._kept(code, slot, x, dying)
            self.block.comment(operation.source, begun)
            alive = _buffers(x for slot, x in values.items() if code.last.get(slot, -1) > number)
            self.block.release(alive | self.held)
        return [self._held(atom, values) for atom in code.results]

    def _held(self, atom: Atom, values: Mapping[Slot, Held]) -> Held:
        return self.block.tables.read(atom) if isinstance(atom, np.ndarray) else values[atom]

    def _kept(self, code: StraightLine, slot: Slot, x: Held, dying: frozenset[str]) -> Held:
        """An expression that remains one where it is needed once, and elementwise."""
        if isinstance(x, View) or x.number is not None:
            return x
        where = code.uses[slot]
        once = x.shape and len(where) == 1 and where[0] < len(code.operations)
        if once and code.operations[where[0]].name in _STREAMED:
            return x
        return self.block.made(x, dying)

    def _operation(
        self,
        operation: Operation,
        given: list[Held],
        dying: frozenset[str],
        busy: frozenset[str],
    ) -> Sequence[Held]:
        name, block = operation.name, self.block
        if name in MOVED:
            return moved(block, operation, given)
        if name in SCATTERED:
            return [scattered(block, operation, given, dying)]
        if name == "scan":
            return self._scan(operation, given, busy)
        if name in self.writers:
            return [self.writers[name](block, operation, given)]
        for names, write in _SIMPLE:
            if name in names:
                return [write(block, operation, given)]
        raise no_counterpart(name)

    def _scan(
        self, operation: Operation, given: list[Held], busy: frozenset[str]
    ) -> Sequence[Held]:
        """A loop of its own, with the carry in memory; rows are read and written in turn."""
        block, params = self.block, operation.equation.params
        shared, carried, length = params["num_consts"], params["num_carry"], params["length"]
        given = [block.made(x) if x.buffers or k >= shared else x for k, x in enumerate(given)]
        consts, first, rows = (
            given[:shared],
            given[shared : shared + carried],
            given[shared + carried :],
        )
        carry = [block.buffer(x.shape or (1,), x.kind) for x in first]
        for x, into in zip(first, carry, strict=True):
            block.put(x, _like(into, x.shape))
        carry = [_like(into, x.shape) for into, x in zip(carry, first, strict=True)]
        stacked = [block.buffer(s.shape, kind_of(s.dtype)) for s in operation.outputs[carried:]]
        held = self.held | busy | _buffers([*carry, *stacked, *given])
        k = f"k{block.depth}"
        block.say(f"for (int {k} = 0; {k} < {length}; {k}++) {{")
        block.depth += 1
        at = f"{length - 1} - {k}" if params["reverse"] else k
        now = [_row(x, at) for x in rows if isinstance(x, View)]
        found = self._turn(params["jaxpr"], [*consts, *carry, *now], held)
        ends = [*carry, *(_row(y, at) for y in stacked)]
        self._end(found, ends, _buffers(carry))
        block.depth -= 1
        block.say("}")
        return [*carry, *stacked]

    def _end(
        self, found: Sequence[Held | Listed], ends: Sequence[View], moving: frozenset[str]
    ) -> None:
        """Store the results of an iteration; none is overwritten before it is read."""
        ready: list[Held | Listed] = []
        for x, into in zip(found, ends, strict=True):
            if isinstance(x, Listed) or x == into or not x.buffers & moving:
                ready.append(x)
                continue
            away = self.block.buffer(x.shape or (1,), x.kind)
            self.block.put(x, _like(away, x.shape))
            ready.append(_like(away, x.shape))
        for x, into in zip(ready, ends, strict=True):
            if isinstance(x, Listed):
                self.block.put_listed(x, into)
            elif x != into:
                self.block.put(x, into)

    def _turn(
        self, closed: core.ClosedJaxpr, given: list[Held], held: frozenset[str]
    ) -> Sequence[Held | Listed]:
        variables = (*closed.jaxpr.invars, *closed.jaxpr.outvars)
        if max((int(np.prod(v.aval.shape)) for v in variables), default=0) <= SMALL:
            return written_out(self.block, closed, given)
        slots = [Slot(v.aval.shape, np.dtype(v.aval.dtype)) for v in closed.jaxpr.invars]
        code = straight_line(closed, slots)
        return LoopStatements(self.block, held, self.writers).run(
            code, dict(zip(slots, given, strict=True))
        )


def _like(into: View, shape: tuple[int, ...]) -> View:
    return View(into.buffer, shape, into.kind, 0, rows_first(shape))


def _row(x: View, at: str) -> View:
    """The part of an array for one iteration."""
    start = total(x.base, times(x.strides[0], at))
    return View(x.buffer, x.shape[1:], x.kind, start, x.strides[1:])


def _buffers(arrays: Iterable[Held]) -> frozenset[str]:
    return frozenset[str]().union(*(x.buffers for x in arrays))
