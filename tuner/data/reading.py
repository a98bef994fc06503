"""From files and mappings to records."""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from os import PathLike
from pathlib import Path
from typing import TypeAlias

import numpy as np

from tuner.data.channels import Reading, read_channels, unit_in_name
from tuner.data.cut import cut
from tuner.data.loading import File, Timed, has_time, labels_in, loaded, once_each
from tuner.data.logs.error import LogError, quoted
from tuner.data.logs.formats import open_table
from tuner.data.logs.table import Table
from tuner.data.mapped_channels import (
    Declared,
    MappedChannel,
    assigned_to_files,
    channels_by_clock,
    channels_of_file,
    parse_mappings,
)
from tuner.data.record import Reading as HowRead
from tuner.data.record import Record
from tuner.data.signal import Signal
from tuner.data.source import Source, file_digests
from tuner.data.splitting import split
from tuner.names import counted

_BLOCK = 1 << 15
Paths: TypeAlias = "str | PathLike[str] | Sequence[str | PathLike[str]]"


def read_record(
    paths: Paths,
    mappings: Sequence[str],
    *,
    truth: Sequence[str] = (),
    inputs: Declared = None,
    outputs: Declared = None,
    rate_hz: float | None = None,
    time: str | None = None,
    drop_repeats: bool = False,
    from_s: float | None = None,
    to_s: float | None = None,
) -> Record:
    """Read one recording from one file or several on one clock; see :func:`read_records`.

    Raises:
        LogError: as :func:`read_records`, and where the files are several recordings.

    Example:
        >>> import pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "gyro.csv")
        ...     _ = path.write_text("t,gx\\n0.00,90\\n0.01,\\n0.02,180\\n")
        ...     record = read_record(path, ["rate=gx:deg/s"])
        >>> record.channels["rate"].values.round(4).tolist(), record.channels["rate"].unit
        ([1.5708, nan, 3.1416], 'rad/s')
    """
    records = read_records(
        paths,
        mappings,
        truth=truth,
        inputs=inputs,
        outputs=outputs,
        rate_hz=rate_hz,
        time=time,
        drop_repeats=drop_repeats,
        from_s=from_s,
        to_s=to_s,
    )
    if len(records) > 1:
        raise LogError(
            f"{quoted(record.name for record in records)} hold the same columns and so are "
            "several recordings; read them with read_records, or name the file of each column"
        )
    return records[0]


