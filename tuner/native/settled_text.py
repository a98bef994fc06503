"""The text of a loop that goes on with constant gains where they have settled."""

from collections.abc import Mapping, Sequence
from typing import Any

from tuner.native.loop import Loop
from tuner.native.loop_text import LoopText
from tuner.native.settled import Settled, Usual

_FIRST = 16
"""Samples after which it is looked for the first time whether the gains have settled."""
_SAME, _DRIFT = "0x1p-44", "0x1p-36"
"""Largest change that is rounding, over the variances that it lies between; and the largest one
that it may grow to if it goes on in the same way up to the end of the record."""


def settling(outer: LoopText, short: Settled) -> tuple[list[str], list[LoopText]]:
    """The text of a loop to the end of the record, and of its results; and its parts.

    It is run for some samples, then for half as many as since the start, and so on. Where what
    follows from itself alone is the same as before the last of these spells, and a sample later
    still, it is constant for good: by then an error would have shrunk by as much again, and what
    turns in circles is not the same a sample later. The settled loop takes over, up to a sample in
    which something is missing; nothing was in the spell either.

    Args:
        outer: the loop, which declares its carried numbers.
        short: the settled one.
    """
    every, last = (_part(outer, loop) for loop in (short.every, short.loop))
    cells = [(k, outer.type(outer.loop.carried[k].input)) for k in short.still]
    lines = [
        *outer.before(starts_only=True),
        f"    size_t since = i, at = i, next = i + {_FIRST};",
        "    bool once = false;",
        *(f"    {kind} R{k} = S{k};" for k, kind in cells),
        "    while (i < n) {",
        "        const size_t stop = next < n ? next : n;",
        *_run(every, "stop"),
        "        if (i >= n) break;",
        *_compared(outer, short.still),
        *_scanned(short.usual),
        "        if (same && !once) {",
        "            once = true;",
        "            next = i + 1;",
        "            continue;",
        "        }",
        "        once = false;",
        "        if (same) {",
        "            settled -= i;",
        *(f"    {line}" for line in _run(last, "n", _until_unusual(short.usual))),
        "            settled += i;",
        "            since = i;",
        "        }",
        "        at = i;",
        f"        next = i + (i - since < {2 * _FIRST} ? {_FIRST} : (i - since) / 2);",
        *(f"        R{k} = S{k};" for k in short.still),
        "    }",
        *outer.after(),
    ]
    return lines, [every, last]


def _part(outer: LoopText, loop: Loop) -> LoopText:
    """A loop that begins with the carried numbers of another one."""
    return LoopText(loop, outer.count, points=outer.points, before=outer, cells="T")


def _run(part: LoopText, end: str, first: Sequence[str] = ()) -> list[str]:
    """A block that runs a loop and leaves its carried numbers to the other one."""
    nodes = part.loop.graph.nodes
    starts = [nodes[cell.start] for cell in part.loop.carried]
    left = [f"    S{s.value[1]} = T{n};" for n, s in enumerate(starts) if s.op == "input"]
    lines = [*part.before(), *part.over(list(first), end), *left]
    return ["        {", *(f"        {line}" for line in lines), "        }"]


def _unusual(usual: Usual, row: str) -> str:
    """The condition that a row is not as usual."""
    found = [f"{row}[{k}] != {row}[{k}]" for k in usual.present]
    return " || ".join([*found, *(f"{row}[{k}] != 0.0" for k in usual.zero)])


def _until_unusual(usual: Usual) -> list[str]:
    """The loop ends at a sample that is not as usual."""
    found = _unusual(usual, "u")
    return [f"    if ({found}) break;"] if found else []


def _scanned(usual: Usual) -> list[str]:
    """The count begins anew after the last sample that was not as usual."""
    found = _unusual(usual, "row")
    lines = [
        "const double *row = u - width * (i - at);",
        "for (size_t k = at; k < i; k++, row += width)",
        f"    if ({found}) {{",
        "        same = false;",
        "        since = k + 1;",
        "    }",
    ]
    return [f"        {line}" for line in lines] if found else []


def _compared(outer: LoopText, still: Sequence[int]) -> list[str]:
    """Whether numbers are the same as before, but for rounding.

    A variance is compared over itself, a covariance over the two variances, and derivatives over
    these and the largest of the same direction.
    """
    cells = {_name(outer, k): _Cell(outer, k) for k in still}
    values, slopes = list[str](), dict[int, list[tuple[_Cell, str]]]()
    for name, cell in cells.items():
        if name[0] == "ds":
            slopes.setdefault(name[-1], []).append((cell, _scale(cells, ("s", *name[1:-1]))))
        elif cell.real:
            values.append(f"same &= {cell.change} <= most * {_scale(cells, name)};")
        else:
            values.append(f"same &= {cell.now} == {cell.before};")
    each = [*values, *(line for own in slopes.values() for line in _compared_slopes(own))]
    lanes = outer.count if any(cell.wide for cell in cells.values()) else 1
    lines = [
        f"const double drift = {_DRIFT} * (double)(i - at) / (double)n;",
        f"const double most = drift < {_SAME} ? drift : {_SAME};",
        "bool same = true;",
        f"for (int j = 0; j < {lanes}; j++) {{",
        *(f"    {line}" for line in each),
        "}",
    ]
    return [f"        {line}" for line in lines]


def _compared_slopes(own: "Sequence[tuple[_Cell, str]]") -> list[str]:
    """The same of derivatives in one direction, with what each of them is compared over."""
    lines = ["{", "    double largest = 0.0;"]
    for cell, over in own:
        lines.append(f"    if ({over} > 0.0) largest = fmax(largest, fabs({cell.now}) / {over});")
    lines += [f"    same &= {cell.change} <= most * largest * {over};" for cell, over in own]
    return [*lines, "}"]


class _Cell:
    """A carried number that repeats itself, in a lane.

    Attributes:
        real: whether it is a real number.
        wide: whether it differs between lanes.
        now, before, change: its text, that of the same some samples ago, and of how far it is off.
    """

    def __init__(self, outer: LoopText, k: int) -> None:
        self.real = outer.graph.nodes[outer.loop.carried[k].input].kind == "real"
        self.wide = k in outer.carried_wide
        lane = "[j]" if self.wide else ""
        self.now, self.before = f"S{k}{lane}", f"R{k}{lane}"
        self.change = f"fabs({self.now} - {self.before})"


def _scale(cells: Mapping[Any, _Cell], name: tuple[Any, ...]) -> str:
    """What a number of the state is compared over."""
    kind, leaf, *at = name
    variances = [cells[own].now for k in at if (own := (kind, leaf, k, k)) in cells]
    if len(at) == len(variances) == 2:
        return f"sqrt({variances[0]} * {variances[1]})" if at[0] != at[1] else variances[0]
    return f"fabs({cells[name].now})" if name in cells else "1.0"


def _name(outer: LoopText, k: int) -> tuple[Any, ...]:
    """The name of a carried number: a value, or a derivative with its direction."""
    name: tuple[Any, ...] = outer.graph.nodes[outer.loop.carried[k].input].value
    return name
