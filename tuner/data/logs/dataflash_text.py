"""ArduPilot DataFlash as text, the ``.log`` of ground stations: one message per line."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from tuner.data.logs.contents import Contents, Group, table_of
from tuner.data.logs.dataflash_formats import (
    DESCRIPTIONS,
    FORMAT,
    MOST_INSTANCES,
    Message,
    Scales,
    group_of,
)
from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw, Table
from tuner.names import counted

_TEXTS = "nNZ"
Counts = dict[tuple[str, str], int]


def open_dataflash_text(path: Path) -> Table:
    """Open a DataFlash log of lines ``NAME, value, value, ...`` that FMT lines describe.

    Raises:
        LogError: where no line of it is described; loading raises it for what is no number.
    """
    described: dict[str, list[list[str]]] = {name: [] for name in DESCRIPTIONS}
    for _, name, cells in _lines(path):
        if name in described:
            described[name].append(cells)
    messages = _messages(described)
    counts, cut = _counted(path, messages)
    scales = Scales.of(
        [row for row in described["UNIT"] if _fits(row, 3)],
        [row for row in described["MULT"] if _fits(row, 3)],
    )
    groups: list[Group] = []
    chosen: dict[str, tuple[str, str]] = {}
    for (name, instance), rows in counts.items():
        prefix = f"{name}[{instance}]." if instance else f"{name}."
        chosen[prefix] = (name, instance)
        groups.append(group_of(prefix, messages[name], rows, scales))
    if len(groups) > MOST_INSTANCES * len(messages):
        raise LogError(f"{path.name}: the {FORMAT} tells of too many sensors; copy it again")
    if not groups:
        raise LogError(f"{path.name}: the {FORMAT} describes none of its lines; copy it again")
    notes = [f"{counted(cut, 'line')} without all cells passed over"] if cut else []

    def load(names: Sequence[str]) -> dict[str, Raw]:
        return _loaded(path, messages, {name: chosen[_prefix(name)] for name in names})

    return table_of(path, Contents(FORMAT, groups, notes), load)


def _prefix(name: str) -> str:
    return name[: name.index(".") + 1]


def _lines(path: Path) -> Iterator[tuple[int, str, list[str]]]:
    """The number, the name and the cells of each line."""
    with path.open(encoding="latin-1") as stream:
        for number, line in enumerate(stream, 1):
            name, *cells = (cell.strip() for cell in line.split(","))
            yield number, name, cells


def _fits(row: list[str], width: int) -> bool:
    """Whether the last two cells give the meaning of a letter."""
    try:
        return len(row) == width and int(row[1]) >= 0
    except ValueError:
        return False


def _messages(described: dict[str, list[list[str]]]) -> dict[str, Message]:
    """The kinds of messages by name; the first description of a kind counts."""
    letters = {row[1]: row[2:] for row in described["FMTU"] if len(row) == 4}
    found: dict[str, Message] = {}
    for number, _, name, codes, *columns in (r for r in described["FMT"] if len(r) > 4):
        message = Message(name, codes, tuple(columns), *letters.get(number, ("", "")))
        if message.dtype is not None and name not in DESCRIPTIONS:
            found.setdefault(name, message)
    return found


def _cells(message: Message, cells: list[str]) -> list[str]:
    """One cell per column: a text at the end may hold commas; none where the line is cut."""
    width = len(message.columns)
    if len(cells) > width and message.codes[-1] in _TEXTS:
        cells = [*cells[: width - 1], ", ".join(cells[width - 1 :])]
    return cells if len(cells) == width else []


def _instance(message: Message, cells: list[str]) -> str:
    if message.instance is None:
        return ""
    return cells[message.columns.index(message.instance)]


def _counted(path: Path, messages: dict[str, Message]) -> tuple[Counts, int]:
    """Number of lines of each sensor, and number of cut lines."""
    counts: Counts = {}
    cut = 0
    for _, name, cells in _lines(path):
        if name not in messages:
            continue
        row = _cells(messages[name], cells)
        if not row:
            cut += 1
            continue
        key = (name, _instance(messages[name], row))
        counts[key] = counts.get(key, 0) + 1
    return counts, cut


def _loaded(
    path: Path, messages: dict[str, Message], wanted: dict[str, tuple[str, str]]
) -> dict[str, Raw]:
    """The cells of the wanted columns, as numbers."""
    parts: dict[str, list[str]] = {name: [] for name in wanted}
    lines: dict[tuple[str, str], list[int]] = {key: [] for key in wanted.values()}
    places = {}
    for name, (kind, _) in wanted.items():
        places[name] = messages[kind].columns.index(name[name.index(".") + 1 :])
    by_key = {key: [name for name in wanted if wanted[name] == key] for key in lines}
    kinds = {kind for kind, _ in lines}
    for number, kind, cells in _lines(path):
        row = _cells(messages[kind], cells) if kind in kinds else []
        if not row:
            continue
        key = (kind, _instance(messages[kind], row))
        if key not in lines:
            continue
        lines[key].append(number)
        for name in by_key[key]:
            parts[name].append(row[places[name]])
    return {
        name: _numbers(path, messages[wanted[name][0]], places[name], part, lines[wanted[name]])
        for name, part in parts.items()
    }


def _numbers(path: Path, message: Message, place: int, cells: list[str], lines: list[int]) -> Raw:
    if message.codes[place] in _TEXTS:
        return np.array(cells)
    try:
        return np.array(cells, np.float64)
    except ValueError:
        pass
    for cell, line in zip(cells, lines, strict=True):
        try:
            float(cell)
        except ValueError:
            raise LogError(
                f"{path.name}: line {line} has {cell[:40]!r} for {message.columns[place]!r} of "
                f"{message.name}, not a number; correct the line or remove it"
            ) from None
    raise AssertionError("all cells are numbers after all")