def read_records(
    paths: Paths,
    mappings: Sequence[str],
    *,
    truth: Sequence[str] = (),
    inputs: Declared = None,
    outputs: Declared = None,
    rate_hz: float | None = None,
    time: str | None = None,
    by: str | None = None,
    drop_repeats: bool = False,
    from_s: float | None = None,
    to_s: float | None = None,
) -> tuple[Record, ...]:
    """Read recordings of any format of docs/logs.md.

    Files that all have all columns are recordings side by side; files that share the columns out
    among them are one recording on one clock, and so do the topics of one file.

    Args:
        paths: the file, or several; their bytes tell the format, not their names.
        mappings: ``NAME=COLUMN``, ``NAME=COLUMN,COLUMN,COLUMN:UNIT``: which columns feed which
            channel. A column may have a minus sign, ``[index]`` and ``*factor``; ``FILE/`` before
            them says which file is meant. The units ``lat`` and ``lon`` are degrees that become
            metres north and east of the first fix.
        truth: the same for the true outputs.
        inputs: the declared channels, with their units and axes; any name and any SI unit
            if left out.
        outputs: the same for the truth.
        rate_hz: samples per second; None takes it from a time column or a scalar of the file. It
            overrules a time column that does not agree. With several files, that of those without
            a time column.
        time: the time column as ``column[index]*factor:unit``, or several whose sum is the time,
            such as ``date:dmy,clock``; None looks for them by their names and contents.
        by: the column, of numbers or text, that separates the recordings of one file;
            ``restart`` where a new one begins wherever the time runs back.
        drop_repeats: whether rows with the time of the row before are left out.
        from_s: earlier samples are left out, s since the start of each recording.
        to_s: later samples are left out, likewise.

    Raises:
        LogError: for a file, a column, a unit or values that cannot be used, in one sentence.
    """
    options = {"map": [*mappings], "truth": [*truth], "rate_hz": rate_hz, "time": time}
    options |= {"by": by, "drop_repeats": drop_repeats or None, "from_s": from_s, "to_s": to_s}

    def done(record: Record) -> Record:
        part = cut(record, from_s, to_s)
        return replace(part, reading=HowRead(options, part.channels, part.truth))

    files = [Path(paths)] if isinstance(paths, str | PathLike) else [Path(path) for path in paths]
    if not files:
        raise LogError("no file is named; give at least one")
    if rate_hz is not None:
        _check_rate(rate_hz)
    names = [path.name for path in files]
    maps = parse_mappings(mappings, inputs, names, truth=False) + parse_mappings(
        truth, outputs, names, truth=True
    )
    columns = [part.column for mapped, _, _ in maps for part in mapped.parts]
    tables = [open_table(path).with_kinds(columns) for path in files]
    if not mappings:
        raise LogError(
            f"{tables[0].file}: no channel is mapped; give --map NAME=COLUMN with one of the "
            f"columns {quoted(tables[0].names)}"
        )
    timed = Timed(time, rate_hz, drop_repeats)
    shares = assigned_to_files(tables, maps)
    one = shares is not None and len(files) > 1
    if one and by is not None:
        raise LogError(f"--by {by} splits one file, and {quoted(names)} are one recording")
    with file_digests(files, [table.blocks for table in tables]) as digests:
        found = _files(
            files, digests, tables, shares or [channels_of_file(table, maps) for table in tables]
        )
        if one:
            return (done(_merged([part for parts in found for part in parts], timed)),)
        if by is None:
            return tuple(done(_merged(parts, timed)) for parts in found)
        parted = [record for parts in found for record in _parted(_one_clock(parts, by), timed, by)]
        return tuple(map(done, parted))


def _check_rate(rate_hz: float) -> None:
    if not (math.isfinite(rate_hz) and rate_hz > 0):
        raise LogError(f"--rate is {rate_hz:g} Hz; it must be positive and finite")


def _files(
    paths: Sequence[Path],
    digests: Sequence[Callable[[], str]],
    tables: Sequence[Table],
    shares: Sequence[list[MappedChannel]],
) -> list[list[File]]:
    """The sources to read: each file, for each of its clocks."""
    return [
        [
            File(path, part, tuple(wanted), digest)
            for part, wanted in channels_by_clock(table, share)
        ]
        for path, digest, table, share in zip(paths, digests, tables, shares, strict=True)
    ]


def _one_clock(parts: Sequence[File], by: str) -> File:
    if len(parts) > 1:
        groups = quoted(part.table.prefix for part in parts)
        raise LogError(f"--by {by} splits columns on one clock, and {groups} have one each")
    return parts[0]


def _merged(files: Sequence[File], timed: Timed) -> Record:
    """One recording from files on one clock."""
    several = len(files) > 1
    if several:
        timed.check_somewhere([file.table for file in files])
    found: list[tuple[File, list[Reading]]] = []
    for file in files:
        columns, clock = loaded(file, timed, optional=several)
        rate = None if several and has_time(file.table, clock) else timed.rate_hz
        columns = once_each(file, columns, clock, timed)
        readings = read_channels(columns, file.wanted, clock, rate)
        found.append((replace(file, table=columns.table), readings))
    _check_present(found)
    return _record(files[0].path.name if not several else _together(files), found)


def _together(files: Sequence[File]) -> str:
    return " + ".join(dict.fromkeys(file.path.name for file in files))


