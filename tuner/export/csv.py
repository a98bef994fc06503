"""CSV: one row for each number, counted from 0; the rest in lines above that begin with #."""

import csv
import io
import json
import math
import re
from collections.abc import Iterator

import numpy as np

from tuner.export.cells import as_written, inert
from tuner.export.document import Document, flat, head, mapping, nested, sequence, tuned_from
from tuner.export.tuned import Quantity, Tuned

_COLUMNS = ["name", "row", "column", "value", "unit", "meaning"]
_SHAPES = "shapes"
_TEXTS = re.compile(r'"(?:[^"\\]|\\.)*"')
_PARTING = {ord(mark): f"\\u{ord(mark):04x}" for mark in ",;|"}


def dump(tuned: Tuned) -> bytes:
    """UTF-8 text; quoted cells are text, the others numbers.

    Row and column are empty for a number; the column is empty for a vector.
    """
    stream = io.StringIO(newline="")
    shapes = {quantity.name: list(quantity.value.shape) for quantity in tuned.quantities}
    for key, value in (flat(head(tuned)) | {_SHAPES: shapes}).items():
        stream.write(f"# {key}: {_above(value)}\n")
    # Without quotes, a carriage return in a field would end the row.
    writer = csv.writer(stream, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n")
    writer.writerow(_COLUMNS)
    for quantity in tuned.quantities:
        writer.writerows(_rows(quantity))
    return stream.getvalue().encode()


def load(data: bytes) -> Tuned:
    """The tuned filter that :func:`dump` wrote; its rows may be in another order."""
    lines = io.StringIO(data.decode("utf-8-sig"), newline="")
    above: Document = {}
    while (line := lines.readline()).startswith("#"):
        key, _, value = line.removeprefix("#").partition(":")
        above[key.strip()] = json.loads(value)
    if next(csv.reader([line]), None) != _COLUMNS:
        raise ValueError(f"its columns are not {','.join(_COLUMNS)}")
    found: dict[str, list[list[str]]] = {}
    for row in csv.reader(lines, strict=True):
        found.setdefault(row[0] if row else "", []).append(row)
    shapes = mapping("the list of shapes", above.pop(_SHAPES, None), found)
    return tuned_from(nested(above), [_quantity(found[name], shapes[name]) for name in shapes])


def _rows(quantity: Quantity) -> Iterator[list[str | int | float]]:
    for index, value in np.ndenumerate(quantity.value):
        row, column = (*index, "", "")[:2]
        texts = inert(quantity.unit), inert(quantity.meaning)
        yield [quantity.name, row, column, float(value), *texts]


def _above(value: object) -> str:
    """JSON for a line above; its texts hold no delimiters, each of which would begin a cell."""
    text = json.dumps(value, ensure_ascii=False)
    return _TEXTS.sub(lambda found: found[0].translate(_PARTING), text)


def _quantity(rows: list[list[str]], shape: object) -> Quantity:
    """The quantity of these rows, which must fill its shape."""
    name = rows[0][0]
    if any(len(row) != len(_COLUMNS) for row in rows):
        raise ValueError(f"{name!r} has a row with too many or too few columns")
    labels = {(as_written(unit), as_written(meaning)) for *_, unit, meaning in rows}
    if len(labels) > 1:
        raise ValueError(f"{name!r} has more than one unit or meaning")
    numbers = {_index(row): float(row[3]) for row in rows}
    sizes = sequence("a shape", shape)
    if math.prod(sizes) != len(rows) or sorted(numbers) != list(np.ndindex(*sizes)):
        raise ValueError(f"{name!r} has rows missing or twice")
    values = np.array([numbers[index] for index in sorted(numbers)]).reshape(sizes)
    return Quantity(name, values, *labels.pop())


def _index(row: list[str]) -> tuple[int, ...]:
    return tuple(int(number) for number in row[1:3] if number)
