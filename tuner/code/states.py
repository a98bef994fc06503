"""States and samples to try a filter's step on: near those of a record, and far from them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import numpy as np

from tuner.code.covariances import definite, largest, some_huge, symmetric
from tuner.code.fields import Field
from tuner.code.literal import Precision
from tuner.code.program import Program

Arrays: TypeAlias = list[np.ndarray]
_FAR, _NOTHING, _SPARSE, _SOME = 0.5, 0.05, 0.3, 0.7
_RESTING, _FIRST, _STILL = 0.4, 0.1, 0.1
_WIDE = 7.0
"""Powers of ten by which a covariance is farther off than all else."""


@dataclass(frozen=True, eq=False)
class Around:
    """Where states and samples are drawn.

    Attributes:
        state: the fields of the state.
        inputs: those of a sample.
        states: states that a filter was in, a field each, ``(N, ...)``.
        samples: the sample that came then, a field each.
        resting: number of states, the last ones, in which nothing changed any more.
        wide: powers of ten that the precision has, where covariances are much farther off than all
            else: what makes up for rounding shows only there, and long steps have no time to be
            brought there. 0: they are not.
    """

    state: Sequence[Field]
    inputs: Sequence[Field]
    states: Arrays
    samples: Arrays
    resting: int = 0
    wide: float = 0.0

    def drawn(self, draw: np.random.Generator, count: int) -> tuple[Arrays, Arrays]:
        """States and samples, a field each, ``(count, ...)``."""
        at = self._rows(draw, count)
        row = np.where(draw.random(count) < 1 / 2, at, self._rows(draw, count))
        still = (draw.random(count) < _STILL) & (self.resting > 0)
        if self.resting:
            whole = next(len(x) for x in (*self.states, *self.samples))
            at = np.where(still, whole - 1 - draw.integers(self.resting, size=count), at)
            row = np.where(still, at, row)
        states = _all_drawn(draw, self.state, [x[at] for x in self.states], still, self.wide)
        samples = _all_drawn(draw, self.inputs, [x[row] for x in self.samples], still)
        return states, [_with_holes(draw, x) for x in samples]

    def _rows(self, draw: np.random.Generator, count: int) -> np.ndarray:
        """Rows of the record, of those at rest, or the first, where some filters begin anew."""
        whole = next((len(x) for x in (*self.states, *self.samples)), 1)
        rows = draw.integers(whole - self.resting, size=count)
        if self.resting:
            still = whole - 1 - draw.integers(self.resting, size=count)
            rows = np.where(draw.random(count) < _RESTING, still, rows)
        return np.where(draw.random(count) < _FIRST, 0, rows)


def _all_drawn(
    draw: np.random.Generator,
    fields: Sequence[Field],
    near: Arrays,
    still: np.ndarray,
    wide: float = 0.0,
) -> Arrays:
    """Values near given ones, or farther off in all fields or in some.

    Where all is still only symmetric matrices are farther off: whether a filter is at rest is not
    decided by its covariance.
    """
    count = len(near[0]) if near else 0
    far = draw.choice([0.0, 0.3, 1.0, 3.0], count)
    some = draw.random(count) < 1 / 2
    found = []
    for f, x in zip(fields, near, strict=True):
        off = np.where(some & (draw.random(count) < _SOME), 0.0, far)
        if f.half and wide:
            off = np.where(still[:count] | (draw.random(count) < 1 / 2), off, _WIDE)
        values = _drawn(draw, f, x, off if f.half else np.where(still[:count], 0.0, off))
        if f.half and wide:
            values = some_huge(draw, x, values, wide)
        found.append(values)
    return found


def _drawn(
    draw: np.random.Generator, field: Field, near: np.ndarray, far: np.ndarray
) -> np.ndarray:
    """Values near given ones, or farther off by some powers of ten, or without some entries."""
    count, axes = len(near), (slice(None), *[None] * (near.ndim - 1))
    if field.kind == "truth":
        return np.where((draw.random(near.shape) < 0.3) & (far[axes] > 0), ~near, near)
    if field.kind == "whole":
        other = draw.integers(0, 2 * np.abs(near).max(initial=1) + 2, near.shape)
        return np.where(far[axes] > _FAR, other, near)
    whole = (10 ** (far * draw.uniform(-1, 1, count)) * (draw.random(count) > _NOTHING))[axes]
    if symmetric(near):
        return definite(draw, near, far) * whole
    each = 10 ** (
        (draw.choice([0.0, 0.5, 1.0], count) * far)[axes] * draw.uniform(-1, 1, near.shape)
    )
    size = largest(near)[axes]
    moved = draw.choice([0.0, 0.01, 1.0], count)[axes] * (far[axes] > 0)
    empty = (
        (draw.random(near.shape) < 1 / 2) & (draw.random(count) < _SPARSE)[axes] & (far[axes] > 0)
    )
    with np.errstate(over="ignore", invalid="ignore"):  # what is no number is not tried
        found = (near + moved * size * draw.normal(size=near.shape)) * whole * each
    return np.where(empty, 0.0, found)


def _with_holes(draw: np.random.Generator, values: np.ndarray) -> np.ndarray:
    if values.dtype.kind != "f":
        return values
    holes = (draw.random(values.shape) < 0.3) & (draw.random(len(values)) < 0.2).reshape(
        (-1,) + (1,) * (values.ndim - 1)
    )
    return np.where(holes, np.nan, values)


def by_node(program: Program, states: Arrays, samples: Arrays) -> dict[int, np.ndarray]:
    """States and samples by the nodes of their stored entries."""
    found: dict[int, np.ndarray] = {}
    for group, fields, arrays in (
        ("state", program.state, states),
        ("in", program.inputs, samples),
    ):
        for f, nodes, array in zip(fields, program.known[group], arrays, strict=True):
            flat = array.reshape(len(array), math.prod(array.shape[1:]))
            found |= {nodes.flat[k]: flat[:, k] for k in _stored(f)}
    return found


@cache
def _stored(field: Field) -> list[int]:
    """The places of the stored entries among all."""
    shape = field.shape
    return [int(np.ravel_multi_index(index, shape)) if index else 0 for index in field.entries()]


def column(array: np.ndarray, index: tuple[int, ...]) -> np.ndarray:
    """An entry of each of many arrays, which are stacked along the first axis."""
    flat = array.reshape(len(array), math.prod(array.shape[1:]))
    return np.asarray(flat[:, int(np.ravel_multi_index(index, array.shape[1:])) if index else 0])


def by_field(fields: list[Field], rows: np.ndarray) -> tuple[Arrays, np.ndarray]:
    """Rows of stored entries as arrays ``(B, ...)`` of each field, and the rows that remain."""
    found = []
    for field in fields:
        own, rows = rows[: field.size], rows[field.size :]
        array = np.zeros((own.shape[1], *field.shape))
        for row, index in zip(own, field.entries(), strict=True):
            array[_at(index)] = row
            if field.half:
                array[_at(index[::-1])] = row
        found.append(array)
    return found, rows


def _at(index: tuple[int, ...]) -> tuple[slice | int, ...]:
    return (slice(None), *index)


def rounded(arrays: Arrays, precision: Precision) -> Arrays:
    """Numbers that the precision has."""
    if precision == "double":
        return arrays
    with np.errstate(all="ignore"):
        return [x.astype(np.float32).astype(float) if x.dtype.kind == "f" else x for x in arrays]
