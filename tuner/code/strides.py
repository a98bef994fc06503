"""Operations that move entries of arrays: by strides where possible, else by loops."""

import math
from collections.abc import Sequence

import numpy as np

from tuner.code.block import Block
from tuner.code.memory import Held, Index, Lazy, View, affine, rows_first, total
from tuner.code.numbers import worked_out
from tuner.code.operations import Kind, kind_of
from tuner.code.rearrangements import places
from tuner.code.refused import NoCounterpartError, no_counterpart
from tuner.code.straight_line import Operation

_KEPT = frozenset({"copy", "copy_p", "stop_gradient", "optimization_barrier"})
MOVED = _KEPT | frozenset(
    [
        "broadcast_in_dim",
        "slice",
        "reshape",
        "squeeze",
        "expand_dims",
        "transpose",
        "rev",
        "split",
        "unstack",
        "gather",
        "dynamic_slice",
    ]
)
JOINED = frozenset({"concatenate", "stack", "pad"})
SCATTERED = frozenset({"scatter", "scatter-add", "scatter_add", "dynamic_update_slice"})


def moved(block: Block, operation: Operation, given: Sequence[Held]) -> list[Held]:
    """Entries of one array in other places: the same memory with other strides, where possible."""
    if operation.name in _KEPT:
        return list(given)
    x, asked = given[0], [given[0].shape]
    for atom in operation.inputs[1:]:
        if not isinstance(atom, np.ndarray):
            raise NoCounterpartError(
                f"{operation.name} by an index that is known only as the step runs"
            )
        asked.append(atom)  # type: ignore[arg-type]
    if isinstance(x, Lazy) and not x.shape:
        text = block.simple(x.at([]), x.kind) if x.number is None else x.at([])
        shapes = [out.shape for out in operation.outputs]
        return [Lazy(shape, x.kind, lambda _: text, x.buffers, x.number) for shape in shapes]
    source = block.made(x)
    return [_gathered(block, source, table) for table in places(operation.equation, asked)]


def _gathered(block: Block, x: View, table: np.ndarray, nothing: str = "") -> View:
    """Entries gathered by a table of positions, counted through the array.

    Args:
        block: the target.
        x: the array.
        table: the positions; negative ones for no entry.
        nothing: what is there instead; NaN if left out.
    """
    if x.alone or not x.shape:
        return View(x.buffer, table.shape, x.kind, x.base, (0,) * table.ndim, x.alone)
    reached = sum(
        (s * k for s, k in zip(x.strides, np.unravel_index(table, x.shape), strict=True)),
        np.zeros(table.shape, int),
    )
    line = affine(reached)
    if line is not None and not (table < 0).any():
        base, strides = line
        start = x.base + base if isinstance(x.base, int) else total(x.base, base)
        return View(x.buffer, table.shape, x.kind, start, strides)
    where = block.tables.read(reached.ravel())
    into = block.buffer((table.size,), x.kind)
    if (table < 0).any():
        nothing = nothing or block.number(np.nan, x.kind)

    def one(index: Index) -> None:
        place = where.at(index)
        text = f"{x.buffer}[{total(x.base, place)}]"
        block.say(
            f"{into.at(index)} = {f'({place} < 0) ? {nothing} : {text}' if nothing else text};"
        )

    block.nest((table.size,), one)
    base, strides = affine(np.arange(table.size).reshape(table.shape)) or (0, ())
    return View(into.buffer, table.shape, x.kind, base, strides)


def joined(block: Block, operation: Operation, given: Sequence[Held]) -> View:
    """Several arrays joined in one."""
    out = operation.outputs[0]
    kind: Kind = kind_of(out.dtype)
    (table,) = places(operation.equation, [x.shape for x in given])
    into = block.buffer(out.shape, kind, dense=True)
    first = 0
    where = np.argsort(table.ravel(), kind="stable")
    if operation.name == "pad":
        own = np.where(table < math.prod(given[0].shape), table, -1)
        if len(np.unique(own[own >= 0])) < math.prod(given[0].shape):  # some are left out
            return _gathered(block, block.made(given[0]), own, given[1].at([]))
        block.nest(out.shape, lambda index: block.say(f"{into.at(index)} = {given[1].at([])};"))
        where = np.array(
            [np.flatnonzero(table.ravel() == k)[0] for k in range(math.prod(given[0].shape))]
        )
        given = given[:1]
    for x in given:
        size = math.prod(x.shape)
        line = affine(where[first : first + size].reshape(x.shape))
        first += size
        if line is None:
            raise no_counterpart(operation.name)
        block.put(x, View(into.buffer, x.shape, kind, *line))
    return into


def scattered(
    block: Block, operation: Operation, given: Sequence[Held], dying: frozenset[str]
) -> View:
    """An array with some entries replaced, or with something added to them."""
    target, more = given[0], given[_more(operation)]
    starts = [atom for k, atom in enumerate(operation.inputs) if k not in (0, _more(operation))]
    if not all(isinstance(atom, np.ndarray) for atom in starts):
        raise NoCounterpartError(
            f"{operation.name} by an index that is known only as the step runs"
        )
    line = affine(_targets(operation, target.shape, more.shape))
    if line is None:
        raise no_counterpart(f"{operation.name} to places without order")
    more = block.made(more)
    into = block.made(target, dying - more.buffers)
    own = into.buffer in dying or not isinstance(target, View)
    if not own or into.buffer in more.buffers or into.strides != rows_first(target.shape):
        copy = block.buffer(target.shape, target.kind, dense=True)
        block.put(into, copy)
        into = copy
    base = into.base if isinstance(into.base, int) else 0
    place = View(into.buffer, more.shape, target.kind, base + line[0], line[1])
    if operation.name.startswith("scatter") and "add" in operation.name:
        block.nest(
            more.shape,
            lambda index: block.say(f"{place.at(index)} = {place.at(index)} + {more.at(index)};"),
        )
    else:
        block.put(more, place)
    return into


def _targets(operation: Operation, target: tuple[int, ...], more: tuple[int, ...]) -> np.ndarray:
    """The position of each entry in the target.

    Raises:
        NoCounterpartError: for a position outside.
    """
    dtype = operation.equation.invars[0].aval.dtype  # of what JAX traced an addition for
    counted = np.arange(1, math.prod(more) + 1, dtype=dtype).reshape(more)
    given = [np.zeros(target, dtype), *operation.inputs[1:]]
    given[_more(operation)] = counted
    (hit,) = (one.astype(int) for one in worked_out(operation.equation, given))
    where = np.full(counted.size, -1)
    reached = np.flatnonzero(hit.ravel())
    where[hit.ravel()[reached] - 1] = reached
    if (where < 0).any():
        raise no_counterpart(f"{operation.name} to places outside")
    return where.reshape(more)


def _more(operation: Operation) -> int:
    """The index of the operand that moves."""
    return 1 if operation.name == "dynamic_update_slice" else 2
