"""The objects of a MAT v5 file that hold columns: table, timetable, datetime and duration.

MathWorks documents none of it; the reading here follows the description of the package mat-io
(github.com/foreverallama/matio, docs): a file keeps the properties of all its objects in one cell
array, whose first cell says in 32-bit words which cell is which property of which object.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tuner.data.mat import Cells, Numbers, Opaque, Structs, Value, elements

_REFERENCE = 0xDD000000
_WORDS = "u4"
_NAME, _CELL = 0, 1  # kinds of properties: the others are small numbers
_FIRST_CELL = 2

Words = NDArray[np.uint32]


@dataclass(frozen=True)
class Objects:
    """The properties of all objects of a file.

    Attributes:
        names: of classes and properties.
        classes: four words per class; the second is its name.
        objects: six words per object: its class first, its properties fourth and fifth.
        saved: properties of objects that save themselves in a form of their own.
        plain: properties of the others.
        cells: the values.
    """

    names: Sequence[str]
    classes: Words
    objects: Words
    saved: Words
    plain: Words
    cells: Sequence[Value]

    @classmethod
    def of(cls, subsystem: Numbers) -> "Objects":
        """From the bytes that a MAT file keeps in a variable without a name.

        Raises:
            ValueError: where they are malformed.
        """
        data = subsystem.astype(np.uint8).tobytes(order="F")
        order = "<" if data[2:4] == b"IM" else ">"
        wrapper: Value = None
        for value in elements(data[8:], order):
            if isinstance(value, Structs) and "MCOS" in value.fields:
                wrapper = value.fields["MCOS"][0]
        cells = wrapper.reference if isinstance(wrapper, Opaque) else None
        if not isinstance(cells, Cells) or not isinstance(cells.values[0], np.ndarray):
            raise ValueError("it holds objects without their properties")
        head = cells.values[0].astype(np.uint8).tobytes(order="F")
        ends = np.frombuffer(head, order + _WORDS, 6, 8).tolist()
        names = [name.decode("latin-1") for name in head[40 : ends[0]].split(b"\0") if name]
        regions = [
            np.frombuffer(head[ends[k] : ends[k + 1]], order + _WORDS).astype(np.uint32)
            for k in range(4)
        ]
        classes, saved, objects, plain = regions
        return cls(names, classes, objects, saved, plain, cells.values)

    def kind(self, reference: Value) -> str:
        """The class of an object; ``""`` for anything else."""
        words = _words(reference)
        if words is None:
            return ""
        return self.names[int(self.classes[4 * int(words[-1]) + 1]) - 1]

    def properties(self, reference: Value) -> dict[str, Value]:
        """The properties of one object by name.

        Raises:
            ValueError: where the reference is not to one object.
        """
        words = _words(reference)
        if words is None or len(words) != int(words[1]) + 4:
            raise ValueError("it holds an array of objects where one is needed")
        record = self.objects[6 * int(words[-2]) : 6 * int(words[-2]) + 6]
        saved, plain = int(record[3]), int(record[4])
        triples = _record(self.saved, saved) if saved else _record(self.plain, plain)
        return {self.names[int(n) - 1]: self._held(int(k), int(v)) for n, k, v in triples}

    def _held(self, kind: int, value: int) -> Value:
        if kind == _CELL:
            return self.cells[_FIRST_CELL + value]
        return self.names[value - 1] if kind == _NAME else np.array([[value]])


@dataclass(frozen=True)
class Columns:
    """A table or timetable.

    Attributes:
        columns: numbers ``(N,)`` or ``(N, k)`` by name.
        units: of the columns, where they are known.
        time: the name of the column of row times, of a timetable.
        left: the columns that are neither numbers nor times.
    """

    columns: dict[str, Numbers]
    units: dict[str, str] = field(default_factory=dict)
    time: str | None = None
    left: tuple[str, ...] = ()


def columns_of(objects: Objects, reference: Value) -> Columns | None:
    """The columns of a table, a timetable, a datetime or a duration; None for another object.

    Raises:
        ValueError: where it is malformed.
    """
    kind = objects.kind(reference)
    if kind in ("datetime", "duration"):
        numbers, unit = _times(objects, reference)
        return Columns({"": numbers}, {"": unit})
    if kind == "table":
        held = objects.properties(reference)
        return _columns(objects, held.get("data"), _texts(held.get("varnames")), _units(held))
    if kind != "timetable":
        return None
    inner = _fields(objects.properties(reference).get("any"))
    names = _texts(inner.get("varNames"))
    found = _columns(objects, inner.get("data"), names, _texts(inner.get("varUnits")))
    time = (_texts(inner.get("dimNames")) or ["Time"])[0]
    rows = int(_number(inner.get("numRows")))
    if any(len(column) != rows for column in found.columns.values()):
        raise ValueError("it holds a timetable whose columns do not have its number of rows")
    numbers, unit = _row_times(objects, inner.get("rowTimes"), rows)
    columns, units = {time: numbers, **found.columns}, {time: unit, **found.units}
    return Columns(columns, units, time, found.left)


def _words(reference: Value) -> Words | None:
    """The words of a reference: a mark, its dimensions, its objects and its class."""
    if isinstance(reference, Opaque):
        reference = reference.reference
    if not isinstance(reference, np.ndarray) or reference.dtype != np.uint32:
        return None
    words = reference.ravel(order="F")
    return words if len(words) >= 6 and words[0] == _REFERENCE else None


def _record(region: Words, number: int) -> Words:
    """The triples of one record, which has its length first and an even number of words."""
    at = 2
    for _ in range(number - 1):
        at += 1 + 3 * int(region[at])
        at += at % 2
    count = int(region[at])
    return region[at + 1 : at + 1 + 3 * count].reshape(count, 3)


def _columns(objects: Objects, data: Value, names: list[str], units: list[str]) -> Columns:
    values = data.values if isinstance(data, Cells) else []
    columns, units_of, left = {}, {}, []
    for place, (name, value) in enumerate(zip(names, values, strict=True)):
        if objects.kind(value) in ("datetime", "duration"):
            columns[name], units_of[name] = _times(objects, value)
        elif isinstance(value, np.ndarray) and _words(value) is None:
            columns[name] = value
        else:
            left.append(name)
        if place < len(units) and units[place] and name in columns and name not in units_of:
            units_of[name] = units[place]
    return Columns(columns, units_of, left=tuple(left))


def _units(held: dict[str, Value]) -> list[str]:
    return _texts(_fields(held.get("props")).get("VariableUnits"))


def _fields(value: Value) -> dict[str, Value]:
    """The fields of a single struct."""
    if not isinstance(value, Structs):
        return {}
    return {name: values[0] for name, values in value.fields.items() if values}


def _texts(value: Value) -> list[str]:
    if not isinstance(value, Cells):
        return []
    return [text if isinstance(text, str) else "" for text in value.values]


def _number(value: Value) -> Any:
    if not isinstance(value, np.ndarray) or value.size != 1:
        raise ValueError("it holds a timetable without a number of rows or a rate")
    return value.item()


def _times(objects: Objects, reference: Value) -> tuple[Numbers, str]:
    """A datetime in nanoseconds since 1970, or a duration in milliseconds."""
    if objects.kind(reference) not in ("datetime", "duration"):
        raise ValueError("it holds times that are neither dates nor durations")
    held = objects.properties(reference)
    name = "data" if objects.kind(reference) == "datetime" else "millis"
    # An empty duration is the default of its class, which files leave out.
    numbers = held.get(name, np.zeros((1, 1)) if name == "millis" else None)
    if not isinstance(numbers, np.ndarray):
        raise ValueError("it holds times that are no numbers")
    if name == "millis":
        return numbers.real.astype(np.float64), "ms"
    whole = np.floor(numbers.real)  # the imaginary part holds what the real one rounds away
    if not np.isfinite(whole).all() or np.abs(whole).max(initial=0) > 9e12:
        return numbers.real.astype(np.float64), "ms"
    finest = 1.0 if np.iscomplexobj(numbers) else 1000.0  # ns; one double alone resolves 0.2 us
    rest = np.round((numbers.real - whole + numbers.imag) * 1e6 / finest) * finest
    return whole.astype(np.int64) * 1_000_000 + rest.astype(np.int64), "ns"


def _row_times(objects: Objects, value: Value, rows: int) -> tuple[Numbers, str]:
    """The times of a timetable's rows: written one by one, or by a step."""
    if not isinstance(value, Structs):
        return _times(objects, value)
    held = _fields(value)
    origin, unit = _times(objects, held.get("origin"))
    if bool(_number(held.get("specifiedAsRate"))):
        step = 1000.0 / float(_number(held.get("sampleRate")))
    else:
        step = float(_times(objects, held.get("stepSize"))[0].item())
    since = step * np.arange(rows)
    if unit == "ms":
        return origin.item() + since, unit
    return origin.item() + np.round(1e6 * since).astype(np.int64), unit
