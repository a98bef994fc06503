"""The user's text for ``--map`` and ``--time``: which column feeds which channel."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from tuner.data.logs.error import LogError, suggest

_COLUMN = re.compile(
    r"(?P<minus>-\s*(?=[^\s-]))?"
    r"(?P<column>.+?)\s*"
    r"(?:\[(?P<index>\d+)\]\s*)?"
    r"(?:\*(?P<factor>[^*:]*))?"
    r"(?::(?P<unit>[^*:]*))?",
    re.ASCII,
)


@dataclass(frozen=True)
class Mapping:
    """One channel and the column it is read from.

    Attributes:
        channel: name of the channel, such as ``omega``.
        column: name of the column in the file; in text files also its number, from 1.
        index: which column of a 2-D array, from 0; None for a 1-D one.
        factor: factor on the column: a number, the name of a scalar in the same file,
            or None.
        unit: the unit after the multiplication; None where none was given.
        minus: whether the sign is changed.
    """

    channel: str
    column: str
    index: int | None = None
    factor: float | str | None = None
    unit: str | None = None
    minus: bool = False

    @property
    def source(self) -> str:
        """The column as it was written, without the unit: ``gyr_degs[0]*gyr_lsb``."""
        index = "" if self.index is None else f"[{self.index}]"
        factor = "" if self.factor is None else f"*{self.factor}"
        return f"{'-' * self.minus}{self.column}{index}{factor}"


@dataclass(frozen=True)
class Mapped:
    """One channel and the columns of its axes, before any file is looked into.

    Attributes:
        channel: name of the channel.
        parts: one for each axis, or one that is taken whole.
        text: the columns as they were written, for a name that holds commas.
        file: the file that was named before the columns, ``""`` where none was.
    """

    channel: str
    parts: tuple[Mapping, ...]
    text: str
    file: str = ""

    @property
    def source(self) -> str:
        """The columns as they were written, without unit: ``gx,gy,gz``."""
        return ",".join(part.source for part in self.parts)

    @property
    def unit(self) -> str | None:
        """The unit of all parts."""
        return self.parts[-1].unit


def parse_column(channel: str, text: str) -> Mapping:
    """Read one ``column[index]*factor:unit``, a minus before it if wanted, for a channel.

    Raises:
        LogError: where the column, the factor or the unit is missing or unusable.

    Example:
        >>> parse_column("time", "t_ms*0.001").factor
        0.001
    """
    match = _COLUMN.fullmatch(text.strip())
    if match is None:
        raise LogError(f"{text!r} names no column; write column[index]*factor:unit")
    parts = {key: part.strip() for key, part in match.groupdict().items() if part is not None}
    for key, mark in (("factor", "*"), ("unit", ":")):
        if parts.get(key) == "":
            raise LogError(f"{text!r} has no {key} after {mark!r}; write it or leave {mark!r} out")
    index = int(parts["index"]) if "index" in parts else None
    factor, unit = _factor(text, parts), parts.get("unit")
    return Mapping(channel, parts["column"], index, factor, unit, "minus" in parts)


def parse_maps(
    text: str, channels: Sequence[str] | None, files: Sequence[str] = ()
) -> tuple[Mapped, ...]:
    """Read one ``NAME=COLUMNS``, or several names of a reading at once.

    COLUMNS is one column for each axis, separated by commas, or one that is taken whole. Each may
    have a minus sign, an index and a factor; the unit stands at the end and is that of all.
    Before them, ``FILE/`` says which file is meant.

    Args:
        text: the user's text.
        channels: the channels that may be mapped; None for any.
        files: the names of the files that may be named.

    Raises:
        LogError: for a text of another form, an unknown channel or an unusable factor.

    >>> (acc,) = parse_maps("acc=-ax,ay,-az:g", ["acc"])
    >>> acc.source, acc.unit
    ('-ax,ay,-az', 'g')
    >>> [(m.channel, m.source, m.unit) for m in parse_maps("x,y=lat,lon:lat,lon", None)]
    [('x', 'lat', 'lat'), ('y', 'lon', 'lon')]
    >>> parse_maps("acc=imu.csv/ax,ay,az", None, ["imu.csv"])[0].file
    'imu.csv'
    """
    left, equals, right = (part.strip() for part in text.partition("="))
    names = [name.strip() for name in left.split(",")]
    if not (equals and right and all(names)):
        raise LogError(f"{text!r} maps nothing; write NAME=COLUMN, such as 'gyr=gx,gy,gz:deg/s'")
    for name in names:
        if channels is not None and name not in channels:
            raise LogError(f"{text!r} maps no known channel: {suggest(name, channels)}")
    file = next((name for name in files if right.startswith(f"{name}/")), "")
    right = right.removeprefix(f"{file}/") if file else right
    if len(names) == 1:
        parts = _parts(names[0], right)
        return (Mapped(names[0], parts, right, file),)
    columns = _columns(text, right, len(names))
    found = [parse_column(name, column) for name, column in zip(names, columns, strict=True)]
    return tuple(Mapped(part.channel, (part,), part.source, file) for part in found)


def _parts(channel: str, right: str) -> tuple[Mapping, ...]:
    """One mapping for each column; the last one's unit is that of those without."""
    parts = [parse_column(channel, column) for column in right.split(",")]
    return tuple(replace(part, unit=part.unit or parts[-1].unit) for part in parts)


def _columns(text: str, right: str, count: int) -> list[str]:
    """The columns of several channels, each with its unit."""
    head, colon, tail = right.rpartition(":")
    units = tail.split(",") if colon and "," in tail else []
    columns = head.split(",") if units else right.split(",")
    if len(columns) != count or len(units) not in (0, count):
        raise LogError(f"{text!r} has {count} names and {len(columns)} columns; write as many")
    if units:
        return [f"{column}:{unit}" for column, unit in zip(columns, units, strict=True)]
    _, colon, unit = right.rpartition(":")
    return [column if ":" in column or not colon else f"{column}:{unit}" for column in columns]


def _factor(text: str, parts: dict[str, str]) -> float | str | None:
    """The number in a text, else the text as the name of a scalar."""
    if "factor" not in parts:
        return None
    try:
        number = float(parts["factor"])
    except ValueError:
        return parts["factor"]
    if not math.isfinite(number) or number == 0.0:
        raise LogError(f"{text!r} multiplies by {number:g}; the factor must be finite and not 0")
    return number
