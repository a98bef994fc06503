"""Loading of a file's columns, and of those that hold its times."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from tuner.data.logs.mapping import Mapped, Mapping, parse_maps
from tuner.data.logs.table import Raw, Table
from tuner.data.logs.timename import is_time
from tuner.data.logs.timing import RESTART, restarts, timing_names, without_repeats
from tuner.data.logs.values import Columns, load_columns
from tuner.data.mapped_channels import MappedChannel
from tuner.data.splitting import labels_of


@dataclass(frozen=True)
class File:
    """One file, or the columns of one clock of it, and the channels read from them.

    Attributes:
        path: of the file.
        table: its columns.
        wanted: the channels.
        digest: gives the SHA-256 of its bytes.
    """

    path: Path
    table: Table
    wanted: tuple[MappedChannel, ...]
    digest: Callable[[], str]


@dataclass(frozen=True)
class Timed:
    """The user's statement of when samples were taken.

    Attributes:
        time: the time column, or several whose sum it is; None finds them.
        rate_hz: samples per second.
        drop_repeats: whether rows with the time of the row before are left out.
    """

    time: str | None
    rate_hz: float | None
    drop_repeats: bool

    @cached_property
    def mapped_time(self) -> Mapped | None:
        """The time columns before any file is looked into."""
        return None if self.time is None else parse_maps(f"time={self.time}", None)[0]

    def check_somewhere(self, tables: Sequence[Table]) -> None:
        """Refuse time columns that are in none of several files."""
        if self.mapped_time and all(table.find_parts(self.mapped_time) is None for table in tables):
            _resolved(tables[0], self.mapped_time)


def loaded(
    file: File, timed: Timed, *, optional: bool = False
) -> tuple[Columns, tuple[Mapping, ...] | None]:
    """The needed columns of a file, and its time columns where the user named them.

    Args:
        file: the file.
        timed: the user's statement of when samples were taken.
        optional: whether it may lack the time columns.

    Raises:
        LogError: where a column is missing or cannot be read.
    """
    parts = [part for one in file.wanted for part in one.parts]
    time = file.table.find_parts(timed.mapped_time) if timed.mapped_time else None
    if timed.mapped_time and time is None and not optional:
        time = _resolved(file.table, timed.mapped_time)
    if time is not None:
        return load_columns(file.table, [*parts, *time], ()), time
    return load_columns(file.table, parts, timing_names(file.table)), None


def _resolved(table: Table, time: Mapped) -> tuple[Mapping, ...]:
    return tuple(table.resolve(part) for part in time.parts)


def has_time(table: Table, named: Sequence[Mapping] | None) -> bool:
    """Whether a file has times of its own."""
    if named is not None or table.time is not None or table.moments:
        return True
    return any(is_time(name.removeprefix(table.prefix)) for name in table.names)


def once_each(
    file: File, columns: Columns, time: Sequence[Mapping] | None, timed: Timed
) -> Columns:
    """The columns without repeated times where that is asked for."""
    return (
        without_repeats(columns, time, _samples(file, columns)) if timed.drop_repeats else columns
    )


def labels_in(file: File, columns: Columns, time: Sequence[Mapping] | None, by: str) -> Raw:
    """The label of each row's recording, ``(N,)``: a column, or where the time starts again.

    Raises:
        LogError: where there is no such column, or it lacks one label per row.
    """
    if by == RESTART and by not in file.table.names:
        return restarts(columns, time, _samples(file, columns))
    return labels_of(file.table, by)


def _samples(file: File, columns: Columns) -> int:
    return len(columns.raw[file.wanted[0].parts[0].column])
