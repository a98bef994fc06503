"""Arrays in C: strided memory, and expressions of an index."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tuner.code.operations import Kind

Index: TypeAlias = "Sequence[int | str]"
"""Numbers and names of loop variables, one for each axis."""


@dataclass(frozen=True)
class View:
    """Strided memory.

    Attributes:
        buffer: its name in C.
        shape: its axes.
        kind: of its entries.
        base: first position: a number, or an expression.
        strides: distance of neighbouring entries along each axis.
        alone: whether it is a scalar variable.
    """

    buffer: str
    shape: tuple[int, ...]
    kind: Kind
    base: int | str = 0
    strides: tuple[int, ...] = ()
    alone: bool = False

    @property
    def buffers(self) -> frozenset[str]:
        """The memory that it reads."""
        return frozenset({self.buffer})

    def at(self, index: Index) -> str:
        """An entry."""
        if self.alone:
            return self.buffer
        return f"{self.buffer}[{total(self.base, *map(times, self.strides, index))}]"


@dataclass(frozen=True)
class Lazy:
    """An expression of the index, which may require statements before it.

    Attributes:
        shape: its axes.
        kind: of its entries.
        at: an entry: a name, a number, a call, or in brackets.
        buffers: the memory that it reads.
        number: the common value of all entries, where it is known.
    """

    shape: tuple[int, ...]
    kind: Kind
    at: Callable[[Index], str]
    buffers: frozenset[str] = frozenset()
    number: float | None = None


@dataclass(frozen=True, eq=False)
class Listed:
    """Entries in a variable each.

    Attributes:
        texts: their names.
        kind: of the entries.
    """

    texts: np.ndarray
    kind: Kind

    @property
    def shape(self) -> tuple[int, ...]:
        """The axes."""
        return self.texts.shape


Held: TypeAlias = View | Lazy


def view(buffer: str, shape: tuple[int, ...], kind: Kind) -> View:
    """All of some memory, rows first."""
    return View(buffer, shape, kind, 0, rows_first(shape), alone=not shape)


def rows_first(shape: Sequence[int]) -> tuple[int, ...]:
    """The strides of a row-major array.

    >>> rows_first((2, 3))
    (3, 1)
    """
    return tuple(math.prod(shape[k + 1 :]) for k in range(len(shape)))


def total(*terms: int | str) -> str:
    """A sum of positions.

    >>> total(0, "3 * i1", 2), total(0, "0")
    ('(3 * i1) + 2', '0')
    """
    number = sum(term for term in terms if isinstance(term, int))
    texts = [term for term in terms if isinstance(term, str) and term != "0"]
    found = [*texts, *([str(number)] if number or not texts else [])]
    if len(found) > 1:
        flat = [re.sub(r"\([^()]*\)", "", text) for text in found]
        found = [
            f"({text})" if re.search(r" [*-] ", outer) else text
            for text, outer in zip(found, flat, strict=True)
        ]
    return " + ".join(found)


def times(stride: int, index: int | str) -> int | str:
    """A stride times an index.

    >>> times(3, 2), times(3, "i1"), times(1, "i1"), times(0, "i1")
    (6, '3 * i1', 'i1', 0)
    """
    if isinstance(index, int):
        return stride * index
    if stride == 0:
        return 0
    if stride == 1:
        return index
    return f"{stride} * {index}" if re.fullmatch(r"\w+", index) else f"{stride} * ({index})"


def affine(places: np.ndarray) -> tuple[int, tuple[int, ...]] | None:
    """Base and strides of a table of positions; None where it is not affine.

    >>> affine(np.array([[1, 4], [2, 5]]))
    (1, (1, 3))
    """
    if not places.size:
        return 0, (0,) * places.ndim
    base, grid = int(places.ravel()[0]), np.zeros(places.shape, int)
    strides = []
    for axis, size in enumerate(places.shape):
        second = np.take(places, 1, axis).ravel()[0] if size > 1 else base
        strides.append(int(second) - base)
        grid = grid + strides[-1] * np.arange(size).reshape(
            [-1 if k == axis else 1 for k in range(places.ndim)]
        )
    return (base, tuple(strides)) if np.array_equal(grid + base, places) else None
