"""A filter as C functions with loops, for matrices that are too large for flat code."""

from collections.abc import Sequence

import numpy as np

from tuner.code.block import Block
from tuner.code.fields import Field
from tuner.code.implementation import Implementation, declarations, defaults, step, unused
from tuner.code.literal import type_of
from tuner.code.loop_statements import LoopStatements
from tuner.code.memory import Held, Lazy, View, rows_first, view
from tuner.code.straight_line import Slot, straight_line, work
from tuner.code.tables import Tables
from tuner.code.trace import Traced


def looped(traced: Traced, stem: str, *, tunable: bool = False) -> Implementation:
    """A filter's functions.

    Args:
        traced: the filter.
        stem: prefix of its types and functions.
        tunable: whether its parameters are adjustable.

    Raises:
        ValueError: for an operation that has no counterpart.
    """
    outputs = [field for field, kept in zip(traced.outputs, traced.kept, strict=True) if kept]
    parts = [
        ("state", "The state of the filter between samples.", traced.state),
        ("input", "The inputs of a sample; NaN where a measurement is missing.", traced.inputs),
        ("output", "The outputs after a sample.", outputs),
    ]
    if tunable:
        parts.append(("params", "Its parameters.", traced.params))
    tables = Tables(stem, traced.precision)
    begun, _ = _function(traced, tables, "start", tunable)
    stepped, operations = _function(traced, tables, "step", tunable)
    more = f", const {stem}_params *params" if tunable else ""
    lines = [*tables.used([*begun, *stepped]), ""]
    if tunable:
        lines += defaults(stem, traced.precision, traced.params, traced.values)
        lines += [f"void {stem}_set({stem}_tables *tables, const {stem}_params *params)", "{"]
        lines += ["    tables->params = *params;", "}", ""]
    lines += [f"void {stem}_init({stem}_state *state{more})", "{", *begun, "}", ""]
    lines += [step(stem, tunable), "{", *stepped, "}"]
    member = f"{stem}_params params;" if tunable else None
    return Implementation(
        stem,
        traced.precision,
        traced.state,
        traced.inputs,
        outputs,
        traced.params if tunable else [],
        list(declarations(stem, traced.precision, parts, member)),
        lines,
        operations,
    )


def _function(traced: Traced, tables: Tables, which: str, tunable: bool) -> tuple[list[str], int]:
    """The body of init or of step, and its approximate number of operations."""
    state = [_place("state->", field) for field in traced.state]
    kept = [_place("out->", f) for f, k in zip(traced.outputs, traced.kept, strict=True) if k]
    ends = state if which == "start" else [*state, *kept]
    spare = {v.buffer: (int(np.prod(v.shape)), v.kind) for v in ends if not v.alone}
    block = Block(tables, spare)
    known: dict[Slot, Held] = {}
    given: list[Slot | np.ndarray] = [*traced.values]
    if tunable:
        where = "params->" if which == "start" else "tables->params."
        given = [*_slots(traced, where, traced.params, known)]
    if which == "start":
        code = straight_line(traced.start, given)
    else:
        given += _slots(traced, "state->", traced.state, known)
        given += _slots(traced, "in->", traced.inputs, known)
        wanted = [*range(len(state)), *(len(state) + k for k, w in enumerate(traced.kept) if w)]
        code = straight_line(traced.step, given, wanted)
    known = {slot: x for slot, x in known.items() if slot in code.uses}
    block.release(v.buffer for v in known.values() if isinstance(v, View))
    found = LoopStatements(block).run(code, known)
    put_all(block, found, ends)
    types = [
        f"    {type_of(kind, traced.precision)} {name}[{size}];"
        for name, (size, kind) in block.locals.items()
    ]
    names = ["state"] if which == "start" else ["state", "in", "out"]
    names += ["params" if which == "start" else "tables"] if tunable else []
    return [*types, *block.lines, *unused(block.lines, names)], work(code.operations)


def put_all(block: Block, found: Sequence[Held], ends: Sequence[View]) -> None:
    """Store results; none is overwritten before it is read."""
    block.keep_spare()
    places = {end.buffer for end in ends}
    ready: list[Held] = []
    for result, end in zip(found, ends, strict=True):
        x = result
        if isinstance(x, Lazy) and x.number is None and x.buffers:
            x = block.made(x)
        if isinstance(x, View) and x != end and x.buffer in places:
            away = block.buffer(x.shape or (1,), x.kind).buffer
            x = View(away, x.shape, x.kind, 0, rows_first(x.shape))
            block.put(result, x)
        ready.append(x)
    for x, end in zip(ready, ends, strict=True):
        if x != end:
            block.put(x, end)


def _slots(
    traced: Traced, group: str, fields: Sequence[Field], known: dict[Slot, Held]
) -> list[Slot]:
    dtypes = {"real": np.dtype(traced.dtype), "truth": np.dtype(bool), "whole": np.dtype(int)}
    slots = []
    for field in fields:
        slot = Slot(field.shape, dtypes[field.kind])
        known[slot] = _place(group, field)
        slots.append(slot)
    return slots


def _place(group: str, field: Field) -> View:
    return view(f"{group}{field.name}", field.shape, field.kind)
