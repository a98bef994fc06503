"""Both passes over a record in C with loops over matrices, where scalars would be too many."""

from collections.abc import Iterable, Sequence
from math import prod
from typing import Any

import numpy as np

from tuner.code.block import Block
from tuner.code.bulk import BY_ENTRY
from tuner.code.filled_rows import FilledRows
from tuner.code.literal import type_of
from tuner.code.loop_statements import LoopStatements
from tuner.code.looped import put_all
from tuner.code.memory import Held, Index, View, rows_first
from tuner.code.operations import kind_of
from tuner.code.straight_line import (
    Atom,
    Operation,
    Slot,
    StraightLine,
    needed,
    straight_line,
    work,
)
from tuner.code.strides import MOVED
from tuner.code.tables import Tables
from tuner.compiler import LONG, options_of_rows
from tuner.native.even import Carried, even_slots, without_turns
from tuner.native.mirrored import mirrors
from tuner.native.passes_frame import APART, Around, Back, Code, Forth, Sizes, framed
from tuner.native.products import writers
from tuner.native.reversal import Before, traced
from tuner.native.runner import Runner, is_real

_ROWS = FilledRows(4)
"""To whole vector registers of most processors."""
_NOT_WRITTEN_OUT = '__attribute__((noinline, optimize("O2")))'
"""For the pass over the record: small loops are not written out, which makes it faster."""
_FEW = 16
"""Longest rows for which this is so."""
_AT_ONCE = 3
"""Operations on entries of a row that take the time of one."""


def array_passes(runner: Runner, before: Before) -> Code:
    """Both passes of a loop.

    Args:
        runner: the loop.
        before: what precedes it, by arrays.

    Raises:
        NoCounterpartError: names the operation that has no counterpart in loops.
    """
    return _Writer(_Arrays(runner, before)).code()


class _Arrays:
    """The arrays of a loop with its way back.

    Attributes:
        fixed: the varying arrays of the parameters.
        state, sample, weights, by_kept: what a sample begins with, its numbers, and the score's
            derivatives by the next state and by the kept values.
        after, kept: what it leaves behind.
        slopes: the derivatives by the varying arrays of the parameters; None where there are none.
        diagonal: which of these arrays vary on their diagonals alone.
        before: those by the state before the sample.
        operations: of both passes.
    """

    def __init__(self, runner: Runner, before: Before) -> None:
        varies = [place.size > 0 and place.max() >= 0 for place in before.places]
        self.state = [_slot(leaf) for leaf in before.start]
        self.sample = [_slot(leaf) for leaf in runner.sample]
        self.wanted = runner.wanted
        closed = traced(runner, before)
        count = len(before.start) + len(runner.keeps)
        kept = closed.out_avals[len(before.start) : count]
        fixed = [_slot(leaf) if v else leaf for leaf, v in zip(before.fixed, varies, strict=False)]
        by_kept = [
            _slot(leaf) if k else np.zeros(leaf.shape)
            for leaf, k in zip(kept, runner.keeps, strict=True)
            if is_real(leaf)
        ]
        self.fixed, self.by_kept = _slots(fixed), _slots(by_kept)
        self.weights = [_slot(leaf) for leaf in before.start if is_real(leaf)]
        self.real = [is_real(leaf) for leaf in before.start]
        given = [*fixed, *self.state, *self.sample, *self.weights, *by_kept]
        code = straight_line(closed, given)
        values = self._elsewhere(before, varies)
        carried = self._carried(before, code.results)
        self.even = even_slots(code.operations, carried, values)
        self.operations, results = without_turns(code.operations, code.results, carried, self.even)
        self.after = results[: len(before.start)]
        ends = zip(results[len(before.start) : count], runner.keeps, strict=True)
        self.kept = [atom for atom, wanted in ends if wanted]
        slopes = iter(results[count:])
        by_fixed = [next(slopes) if is_real(leaf) else None for leaf in before.fixed]
        self.slopes = [by for by, v in zip(by_fixed, varies, strict=False) if v]
        self.diagonal = [d for d, v in zip(before.diagonal, varies, strict=True) if v]
        self.before = list(slopes)

    def _elsewhere(self, before: Before, varies: Sequence[bool]) -> dict[Slot, np.ndarray]:
        """Values of what an iteration begins with, besides the state and its derivatives."""
        moving = (leaf for leaf, v in zip(before.elsewhere, varies, strict=False) if v)
        found = dict(zip(self.fixed, moving, strict=True))
        ones = {slot: np.ones(slot.shape, slot.dtype) for slot in (*self.sample, *self.by_kept)}
        return found | ones

    def _carried(self, before: Before, results: Sequence[Atom]) -> list[Carried]:
        """What an iteration hands to the next one, forwards and back."""
        starts = list(zip(before.start, before.even, strict=True))
        forth = zip(self.state, results, starts, strict=False)
        real = [(np.zeros_like(value), even) for value, even in starts if is_real(value)]
        back = zip(self.weights, results[len(results) - len(real) :], real, strict=True)
        return [Carried(slot, after, *start) for slot, after, start in (*forth, *back)]

    def passes(self) -> tuple[StraightLine, StraightLine, list[Slot]]:
        """The operations of both passes, and what is stored between them."""
        late = set(_slots([*self.weights, *self.by_kept]))
        back: list[Operation] = []
        for one in self.operations:
            if late.intersection(_slots(one.inputs)):
                late |= set(one.outputs)
                back.append(one)
        results = [atom for atom in [*self.slopes, *self.before] if atom is not None]
        wanted = {slot for one in back for slot in _slots(one.inputs)} | set(_slots(results))
        wanted -= late | {*self.fixed, *self.sample}
        again, ready = [], {*self.fixed, *self.sample}
        for one in self.operations:
            if late.isdisjoint(one.outputs) and _quick(one, ready):
                again.append(one)
                ready |= set(one.outputs)
        views: list[Operation] = []
        wanted -= ready
        for one in reversed(self.operations):
            if wanted.intersection(one.outputs) and one.name in MOVED:
                views.insert(0, one)
                wanted = wanted - set(one.outputs) | (set(_slots(one.inputs)) - ready)
        backwards = needed([*again, *views, *back], results)
        wanted &= set(backwards.uses)
        stored = [slot for slot in self._in_order() if slot in wanted]
        return needed(self.operations, [*self.after, *self.kept, *stored]), backwards, stored

    def _in_order(self) -> Iterable[Slot]:
        yield from self.state
        for one in self.operations:
            yield from one.outputs


