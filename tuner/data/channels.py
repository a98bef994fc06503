"""From the columns of one file to channels in SI."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from tuner.data.geodesy import east, height, north
from tuner.data.logs.clock import Clock
from tuner.data.logs.error import LogError
from tuner.data.logs.mapping import Mapping as Column
from tuner.data.logs.table import Floats, Raw
from tuner.data.logs.timing import find_clock
from tuner.data.logs.values import Columns, pick, pick_whole, rounded, to_float
from tuner.data.mapped_channels import MappedChannel
from tuner.data.units import Unit, change
from tuner.names import counted

_IN_BRACKETS = re.compile(r".*[(\[]([^()\[\]]*)[)\]]\s*")
_ROWS = 4096
_DEGREES = ("lat", "lon")


@dataclass(frozen=True, eq=False)
class Reading:
    """One channel as it was read.

    Attributes:
        wanted: what was asked for.
        values: ``(N,)`` or ``(N, k)``, in ``unit``; NaN where nothing was measured.
        unit: SI.
        clock: when it was measured.
        notes: what was assumed.
    """

    wanted: MappedChannel
    values: Floats
    unit: str
    clock: Clock
    notes: tuple[str, ...]


def read_channels(
    columns: Columns,
    wanted: Sequence[MappedChannel],
    time: Sequence[Column] | None,
    rate_hz: float | None,
) -> list[Reading]:
    """Read what is wanted of the loaded columns.

    Raises:
        LogError: for columns, units or times that cannot be used, in one sentence.
    """
    picked = [_picked(columns, one) for one in wanted]
    clocks = _clocks(columns, wanted, picked, time, rate_hz)
    zero = _first_fix(columns, wanted)
    found = []
    for one, raw in zip(wanted, picked, strict=True):
        values, unit, notes = _in_si(columns, one, raw, zero)
        notes = (*(rounded(column) for column in raw[:1]), *notes)
        named = tuple(f"{one.mapped.channel}: {note}" for note in notes if note)
        found.append(Reading(one, values, unit, clocks[len(raw[0])], named))
    return found


def _picked(columns: Columns, one: MappedChannel) -> list[Raw]:
    """The raw columns of a channel, or one array of all its axes."""
    axes = one.declared.axes if one.declared else None
    if len(one.parts) == 1:
        raw = [pick_whole(columns, one.parts[0])]
    else:
        raw = [pick(columns, part) for part in one.parts]
    width = raw[0].shape[1] if raw[0].ndim == 2 else len(raw)
    name, source = one.mapped.channel, one.mapped.source
    if axes is not None and width != max(len(axes), 1):
        columns_ = ",".join(["COLUMN"] * max(len(axes), 1))
        needs = f"has {len(axes)} axes ({', '.join(axes)})" if axes else "is one number per sample"
        raise LogError(
            f"{columns.table.file}: {name} {needs}, and {source!r} is {counted(width, 'column')}; "
            f"write {name}={columns_}"
        )
    if len({len(column) for column in raw}) > 1:
        rows = ", ".join(str(len(column)) for column in raw)
        raise LogError(
            f"{columns.table.file}: {source!r} has {rows} rows; map columns of one length"
        )
    if len(raw[0]) < 2:
        count = counted(len(raw[0]), "row")
        raise columns.error(one.parts[0], f"has {count}; a log needs at least 2")
    return raw


def _clocks(
    columns: Columns,
    wanted: Sequence[MappedChannel],
    picked: list[list[Raw]],
    time: Sequence[Column] | None,
    rate_hz: float | None,
) -> dict[int, Clock]:
    """The clock of the samples, by their number: each length has a clock of its own."""
    lengths = dict.fromkeys(len(raw[0]) for raw in picked)
    found = {n: find_clock(columns, time, rate_hz, n) for n in lengths}
    if len(found) > 1 and any(clock.origin is None for clock in found.values()):
        first, other = list(found)[:2]
        name = next(w for w, raw in zip(wanted, picked, strict=True) if len(raw[0]) == other)
        raise columns.error(
            name.parts[0],
            f"has {counted(other, 'row')} where {wanted[0].mapped.source!r} has {first}; map "
            "columns of one length, or save a time column for each length",
        )
    return found


def _in_si(
    columns: Columns, one: MappedChannel, raw: list[Raw], zero: "tuple[float, float] | None"
) -> tuple[Floats, str, tuple[str, ...]]:
    """The values in the declared unit, that unit, and what was assumed."""
    parts, unit, notes = [], "", []
    for mapping, column in zip(one.parts, raw, strict=True):
        values = to_float(columns, mapping, column)
        changed, unit, note = _changed(columns, one, mapping, values, zero)
        parts.append(changed)
        notes.append(note)
    together = parts[0] if len(parts) == 1 else _side_by_side(parts)
    return together, unit, tuple(dict.fromkeys(notes))


def _side_by_side(parts: Sequence[Floats]) -> Floats:
    """Columns as one array, filled in blocks of rows that fit the cache."""
    together = np.empty((len(parts[0]), len(parts)))
    for start in range(0, len(together), _ROWS):
        rows = slice(start, start + _ROWS)
        for k, part in enumerate(parts):
            together[rows, k] = part[rows]
    return together


def _changed(
    columns: Columns,
    one: MappedChannel,
    mapping: Column,
    values: Floats,
    zero: "tuple[float, float] | None",
) -> tuple[Floats, str, str]:
    """One column in the declared unit."""
    declared = one.declared.unit if one.declared else "unit"
    unit, note = mapping.unit, ""
    if unit in _DEGREES:
        return _metres(columns, mapping, values, declared, zero)
    if unit is None and declared and (unit := unit_in_name(mapping)):
        note = f"{unit}, as the column's name says"
    if unit is None and declared and (unit := _unit_of_file(columns, mapping)):
        note = f"{unit}, as the file says"
    try:
        if declared == "m" and unit is not None and Unit.of(unit).si == "Pa":
            meaning = "height in the standard atmosphere, from a pressure"
            return height(change(unit, "Pa")(values)), "m", meaning
        into = change(unit, declared)
    except ValueError as error:
        reason = str(error) if str(error).startswith("is ") else f"is in an {error}"
        raise columns.error(mapping, reason) from error
    return into(values), into.unit, note or into.note


def _unit_of_file(columns: Columns, mapping: Column) -> str | None:
    """The unit that the file gives for a column, where it is a known one."""
    unit = columns.table.units.get(mapping.column)
    if unit is None or mapping.factor is not None:
        return None
    try:
        return Unit.of(unit).name
    except ValueError:
        return None


def unit_in_name(mapping: Column) -> str | None:
    """The unit in brackets at the end of a column's name, where it is one."""
    match = _IN_BRACKETS.fullmatch(mapping.column)
    if match is None or not match[1] or mapping.factor is not None or match[1].isdecimal():
        return None
    try:
        return Unit.of(match[1]).name
    except ValueError:
        return None


