"""Operations on whole arrays as loops: elementwise ones, sums, products, and moves."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from tuner.code.block import Block
from tuner.code.literal import type_of
from tuner.code.memory import Held, Index, Lazy, View
from tuner.code.operations import BINARY, UNARY, kind_of
from tuner.code.primitives import RULES
from tuner.code.straight_line import Operation
from tuner.code.texts import Text, Texts

BY_ENTRY = frozenset(
    {*UNARY, *BINARY, "add_any", "square", "rsqrt", "logistic", "select_n", "clamp", "sign"}
    | {"convert_element_type", "integer_pow"}
)
"""Elementwise operations."""
_TWICE = frozenset(
    ["square", "integer_pow", "sign", "clamp", "max", "min", "select_n", "ne", "abs", "logistic"]
)
"""Of these, those that use an entry twice, or must take the same time whatever its value."""
SUMS: Mapping[str, tuple[str, str]] = {
    "reduce_sum": ("0", "add"),
    "reduce_prod": ("1", "mul"),
    "reduce_max": ("-INFINITY", "max"),
    "reduce_min": ("INFINITY", "min"),
    "reduce_and": ("true", "and"),
    "reduce_or": ("false", "or"),
}


def by_entry(block: Block, operation: Operation, given: Sequence[Held]) -> Lazy:
    """An elementwise operation as an expression."""
    out, algebra = operation.outputs[0], Texts(block.precision)
    rule, twice = RULES[operation.name], operation.name in _TWICE

    def at(index: Index) -> str:
        entries = []
        for x in given:
            text = x.at([0 if n == 1 else k for k, n in zip(index, x.shape, strict=False)])
            number = x.number if isinstance(x, Lazy) else None
            if twice and number is None:
                text = block.simple(text, x.kind)
            entry = np.empty((), object)
            entry[()] = Text(text, x.kind, number)
            entries.append(entry)
        (found,) = rule(algebra, operation.equation, entries)
        made: Text = found.item()
        return made.text

    buffers = frozenset[str]().union(*(x.buffers for x in given))
    return Lazy(out.shape, kind_of(out.dtype), at, buffers)


def summed(block: Block, operation: Operation, given: Sequence[Held]) -> View:
    """An array reduced along some axes."""
    (x,), axes = given, operation.equation.params["axes"]
    kept = [k for k in range(len(x.shape)) if k not in axes]
    inner = [x.shape[k] for k in axes]

    def term(outer: Index, index: Index) -> str:
        whole = [
            outer[kept.index(k)] if k in kept else index[axes.index(k)] for k in range(len(x.shape))
        ]
        return x.at(whole)

    return _accumulated(block, operation, inner, SUMS[operation.name], term)


def product(block: Block, operation: Operation, given: Sequence[Held]) -> View:
    """A product of arrays."""
    x, y = (block.made(one) if isinstance(one, Lazy) and one.buffers else one for one in given)
    (cx, cy), (bx, by) = operation.equation.params["dimension_numbers"]
    fx = [k for k in range(len(x.shape)) if k not in (*cx, *bx)]
    fy = [k for k in range(len(y.shape)) if k not in (*cy, *by)]

    def term(outer: Index, index: Index) -> str:
        batch, rows, columns = len(bx), len(fx), len(fy)
        left = dict(zip((*bx, *fx, *cx), (*outer[: batch + rows], *index), strict=True))
        last = (*outer[:batch], *outer[batch + rows : batch + rows + columns], *index)
        right = dict(zip((*by, *fy, *cy), last, strict=True))
        one, other = x.at([left[k] for k in sorted(left)]), y.at([right[k] for k in sorted(right)])
        return f"({one} * {other})"

    inner = [x.shape[k] for k in cx]
    return _accumulated(block, operation, inner, SUMS["reduce_sum"], term)


def _accumulated(
    block: Block,
    operation: Operation,
    inner: Sequence[int],
    how: tuple[str, str],
    term: Callable[[Index, Index], str],
) -> View:
    out, algebra = operation.outputs[0], Texts(block.precision)
    kind, (begin, op) = kind_of(out.dtype), how
    first = block.number({"0": 0, "1": 1}[begin], kind) if begin in "01" else begin
    first = f"({block.precision}){first}" if "INFINITY" in first else first
    into = block.buffer(out.shape, kind) if out.shape else None
    name = block.fresh("t")

    def one(outer: Index) -> None:
        block.say(f"{type_of(kind, block.precision)} {name} = {first};")

        def add(index: Index) -> None:
            text = term(outer, index)
            text = block.simple(text, kind) if op in ("max", "min") else text
            both = algebra.apply(op, Text(name, kind), Text(text, kind)).text
            block.say(f"{name} = {both[1:-1] if both.startswith('(') else both};")

        block.nest(inner, add)
        if into is not None:
            block.say(f"{into.at(outer)} = {name};")

    block.nest(out.shape, one)
    return View(name, (), kind, alone=True) if into is None else into
