"""Contents of another program's log: groups of columns, each on a clock of its own."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tuner.data.logs.error import LogError
from tuner.data.logs.mapping import Mapping as Column
from tuner.data.logs.table import Raw, Table

Load = Callable[[Sequence[str]], dict[str, Raw]]


@dataclass(frozen=True)
class Group:
    """Columns that are written together, such as a topic or a sensor.

    Attributes:
        prefix: prefix of its columns' names, ``imu.``; ``""`` for none.
        columns: their names without the prefix, and the count of numbers in a row: 0 for one that
            is not an array.
        rows: number of rows; None where it is known only after loading.
        time: the name of the time column; None where it is found by name.
        time_unit: its unit.
        units: of the other columns, where the file tells them.
        notes: what was assumed of this group.
    """

    prefix: str
    columns: Mapping[str, int]
    rows: int | None = None
    time: str | None = None
    time_unit: str | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class Contents:
    """The contents of a file, before anything is loaded.

    Attributes:
        format: the kind of file, in words.
        groups: its columns.
        notes: remarks on the file.
    """

    format: str
    groups: Sequence[Group]
    notes: Sequence[str] = ()

    def plain(self) -> dict[str, Any]:
        """The contents as JSON."""
        return asdict(self)

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> "Contents":
        """The contents from JSON."""
        groups = tuple(Group(**group) for group in plain["groups"])
        return cls(plain["format"], groups, plain["notes"])


def table_of(path: Path, contents: Contents, load: Load) -> Table:
    """The table of a file: one for all of it, with one for each of several groups.

    Args:
        path: the file.
        contents: its contents.
        load: reads columns by their full names.

    Raises:
        LogError: where it holds no column.
    """
    tables = tuple(_table(path.name, group, contents, load) for group in contents.groups)
    names = tuple(dict.fromkeys(name for table in tables for name in table.names))
    if not names:
        raise LogError(f"{path.name}: the {contents.format} holds no columns; record it again")
    if len(tables) == 1:
        return tables[0]
    units = {name: unit for table in tables for name, unit in table.units.items()}
    notes = tuple(contents.notes)
    return Table(
        path.name, names, load, format=contents.format, groups=tables, units=units, notes=notes
    )


def _table(file: str, group: Group, contents: Contents, load: Load) -> Table:
    names = tuple(group.prefix + name for name in group.columns)
    time = None
    if group.time is not None:
        time = Column("time", group.prefix + group.time, unit=group.time_unit)
    return Table(
        file,
        names,
        load,
        format=contents.format,
        prefix=group.prefix,
        time=time,
        units={group.prefix + name: unit for name, unit in group.units.items()},
        widths={group.prefix + name: width for name, width in group.columns.items() if width},
        rows=group.rows,
        notes=(*contents.notes, *group.notes),
    )