def _metres(
    columns: Columns,
    mapping: Column,
    values: Floats,
    declared: str,
    zero: "tuple[float, float] | None",
) -> tuple[Floats, str, str]:
    """Degrees as metres from the first fix."""
    if declared != "m" and "unit" not in declared:
        raise columns.error(mapping, f"is in degrees, metres then, where {declared} is needed")
    if zero is None:
        raise columns.error(
            mapping, "is a longitude or latitude alone; map both of them, one :lat and one :lon"
        )
    first = f"first fix, latitude {zero[0]:.7f}, longitude {zero[1]:.7f} (WGS 84 radii there)"
    if mapping.unit == "lat":
        return north(values, zero[0]), "m", f"metres north of the {first}"
    return east(values, *zero), "m", f"metres east of the {first}"


def _first_fix(columns: Columns, wanted: Iterable[MappedChannel]) -> "tuple[float, float] | None":
    """Latitude and longitude of the first row that has both; None without such columns."""
    degrees: dict[str, Floats] = {}
    for one in wanted:
        for part in one.parts:
            if part.unit in _DEGREES and part.unit not in degrees:
                degrees[part.unit] = to_float(columns, part, pick(columns, part))
    if len(degrees) < 2 or len(degrees["lat"]) != len(degrees["lon"]):
        return None
    both = ~np.isnan(degrees["lat"]) & ~np.isnan(degrees["lon"])
    row = int(np.argmax(both))
    return (float(degrees["lat"][row]), float(degrees["lon"][row])) if both.any() else None