def _parted(file: File, timed: Timed, by: str) -> list[Record]:
    """The recordings of one file, separated by a column or by its times."""
    columns, clock = loaded(file, timed)
    labels = labels_in(file, columns, clock, by)
    parts = [(label, rows) for label, rows in split(labels)]
    long = [(label, columns.rows(rows, len(labels))) for label, rows in parts if len(rows) > 1]
    if not long:
        raise LogError(f"{file.table.file}: no value of {by!r} has 2 rows; name another column")
    found = []
    for label, own in long:
        some = once_each(file, own, clock, timed)
        readings = read_channels(some, file.wanted, clock, timed.rate_hz)
        found.append((label, replace(file, table=some.table), readings))
    _check_present([(own, readings) for _, own, readings in found])
    records = [_record(f"{own.path.name}: {by} {label}", [(own, r)]) for label, own, r in found]
    if left := len(parts) - len(long):
        note = f"{by}: {counted(left, 'value')} with one row alone left out"
        records[0] = replace(records[0], notes=(*records[0].notes, note))
    return records


def _record(name: str, found: Sequence[tuple[File, list[Reading]]]) -> Record:
    """Channels with their times since the first of them."""
    readings = [reading for _, those in found for reading in those]
    origins = [r.clock.origin for r in readings if r.clock.origin is not None]
    start = min(origins, default=Fraction(0))
    channels: dict[str, Signal] = {}
    truth: dict[str, Signal] = {}
    for reading in readings:
        place = truth if reading.wanted.truth else channels
        place[reading.wanted.mapped.channel] = _signal(reading, start)
    sources = tuple(
        _source(file, [one for other, those in found if other.path == path for one in those])
        for path, file in {file.path: file for file, _ in found}.items()
    )
    return Record(name, channels, truth, sources, _notes(found))


def _signal(reading: Reading, start: Fraction) -> Signal:
    clock = reading.clock
    later = 0.0 if clock.origin is None else float(clock.origin - start)
    values, times = reading.values, clock.seconds + later if later else clock.seconds
    values.flags.writeable = times.flags.writeable = False
    source = ",".join(part.source for part in reading.wanted.parts)
    units = {part.unit or unit_in_name(part) or "" for part in reading.wanted.parts}
    written = units.pop() if len(units) == 1 else ""
    return Signal(values, times, reading.unit, source, clock, written)


def _source(file: File, readings: Sequence[Reading]) -> Source:
    longest = max((reading.clock for reading in readings), key=lambda clock: len(clock.seconds))
    return Source(file.path.name, file.digest(), len(longest.seconds), longest.rate_hz)


def _check_present(found: Sequence[tuple[File, list[Reading]]]) -> None:
    """Refuse a channel without a single number in a file."""
    filled: Counter[tuple[str, str]] = Counter()
    rows: Counter[tuple[str, str]] = Counter()
    for file, readings in found:
        for reading in readings:
            mapped = reading.wanted.mapped
            key = (file.table.file, f"{mapped.source!r} (mapped to {mapped.channel})")
            rows[key] += len(reading.values)
            filled[key] += _any_number(reading.values)
    for (name, column), count in rows.items():
        if not filled[name, column]:
            raise LogError(
                f"{name}: column {column} is missing in all {count} rows; "
                "map a column that holds numbers"
            )


def _any_number(values: np.ndarray) -> bool:
    """Whether a channel holds a number; only its beginning is looked at where that does."""
    blocks = (values[at : at + _BLOCK] for at in range(0, len(values), _BLOCK))
    return any(not np.isnan(block).all() for block in blocks)


def _notes(found: Sequence[tuple[File, list[Reading]]]) -> tuple[str, ...]:
    """Everything that was assumed in all files."""
    notes: list[str] = []
    several = len({file.path for file, _ in found}) > 1
    for file, readings in found:
        prefix = f"{file.path.name}: " if several else ""
        notes += [prefix + note for note in file.table.notes]
        clocks = {id(r.clock): r.clock for r in readings}
        notes += [prefix + note for clock in clocks.values() for note in clock.notes]
        notes += [note for reading in readings for note in reading.notes]
        if len(found) > 1 and any(clock.origin is None for clock in clocks.values()):
            notes.append(f"{prefix}no times of its own; taken to begin with the other files")
    return tuple(dict.fromkeys(notes))
