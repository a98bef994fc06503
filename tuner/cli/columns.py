"""tuner columns: what a log holds, before anything of it is mapped."""

import json as json_
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from tuner.data.logs.clock import Clock
from tuner.data.logs.error import LogError
from tuner.data.logs.formats import open_table
from tuner.data.logs.table import Raw, Table
from tuner.data.logs.timing import find_clock
from tuner.data.logs.values import Columns, load_columns
from tuner.names import counted


@dataclass(frozen=True)
class ColumnFound:
    """One column: its shape and type as stored, its unit where the file tells it."""

    name: str
    shape: list[int]
    type: str
    unit: str


@dataclass(frozen=True)
class ClockFound:
    """Columns of one length on one clock.

    Attributes:
        columns: those columns.
        rows: how many samples.
        time: where their times come from; ``""`` where nothing in the file tells them.
        rate_hz: samples a second; None without times.
        seconds: from the first sample to the last; None without times.
        notes: what is peculiar to the times, or why there are none.
    """

    columns: list[ColumnFound]
    rows: int
    time: str
    rate_hz: float | None
    seconds: float | None
    notes: list[str]


def show(path: Path, *, json: bool) -> None:
    """Print what a log holds.

    Raises:
        LogError: where it cannot be read.
    """
    table = open_table(path)
    notes = list(dict.fromkeys([*table.notes, *(n for t in table.groups for n in t.notes)]))
    found = [clock for part in table.groups or (table,) for clock in _clocks(part)]
    if json:
        held = {"file": table.file, "format": table.format, "notes": notes}
        clocks = [asdict(clock) for clock in found]
        print(json_.dumps({"schema": "tuner.columns/1", **held, "clocks": clocks}, indent=1))
        return
    _print(table, notes, found)


def _clocks(table: Table) -> list[ClockFound]:
    """The columns of a group, by their length."""
    numbers = [name for name in table.names if name not in table.texts]
    raw, unread, notes = _loaded(table, numbers)
    lengths: dict[int, list[str]] = {}
    for name in numbers:
        if name in raw:
            lengths.setdefault(len(raw[name]) if raw[name].ndim else 0, []).append(name)
    known = replace(table, names=tuple(raw), time=table.time if _has_time(table, raw) else None)
    found = [_clock(known, raw, names, length) for length, names in lengths.items()]
    if found and notes:
        found[0] = replace(found[0], notes=[*notes, *found[0].notes])
    others = [*table.texts, *unread]
    texts = [ColumnFound(name, [], "text", "") for name in table.names if name in others]
    return found if not texts else [*found, ClockFound(texts, 0, "", None, None, [])]


def _has_time(table: Table, raw: dict[str, Raw]) -> bool:
    return table.time is not None and table.time.column in raw


def _loaded(table: Table, names: list[str]) -> tuple[dict[str, Raw], list[str], list[str]]:
    """All columns of numbers, the names of those that hold something else, and what was found."""
    try:
        columns = load_columns(table, (), names)
        return columns.raw, [], list(columns.table.notes[len(table.notes) :])
    except LogError:
        raw: dict[str, Raw] = {}
        unread = []
        for name in names:
            try:
                raw |= load_columns(table, (), [name]).raw
            except LogError:
                unread.append(name)
        return raw, unread, []


def _clock(table: Table, raw: dict[str, Raw], names: list[str], rows: int) -> ClockFound:
    columns = [
        ColumnFound(name, list(raw[name].shape), _type(raw[name]), table.units.get(name, ""))
        for name in names
    ]
    if rows < 2:
        return ClockFound(columns, rows, "", None, None, [])
    try:
        clock = find_clock(Columns(table, raw), None, None, rows)
    except LogError as error:
        unknown = "neither a time column nor a rate is known" in str(error)
        why = "no times are known: give --rate HZ or --time COLUMN" if unknown else str(error)
        return ClockFound(columns, rows, "", None, None, [why])
    notes = [*clock.notes, *_peculiar(clock)]
    return ClockFound(columns, rows, clock.source, clock.rate_hz, float(clock.seconds[-1]), notes)


def _type(array: Raw) -> str:
    return "date or time" if array.dtype.kind == "S" else array.dtype.name


def _peculiar(clock: Clock) -> list[str]:
    if clock.gaps:
        longest = max(seconds for _, seconds in clock.gaps)
        return [f"{counted(len(clock.gaps), 'gap')}, the longest {longest:.4g} s"]
    return [] if clock.steady else ["uneven"]


def _print(table: Table, notes: list[str], found: list[ClockFound]) -> None:
    print(f"{table.file}: {table.format}")
    for note in notes:
        print(f"  {note}")
    for clock in found:
        print(f"\n{_headline(clock)}")
        for note in clock.notes:
            print(f"  {note}")
        width = max(len(_written(column)) for column in clock.columns)
        for column in clock.columns:
            print(f"  {_written(column):{width}}  {column.type:8}  {column.unit}".rstrip())


def _headline(clock: ClockFound) -> str:
    if clock.rate_hz is None or clock.seconds is None:
        return counted(clock.rows, "row") if clock.rows else "single values and texts"
    text = f"{counted(clock.rows, 'row')}, {clock.rate_hz:.6g} Hz, {clock.seconds:.6g} s"
    return f"{text}, time: {clock.time}"


def _written(column: ColumnFound) -> str:
    """The name, and which indices it takes."""
    wide = len(column.shape) == 2
    return f"{column.name}[0..{column.shape[1] - 1}]" if wide else column.name
