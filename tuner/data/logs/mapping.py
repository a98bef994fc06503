"""What a user wrote for ``--map`` and ``--time``: which column feeds which channel."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from tuner.data.logs.error import LogError, suggest

_COLUMN = re.compile(
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
        factor: what the column is multiplied by: a number, the name of a scalar in the same
            file, or None.
        unit: the unit after the multiplication; None where none was given.
    """

    channel: str
    column: str
    index: int | None = None
    factor: float | str | None = None
    unit: str | None = None

    @property
    def source(self) -> str:
        """The column as it was written, without the unit: ``gyr_degs[0]*gyr_lsb``."""
        index = "" if self.index is None else f"[{self.index}]"
        factor = "" if self.factor is None else f"*{self.factor}"
        return f"{self.column}{index}{factor}"


def parse_mapping(text: str, channels: Sequence[str]) -> Mapping:
    """Read one ``NAME=COLUMN``, where COLUMN is ``column[index]*factor:unit``.

    Args:
        text: what the user wrote; index, factor and unit may be left out.
        channels: the channels that may be mapped.

    Raises:
        LogError: for a text of another form, an unknown channel or an unusable factor.

    Example:
        >>> parse_mapping("omega=gyr_degs[0]*0.05:deg/s", ["omega", "theta"])
        Mapping(channel='omega', column='gyr_degs', index=0, factor=0.05, unit='deg/s')
    """
    channel, equals, column = (part.strip() for part in text.partition("="))
    if not (channel and equals and column):
        raise LogError(f"{text!r} maps nothing; write NAME=COLUMN, such as 'omega=gyr[0]:deg/s'")
    if channel not in channels:
        raise LogError(f"{text!r} maps no known channel: {suggest(channel, channels)}")
    return parse_column(channel, column)


def parse_column(channel: str, text: str) -> Mapping:
    """Read one ``column[index]*factor:unit`` for a channel.

    Raises:
        LogError: where the column, the factor or the unit is missing or unusable.

    Example:
        >>> parse_column("time", "t_ms*0.001")
        Mapping(channel='time', column='t_ms', index=None, factor=0.001, unit=None)
    """
    match = _COLUMN.fullmatch(text.strip())
    if match is None:
        raise LogError(f"{text!r} names no column; write column[index]*factor:unit")
    parts = {key: part.strip() for key, part in match.groupdict().items() if part is not None}
    for key, mark in (("factor", "*"), ("unit", ":")):
        if parts.get(key) == "":
            raise LogError(f"{text!r} has no {key} after {mark!r}; write it or leave {mark!r} out")
    index = int(parts["index"]) if "index" in parts else None
    return Mapping(channel, parts["column"], index, _factor(text, parts), parts.get("unit"))


def _factor(text: str, parts: dict[str, str]) -> float | str | None:
    """A number where it is one, else the name of a scalar."""
    if "factor" not in parts:
        return None
    try:
        number = float(parts["factor"])
    except ValueError:
        return parts["factor"]
    if not math.isfinite(number) or number == 0.0:
        raise LogError(f"{text!r} multiplies by {number:g}; the factor must be finite and not 0")
    return number
