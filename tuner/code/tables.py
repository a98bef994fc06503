"""Constant arrays in C: one number for all entries, one on the diagonal, or a table."""

import re
from collections.abc import Iterable

import numpy as np

from tuner.code.flat import wrapped
from tuner.code.literal import Precision, literal, type_of
from tuner.code.memory import Held, Index, Lazy, view
from tuner.code.operations import Kind, kind_of

_SIZE = re.compile(r"\[(\d+)\]")


class Tables:
    """The tables of a source file; equal ones are one.

    Args:
        stem: prefix of their names.
        precision: of real numbers.

    Attributes:
        beyond: entries behind the last one that are read without effect.
    """

    def __init__(self, stem: str, precision: Precision) -> None:
        self.stem, self.precision, self.beyond = stem, precision, 0
        self._names: dict[tuple[str, bytes], str] = {}
        self._lines: dict[str, str] = {}

    def read(self, values: np.ndarray) -> Held:
        """A constant array to be read."""
        kind = kind_of(values.dtype)
        first = values.ravel()[0] if values.size else 0
        if values.size and np.array_equal(
            values, np.full_like(values, first), equal_nan=kind == "real"
        ):
            text = self._number(first, kind)
            return Lazy(values.shape, kind, lambda _: text, number=float(first))
        if not _is_diagonal(values):
            return view(self._name(values, kind), values.shape, kind)
        on, off = (self._number(values[0, k], kind) for k in (0, 1))

        def diagonal(index: Index) -> str:
            if index[0] == index[1]:
                return on
            if isinstance(index[0], int) and isinstance(index[1], int):
                return off
            return f"(({index[0]} == {index[1]}) ? {on} : {off})"

        return Lazy(values.shape, kind, diagonal)

    @property
    def names(self) -> Iterable[str]:
        """Their names."""
        return self._lines

    def used(self, lines: Iterable[str]) -> list[str]:
        """The definitions of the tables that lines use."""
        text = "\n".join(lines)
        found = [line for name, line in self._lines.items() if re.search(rf"\b{name}\b", text)]
        return [_SIZE.sub(lambda n: f"[{int(n[1]) + self.beyond}]", line, 1) for line in found]

    def _number(self, value: object, kind: Kind) -> str:
        text = literal(value, kind, self.precision)
        return f"({text})" if text.startswith(("-", "(")) else text

    def _name(self, values: np.ndarray, kind: Kind) -> str:
        key = (type_of(kind, self.precision), values.tobytes())
        if key not in self._names:
            name = self._names[key] = f"{self.stem}_table{len(self._names)}"
            numbers = ", ".join(literal(x, kind, self.precision) for x in values.ravel())
            head = f"static const {key[0]} {name}[{values.size}]"
            self._lines[name] = wrapped(f"{head} = {{{numbers}}};", before=r" ")
        return self._names[key]


def _is_diagonal(values: np.ndarray) -> bool:
    n = len(values) if values.ndim else 0
    if values.shape != (n, n) or n < 2:
        return False
    on = np.eye(n, dtype=bool)
    return bool((values[on] == values[0, 0]).all() and (values[~on] == values[0, 1]).all())