class _Writer:
    def __init__(self, arrays: _Arrays) -> None:
        self.arrays = arrays
        self.forwards, self.backwards, self.stored = arrays.passes()
        self.longest = max((slot.shape[-1] for slot in arrays.state if slot.shape), default=1)
        self.tables = Tables("fixed", "double")

    def code(self) -> Code:
        """The C of both passes."""
        arrays = self.arrays
        sizes = Sizes(
            _size(arrays.state),
            _size(self.stored),
            _size(arrays.kept),
            _size(arrays.by_kept),
            _size(arrays.fixed),
        )
        forth, back, around = self._forth(), self._back(), self._around()
        lines = [forth.sample, back.sample, forth.stored, forth.kept, forth.after]
        functions = [*self.tables.used(lines), *mirrors(lines)]
        text = framed("\n".join(functions), sizes, forth, back, around)
        ends = [slot for slot, w in zip(arrays.state, arrays.wanted, strict=True) if w]
        operations = work([*self.forwards.operations, *self.backwards.operations]) // _AT_ONCE
        counts = sizes.carried, sizes.stored, _size(ends), sizes.kept, operations
        long = text.count("\n") > LONG
        return Code(text, *counts, options_of_rows(self.longest, long=long))

    def _forth(self) -> Forth:
        arrays = self.arrays
        block, found = self._run(
            self.forwards,
            [("p", arrays.fixed), ("state", arrays.state), ("u", arrays.sample)],
        )
        found = [_settled(block, x) for x in found]
        sample = _taken(block)
        count, kept = len(arrays.after), len(arrays.kept)
        for x, end in zip(found[count + kept :], _views("store", self.stored), strict=True):
            block.put(x, end)
        stored = _taken(block)
        for x, end in zip(found[count : count + kept], _views("kept", arrays.kept), strict=True):
            block.put(x, end)
        after = _taken(block)
        put_all(block, found[:count], _views("state", arrays.after))
        how = _NOT_WRITTEN_OUT if self.longest <= _FEW else APART
        return Forth(_locals(block), sample, stored, after, _taken(block), "", how)

    def _back(self) -> Back:
        arrays = self.arrays
        block, found = self._run(
            self.backwards,
            [
                ("p", arrays.fixed),
                ("u", arrays.sample),
                ("store", self.stored),
                ("weight", arrays.weights),
                ("v", arrays.by_kept),
            ],
        )
        found = [_settled(block, x) for x in found]
        results = iter(found)
        ends = zip(_views("slope", arrays.fixed), arrays.diagonal, strict=False)
        for by, (end, diagonal) in zip(arrays.slopes, ends, strict=True):
            if by is not None:
                _add(block, next(results), end, diagonal=diagonal)
        put_all(block, list(results), _views("weight", arrays.weights))
        return Back(_locals(block), _taken(block), "")

    def _run(
        self, code: StraightLine, memory: Sequence[tuple[str, Sequence[Slot]]]
    ) -> tuple[Block, list[Held]]:
        block = Block(self.tables, {}, _ROWS)
        block.depth = 0
        known: dict[Slot, Held] = {}
        for name, slots in memory:
            known |= zip(slots, _views(name, slots), strict=True)
        known = {slot: x for slot, x in known.items() if slot in code.uses}
        held = frozenset(name for name, _ in memory)
        return block, LoopStatements(block, held, writers(self.arrays.even)).run(code, known)

    def _around(self) -> Around:
        arrays = self.arrays
        first, count = _size(arrays.fixed), _size(arrays.state)
        state = f"double state[{count} + 1];\nmemcpy(state, p + {first}, {count} * sizeof *state);"
        total, weight, out = [], [f"double weight[{_size(arrays.weights)} + 1] = {{0}};"], []
        place = at = end = 0
        for slot, wanted, real in zip(arrays.state, arrays.wanted, arrays.real, strict=True):
            size = prod(slot.shape)
            if wanted:
                total.append(_copy(f"end + {end}", f"state + {place}", size))
            if real:
                if wanted:
                    weight.append(_copy(f"weight + {at}", f"e + {end}", size))
                out.append(_copy(f"out + {first + place}", f"weight + {at}", size))
                at += size
            place, end = place + size, end + size * wanted
        out.append(_copy("out", "slope", first))
        return Around(state, "\n".join(total), "\n".join(weight), "\n".join(out))


