"""Sums and products of arrays in C, in the order in which a processor works on whole rows."""

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from math import prod

import numpy as np

from tuner.code import bulk
from tuner.code.block import Block
from tuner.code.loop_statements import Writer
from tuner.code.memory import Held, Index, Lazy, View
from tuner.code.operations import kind_of
from tuner.code.straight_line import Operation, Slot

_UNROLLED = 32
"""Terms of a sum that are written out."""
_ROWS = 4
"""Rows of one half of a matrix that are computed to the same length."""


def writers(even: Collection[Slot]) -> Mapping[str, Writer]:
    """The writers of these operations, by their names.

    Args:
        even: symmetric matrices, of which one half is computed.
    """
    return {"dot_general": partial(_product, even), "reduce_sum": _summed}


def _product(
    even: Collection[Slot], block: Block, operation: Operation, given: Sequence[Held]
) -> View:
    """A product of arrays, whose innermost loop runs along a row of one of them.

    An entry is a sum that is written out, so that entries of a row are computed side by side.
    """
    out = operation.outputs[0]
    (cx, cy), (bx, _) = operation.equation.params["dimension_numbers"]
    x, y = (block.made(one) if isinstance(one, Lazy) and one.buffers else one for one in given)
    if bx or len(cx) != 1 or len(out.shape) > 2 or x.shape[cx[0]] > _UNROLLED:
        return bulk.product(block, operation, [x, y])
    rows = [k for k in range(len(x.shape)) if k != cx[0]]
    columns = [k for k in range(len(y.shape)) if k != cy[0]]
    if columns:
        y = _along_rows(block, y, columns[-1])
    elif rows:
        x = _along_rows(block, x, rows[-1])

    def terms(index: Index) -> list[str]:
        found = []
        for k in range(x.shape[cx[0]]):
            left = x.at(_index(rows, cx[0], index[: len(rows)], k))
            right = y.at(_index(columns, cy[0], index[len(rows) :], k))
            found.append(f"{left} * {right}")
        return found

    write = _half_written if operation.outputs[0] in even else _written
    return write(block, operation, terms)


def _summed(block: Block, operation: Operation, given: Sequence[Held]) -> View:
    """A sum along some axes, written out."""
    (x,), axes = given, operation.equation.params["axes"]
    inner = [x.shape[k] for k in axes]
    if prod(inner) > _UNROLLED:
        return bulk.summed(block, operation, given)
    kept = [k for k in range(len(x.shape)) if k not in axes]

    def terms(index: Index) -> list[str]:
        found = []
        for at in np.ndindex(*inner):
            whole: list[int | str] = [0] * len(x.shape)
            for k, place in (*zip(kept, index, strict=True), *zip(axes, at, strict=True)):
                whole[k] = place
            found.append(x.at(whole))
        return found

    return _written(block, operation, terms)


def _written(block: Block, operation: Operation, terms: Callable[[Index], list[str]]) -> View:
    """Entries that are sums of terms; of a single one no term waits for more than a few."""
    out = operation.outputs[0]
    kind = kind_of(out.dtype)
    if not out.shape:
        name = block.fresh("t")
        block.say(f"const double {name} = {_balanced(terms([]))};")
        return View(name, (), kind, alone=True)
    into = block.buffer(out.shape, kind)

    def one(index: Index) -> None:
        text = " + ".join(terms(index)) or "0.0"
        block.say(f"{into.at(index)} = {text};")

    begun = len(block.lines)
    block.nest(out.shape, one)
    block.fill_up(begun + sum(size != 1 for size in out.shape) - 1, into)
    return into


def _half_written(block: Block, operation: Operation, terms: Callable[[Index], list[str]]) -> View:
    """A symmetric matrix of sums: what is on one side of its diagonal is copied to the other."""
    out = operation.outputs[0]
    into, (size, _) = block.buffer(out.shape, kind_of(out.dtype)), out.shape

    def rows(first: int, end: int) -> None:
        block.loop(first, end, lambda i: block.loop(0, end, lambda j: one((i, j))))

    def one(index: Index) -> None:
        block.say(f"{into.at(index)} = {' + '.join(terms(index))};")

    for first in range(0, size, _ROWS):
        begun = len(block.lines)
        rows(first, min(first + _ROWS, size))
        block.fill_up(begun + 1, into)
    block.say(f"mirror({into.buffer}, {into.strides[0]}, {size});")
    return into


def _balanced(terms: Sequence[str]) -> str:
    """A sum as one of halves.

    >>> _balanced(["a", "b", "c", "d"])
    '(a + b) + (c + d)'
    """
    if len(terms) < 3:
        return " + ".join(terms) or "0.0"
    half = len(terms) // 2
    return " + ".join(f"({_balanced(part)})" for part in (terms[:half], terms[half:]))


def _index(outer: Sequence[int], inner: int, at: Index, k: int) -> Index:
    found: list[int | str] = [k] * (len(outer) + 1)
    found[inner] = k
    for axis, name in zip(outer, at, strict=True):
        found[axis] = name
    return found


def _along_rows(block: Block, x: Held, axis: int) -> Held:
    """An array whose entries along an axis lie side by side: a turned copy, where they do not."""
    if isinstance(x, Lazy) or x.strides[axis] == 1 or len(x.shape) < 2:
        return x
    copy = block.buffer(x.shape[::-1], x.kind)
    turned = View(copy.buffer, x.shape, x.kind, 0, copy.strides[::-1])
    block.put(x, turned)
    return turned
