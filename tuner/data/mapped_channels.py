"""The file from which each mapping is read."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from tuner.data.logs.error import LogError, quoted
from tuner.data.logs.mapping import Mapped, parse_maps
from tuner.data.logs.mapping import Mapping as Column
from tuner.data.logs.table import Table

if TYPE_CHECKING:
    from filters.declared import Channel

Declared: TypeAlias = "Mapping[str, Channel] | None"


@dataclass(frozen=True)
class MappedChannel:
    """One channel, or one truth, of one file.

    Attributes:
        mapped: what the user wrote.
        parts: the columns as the file names them.
        declared: the fact of the channel; None where there is none.
        truth: whether it is a truth.
    """

    mapped: Mapped
    parts: tuple[Column, ...]
    declared: "Channel | None"
    truth: bool


def parse_mappings(
    texts: Sequence[str], declared: Declared, files: Sequence[str], *, truth: bool
) -> list[tuple[Mapped, "Channel | None", bool]]:
    """The user's text for ``--map``, or for ``--truth``, parsed.

    Raises:
        LogError: for a text of another form, an unknown channel, and one that is mapped twice.
    """
    known = None if declared is None else list(declared)
    option = "--truth" if truth else "--map"
    maps = [mapped for text in texts for mapped in parse_maps(text, known, files)]
    names = [mapped.channel for mapped in maps]
    for name in names:
        if names.count(name) > 1:
            raise LogError(f"{option}: {name!r} is mapped {names.count(name)} times; map it once")
    return [(m, declared[m.channel] if declared else None, truth) for m in maps]


def assigned_to_files(
    tables: Sequence[Table], maps: Sequence[tuple[Mapped, "Channel | None", bool]]
) -> list[list[MappedChannel]] | None:
    """The channels to read from each file; None where each of several files has everything.

    Raises:
        LogError: for a column that is in no file, or in several but not in all.
    """
    holders = [_holders(tables, mapped) for mapped, _, _ in maps]
    if len(tables) > 1 and all(len(found) == len(tables) for found in holders):
        return None
    shares: list[list[MappedChannel]] = [[] for _ in tables]
    for (mapped, declared, truth), found in zip(maps, holders, strict=True):
        if not found:
            raise _nowhere(tables, mapped)
        if len(found) > 1:
            files = [tables[index].file for index in found]
            raise LogError(
                f"the column {mapped.source!r} (mapped to {mapped.channel}) is in {quoted(files)}; "
                f"say which is meant, such as {mapped.channel}={files[0]}/{mapped.source}"
            )
        ((index, parts),) = found.items()
        shares[index].append(MappedChannel(mapped, parts, declared, truth))
    for table, share in zip(tables, shares, strict=True):
        if not share:
            raise LogError(f"{table.file}: nothing is read from it; map a column of it or leave it")
    return shares


def channels_of_file(
    table: Table, maps: Sequence[tuple[Mapped, "Channel | None", bool]]
) -> list[MappedChannel]:
    """The channels to read from a file that has everything."""
    (share,) = assigned_to_files([table], maps) or [[]]
    return share


def channels_by_clock(
    table: Table, share: Sequence[MappedChannel]
) -> list[tuple[Table, list[MappedChannel]]]:
    """The channels to read from a file, for each of its clocks.

    Raises:
        LogError: for a channel whose columns are on several clocks.
    """
    if not table.groups:
        return [(table, list(share))]
    shares: dict[int, list[MappedChannel]] = {}
    for wanted in share:
        columns = {part.column for part in wanted.parts}
        holders = [i for i, group in enumerate(table.groups) if columns <= set(group.names)]
        if not holders:
            raise LogError(
                f"{table.file}: {wanted.mapped.source!r} (mapped to {wanted.mapped.channel}) are "
                "columns on several clocks; map columns of one group, or one channel each"
            )
        shares.setdefault(holders[0], []).append(wanted)
    return [(table.groups[index], shares[index]) for index in sorted(shares)]


def _holders(tables: Sequence[Table], mapped: Mapped) -> dict[int, tuple[Column, ...]]:
    """The files that have all columns of a channel, and how they name them."""
    found = {}
    for index, table in enumerate(tables):
        parts = table.find_parts(mapped) if mapped.file in ("", table.file) else None
        if parts is not None:
            found[index] = parts
    return found


def _nowhere(tables: Sequence[Table], mapped: Mapped) -> LogError:
    """The message about a missing column."""
    here = [table for table in tables if mapped.file in ("", table.file)]
    if len(here) == 1:
        for part in mapped.parts:
            here[0].resolve(part)
    files = "; ".join(f"{table.file} has {quoted(table.names[:12])}" for table in here)
    return LogError(
        f"no file has the columns {mapped.source!r} (mapped to {mapped.channel}): {files}"
    )