def _quick(one: Operation, ready: set[Slot]) -> bool:
    """Whether an operation takes little, and only what both passes have."""
    light = one.name in MOVED or one.name in BY_ENTRY
    return light and ready.issuperset(_slots(one.inputs))


def _settled(block: Block, x: Held) -> Held:
    """A result that no longer depends on what will be overwritten."""
    return x if isinstance(x, View) or not x.buffers else block.made(x)


def _add(block: Block, x: Held, into: View, *, diagonal: bool) -> None:
    """Add entries to those in memory: all of them, or a diagonal's."""

    def add(index: Index) -> None:
        block.say(f"{into.at(index)} += {x.at(index)};")

    if diagonal:
        block.loop(0, into.shape[0], lambda k: add([k, k]))
    else:
        block.nest(into.shape, add)


def _copy(into: str, source: str, size: int) -> str:
    return f"memcpy({into}, {source}, {size} * sizeof(double));"


def _taken(block: Block) -> str:
    """The statements so far, which the block no longer has."""
    lines, block.lines = block.lines, []
    return "\n".join(lines)


def _locals(block: Block) -> str:
    """Memory, with the entries behind an array that are read without effect."""
    beyond = block.tables.beyond
    begun = " = {0}" if beyond else ""
    return "\n".join(
        f"{type_of(kind, 'double')} {name}[{n + beyond}]{begun};"
        for name, (n, kind) in block.locals.items()
    )


def _views(name: str, atoms: Sequence[Atom]) -> list[View]:
    """Arrays one after another in memory."""
    found, base = [], 0
    for atom in atoms:
        strides = rows_first(atom.shape)
        found.append(View(name, atom.shape, kind_of(np.dtype(atom.dtype)), base, strides))
        base += prod(atom.shape)
    return found


def _slot(leaf: Any) -> Slot:
    return Slot(tuple(leaf.shape), np.dtype(leaf.dtype))


def _slots(atoms: Iterable[Atom]) -> list[Slot]:
    return [atom for atom in atoms if isinstance(atom, Slot)]


def _size(atoms: Sequence[Atom]) -> int:
    return sum(prod(atom.shape) for atom in atoms)
