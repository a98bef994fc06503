"""Recordings in one file, separated by a column."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.error import LogError
from tuner.data.logs.mapping import parse_column
from tuner.data.logs.table import Loaded, Raw, Table


def labels_of(table: Table, column: str) -> Raw:
    """The labels in a column, ``(N,)``, of numbers or text.

    Raises:
        LogError: where there is no such column, or it lacks one label per row.
    """
    found = table.resolve(parse_column("by", column))
    if table.labels is not None:
        return table.labels(found.column)
    labels = Loaded.of(table.load([found.column])).raw[found.column]
    if labels.ndim == 2 and found.index is not None:
        labels = labels[:, found.index]
    if labels.ndim != 1 or labels.dtype.kind not in "biufUS":
        raise LogError(f"{table.file}: {column!r} does not hold a label per row; name another --by")
    return labels


def split(labels: Raw) -> Iterator[tuple[str, NDArray[np.intp]]]:
    """Each label with its rows, in the order in which they appear.

    >>> [(label, rows.tolist()) for label, rows in split(np.array([7, 5, 7]))]
    [('7', [0, 2]), ('5', [1])]
    """
    values, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    for index in np.argsort(first):
        yield str(values[index]), np.flatnonzero(inverse == index)
