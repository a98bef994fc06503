"""Message descriptions in ArduPilot's DataFlash logs: columns, scales and units.

Format: ArduPilot, libraries/AP_Logger/LogStructure.h.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tuner.data.logs.contents import Group
from tuner.data.logs.table import Raw

FORMAT = "ArduPilot DataFlash log"
MOST_INSTANCES = 256
"""A column with more values does not tell sensors apart."""
DESCRIPTIONS = {
    "FMT": ("BBnNZ", ("Type", "Length", "Name", "Format", "Columns")),
    "FMTU": ("QBNN", ("TimeUS", "FmtType", "UnitIds", "MultIds")),
    "UNIT": ("QbZ", ("TimeUS", "Id", "Label")),
    "MULT": ("Qbd", ("TimeUS", "Id", "Mult")),
}
"""The messages that describe the others."""

# The code of a column, its type, and what its integers are divided by.
_CODES: dict[str, tuple[str, float]] = {
    "a": ("32<i2", 1), "b": ("i1", 1), "B": ("u1", 1), "c": ("<i2", 1e2), "C": ("<u2", 1e2),
    "d": ("<f8", 1), "e": ("<i4", 1e2), "E": ("<u4", 1e2), "f": ("<f4", 1), "g": ("<f2", 1),
    "h": ("<i2", 1), "H": ("<u2", 1), "i": ("<i4", 1), "I": ("<u4", 1), "L": ("<i4", 1e7),
    "M": ("u1", 1), "n": ("S4", 1), "N": ("S16", 1), "q": ("<i8", 1), "Q": ("<u8", 1),
    "Z": ("S64", 1),
}  # fmt: skip
_TIMES = {"TimeUS": "us", "TimeMS": "ms"}
_PREFIXES = {1.0: "", 1e-1: "d", 1e-2: "c", 1e-3: "m", 1e-6: "u", 1e-9: "n"}
# Names of units as ArduPilot writes them, where ours differ; others are left out.
_UNITS = {
    "m/s/s": "m/s^2", "deg/s/s": "deg/s^2", "rad/s/s": "rad/s^2", "degheading": "deg",
    "deglatitude": "deg", "deglongitude": "deg", "Gauss": "gauss",
}  # fmt: skip


@dataclass(frozen=True)
class Message:
    """One kind of message.

    Attributes:
        name: four letters at most, ``IMU``.
        codes: one letter per column.
        columns: their names.
        unit_ids: one letter per column, a key of the log's units; ``""`` where none are given.
        mult_ids: one letter per column, a key of the log's multipliers.
    """

    name: str
    codes: str
    columns: tuple[str, ...]
    unit_ids: str = ""
    mult_ids: str = ""

    @property
    def dtype(self) -> np.dtype[np.void] | None:
        """The record after the head; None where the description contradicts itself."""
        known = all(code in _CODES for code in self.codes)
        if not known or len(self.codes) != len(self.columns) or not all(self.columns):
            return None
        if len(set(self.columns)) < len(self.columns):
            return None
        return np.dtype([(n, _CODES[c][0]) for n, c in zip(self.columns, self.codes, strict=True)])

    @property
    def instance(self) -> str | None:
        """The column that distinguishes several sensors of a kind."""
        place = self.unit_ids.find("#")
        return self.columns[place] if 0 <= place < len(self.columns) else None

    def scaled(self, name: str, column: Raw) -> Raw:
        """A column as numbers or text: integers that stand for fractions are divided."""
        divisor = _CODES[self.codes[self.columns.index(name)]][1]
        if column.dtype.kind == "S":
            return np.char.decode(column, "latin-1")
        return column if divisor == 1 or column.ndim > 1 else column / divisor


@dataclass(frozen=True)
class Scales:
    """Meaning of the letters of ``unit_ids`` and ``mult_ids`` in one log."""

    units: Mapping[str, str] = field(default_factory=dict)
    mults: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, units: Iterable[Sequence[Any]], mults: Iterable[Sequence[Any]]) -> "Scales":
        """From the rows (time, letter's number, meaning) of UNIT and MULT."""
        return cls(
            {chr(int(letter) % 256): plain_text(unit) for _, letter, unit in units},
            {chr(int(letter) % 256): float(mult) for _, letter, mult in mults},
        )

    def units_of(self, message: Message) -> dict[str, str]:
        """The unit of each column's numbers, where the log gives it."""
        letters = zip(
            message.columns, message.codes, message.unit_ids, message.mult_ids, strict=False
        )  # the letters may be fewer
        found = {}
        for name, code, letter, mult in letters:
            unit = self.units.get(letter, "")
            own = 1.0 if _CODES[code][1] != 1 else self.mults.get(mult, 1.0) or 1.0
            if unit and letter != "#" and own in _PREFIXES:
                found[name] = _PREFIXES[own] + _UNITS.get(unit, unit)
        return found


def group_of(prefix: str, message: Message, rows: int, scales: Scales) -> Group:
    """The columns of a message under one name, ``IMU[0].``"""
    columns = {
        name: 32 if code == "a" else 0
        for name, code in zip(message.columns, message.codes, strict=True)
    }
    time = next((name for name in _TIMES if name in columns), None)
    units = scales.units_of(message)
    unit = None if time is None else _TIMES[time]
    return Group(prefix, columns, rows, time, unit, units)


def plain_text(text: "bytes | str") -> str:
    """The text before the first zero byte."""
    return (text if isinstance(text, str) else text.decode("latin-1")).partition("\0")[0]
