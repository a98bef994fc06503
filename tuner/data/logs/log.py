"""Reading a log: from a file and mappings to channels and findings."""

import hashlib
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from tuner.data.logs.error import LogError, counted, quoted
from tuner.data.logs.findings import ChannelFindings, Findings, find_channel
from tuner.data.logs.formats import open_table
from tuner.data.logs.mapping import Mapping, parse_column
from tuner.data.logs.table import Floats, Raw, Table
from tuner.data.logs.timing import Timing, find_timing, timing_names
from tuner.data.logs.values import Columns, check_finite, load_columns, pick, rounded, to_float


@dataclass(frozen=True, eq=False)
class Log:
    """A sensor log of N samples.

    Attributes:
        name: the file's name without its folder.
        sha256: of the file's bytes, hexadecimal.
        rate_hz: samples per second.
        channels: each ``(N,)``, float64, contiguous and read-only, in ``units``.
        units: of each channel; ``""`` where none was given.
        findings: what was found on reading.
    """

    name: str
    sha256: str
    rate_hz: float
    channels: dict[str, Floats]
    units: dict[str, str]
    findings: Findings


def read_log(
    path: str | PathLike[str],
    mappings: Sequence[Mapping],
    *,
    rate_hz: float | None = None,
    time: str | None = None,
    limit: int | None = None,
) -> Log:
    """Read the mapped columns of a log: CSV or TXT (also compressed), NPZ, or MAT.

    Args:
        path: the file; its bytes tell the format, not its name.
        mappings: which column feeds which channel, from :func:`parse_mapping`.
        rate_hz: samples per second; None takes it from a time column or a scalar of the file.
        time: the time column as ``column[index]*factor:unit``; None looks for one by its name.
            Without factor and unit, the unit at the end of its name counts, else seconds.
        limit: read this many samples at most.

    Raises:
        LogError: for a file, a column or values that cannot be used, in one sentence.

    Example:
        >>> import pathlib, tempfile
        >>> from tuner.data.logs import parse_mapping
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "gyro.csv")
        ...     _ = path.write_text("t,gx\\n0.00,1.5\\n0.01,2.5\\n0.02,2.0\\n")
        ...     log = read_log(path, [parse_mapping("omega=gx:deg/s", ["omega"])])
        >>> log.channels["omega"], log.units["omega"], round(log.rate_hz, 6)
        (array([1.5, 2.5, 2. ]), 'deg/s', 100.0)
    """
    path = Path(path)
    _check_request(mappings, rate_hz, limit)
    table = open_table(path, limit)
    _check_mapped(table, mappings)
    mapped = [table.resolve(mapping) for mapping in mappings]
    clock = None if time is None else table.resolve(parse_column("time", time))
    columns = _load(table, mapped, clock)
    picked = [pick(columns, mapping) for mapping in mapped]
    timing = find_timing(columns, clock, rate_hz, _samples(columns, mapped, picked), limit)
    channels = {
        mapping.channel: _frozen(to_float(columns, mapping, column[:limit]))
        for mapping, column in zip(mapped, picked, strict=True)
    }
    for mapping in mapped:
        check_finite(columns, mapping, channels[mapping.channel])
    found = [
        find_channel(mapping, channels[mapping.channel], rounded(column))
        for mapping, column in zip(mapped, picked, strict=True)
    ]
    _check_alive(columns, mapped, found)
    units = {channel.name: channel.unit for channel in found}
    findings = _findings(timing, found)
    return Log(path.name, sha256_of(path), timing.rate_hz, channels, units, findings)


def check_rate(rate_hz: float) -> None:
    """Refuse what is no rate.

    Raises:
        LogError: where it is not positive and finite.
    """
    if not (math.isfinite(rate_hz) and rate_hz > 0):
        raise LogError(f"--rate is {rate_hz:g} Hz; it must be positive and finite")


def _check_request(mappings: Sequence[Mapping], rate_hz: float | None, limit: int | None) -> None:
    """Refuse what is wrong whatever the file holds."""
    if rate_hz is not None:
        check_rate(rate_hz)
    if limit is not None and limit < 2:
        raise LogError(f"the limit is {counted(limit, 'sample')}; a log needs at least 2")
    counts = Counter(mapping.channel for mapping in mappings)
    for channel, count in counts.items():
        if count > 1:
            raise LogError(f"the channel {channel!r} is mapped {count} times; map it once")


def _check_mapped(table: Table, mappings: Sequence[Mapping]) -> None:
    if not mappings:
        raise LogError(
            f"{table.file}: no channel is mapped; give --map NAME=COLUMN with one of the columns "
            f"{quoted(table.names)}"
        )


def _load(table: Table, mapped: list[Mapping], clock: Mapping | None) -> Columns:
    """What the channels and their timing need; a named clock needs no search for another."""
    if clock is not None:
        return load_columns(table, [*mapped, clock], ())
    return load_columns(table, mapped, timing_names(table))


def _samples(columns: Columns, mapped: list[Mapping], picked: list[Raw]) -> int:
    """The number of samples that all mapped columns share."""
    samples = len(picked[0])
    for mapping, column in zip(mapped, picked, strict=True):
        if len(column) != samples:
            raise columns.error(
                mapping,
                f"has {counted(len(column), 'row')} where {mapped[0].source!r} has {samples}; "
                "map columns of one length",
            )
    if samples < 2:
        raise columns.error(mapped[0], f"has {counted(samples, 'row')}; a log needs at least 2")
    return samples


def _frozen(values: Floats) -> Floats:
    values.flags.writeable = False
    return values


def _check_alive(columns: Columns, mapped: list[Mapping], found: list[ChannelFindings]) -> None:
    """Refuse a channel that never changes: nothing can be tuned on it."""
    for mapping, channel in zip(mapped, found, strict=True):
        if channel.constant:
            raise columns.error(
                mapping, f"is constant, {channel.mean:g} in every row; map a column that changes"
            )


def _findings(timing: Timing, found: list[ChannelFindings]) -> Findings:
    clock = timing.clock
    return Findings(
        samples=len(clock.seconds),
        duration_s=clock.duration_s,
        rate_hz=timing.rate_hz,
        rate_source=timing.source,
        time_column=timing.column,
        gaps=clock.gaps,
        jitter=None if timing.column is None else clock.jitter,
        channels=tuple(found),
        notes=clock.notes,
    )


def sha256_of(path: Path) -> str:
    """The checksum of a file's bytes, hexadecimal."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
