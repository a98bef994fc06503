"""Small linear programs, many side by side, inside compiled code: the dual simplex method.

    minimise c's  subject to  A (p, s) >= b,  s >= 0,  with c >= 0 and p free.

Rows of A that determine p give a start, (p from these, s = 0), with the multipliers (0, c): not
feasible yet, but its cost is a lower bound. Every step lets in the row that is broken most and lets
out the one whose multiplier reaches zero first, so that the bound rises until no row is broken
(Lemke 1954; Chvatal 1983, ch. 10). The programs lie along the last axis and take their steps
together; nothing is looked up by an index, so that the processor's vectors hold programs.
"""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array, lax

KEPT = 1e-10
"""Largest violation of a row at an optimum; data are scaled to 1."""
_BROKEN = 1e-12  # rounding left by some tens of exchanges is no reason for another one
_PIVOT = 1e-9  # a divisor below it would lose more digits than the last Newton step gives back
_TIE = 1e-12  # multipliers that reach zero together but for rounding: the largest divisor is taken


class Optimum(NamedTuple):
    """The end of the dual simplex method, for L programs.

    Attributes:
        z: (p, s), ``(free + c, L)``. Its first derivative by A and b is exact where it is unique.
        multiplier: the least of the multipliers that prove it, ``(L,)``: above rounding, z is
            unique; about 0, several z may be optimal; NaN where no optimum was found.
    """

    z: Array
    multiplier: Array


class _Table(NamedTuple):
    """The simplex tableau: everything in terms of the basis, the rows that hold with equality.

    Attributes:
        body: of A's rows, of z and of the cost, ``(rows + unknowns + 1, unknowns + 1, L)``; the
            last column is the value where nothing is to spare.
        basis: which row a column stands for, from 0, ``(unknowns, L)``; of A's rows, then of z.
    """

    body: Array
    basis: Array


def optimum(A: Array, b: Array, c: Array) -> Optimum:
    """The optimum of L programs.

    Args:
        A: ``(rows, free + spreads, L)``, scaled so that its entries are of the size 1.
        b: the sides, ``(rows, L)``, of the same size.
        c: the costs of s, ``(spreads, L)``, not negative.

    >>> A = jnp.array([[[1.0], [1.0]], [[-1.0], [1.0]]])
    >>> found = optimum(A, jnp.array([[3.0], [1.0]]), jnp.array([[1.0]]))
    >>> found.z.ravel().tolist()  # with the half width 2 the band about 1 holds both 3 and -1
    [1.0, 2.0]
    """
    rows, unknowns, _ = A.shape
    table, known = _climbed(*lax.stop_gradient((A, b, c)))
    z, inverse = table.body[rows:-1, -1], table.body[rows:-1, :-1]
    # One step of Newton's method on the basis' equations takes away what rounding has added, and
    # carries the derivative: z' = inverse (b' - A' z).
    chosen = table.basis[:, None] == jnp.arange(rows + unknowns)[:, None]
    z = z - (inverse * (chosen * jnp.concatenate([(A * z).sum(axis=1) - b, z])).sum(axis=1)).sum(
        axis=1
    )
    kept = jnp.concatenate([(A * z).sum(axis=1) - b, z[unknowns - len(c) :]]).min(axis=0)
    multiplier = table.body[-1, :-1].min(axis=0)
    found = known & (lax.stop_gradient(kept) >= -KEPT)
    return Optimum(z, jnp.where(found, multiplier, jnp.nan))


def _climbed(A: Array, b: Array, c: Array) -> tuple[_Table, Array]:
    """The last table, and whether A determines every p.

    The first steps exchange each p for the row that knows it best, the others climb; a program that
    is done rests until all are.
    """
    rows, unknowns, lanes = A.shape
    free = unknowns - len(c)

    def step(carry: tuple[_Table, Array, Array, Array]) -> tuple[_Table, Array, Array, Array]:
        table, known, steps, _ = carry
        starts = steps < free
        column = (jnp.arange(unknowns) == steps)[:, None]
        spare = _spare(table, len(c))
        of_p = -jnp.abs((table.body[:, :-1] * column).sum(axis=1)).at[rows:].set(0.0)
        score = jnp.where(starts, of_p, spare)
        least = score.min(axis=0)
        goes = least < jnp.where(starts, -_PIVOT, -_BROKEN)
        enters = goes * _first(score == least)
        row = (table.body[:, :-1] * enters[:, None]).sum(axis=0)
        ratio = jnp.where(row > _PIVOT, jnp.maximum(table.body[-1, :-1], 0.0) / row, jnp.inf)
        tied = jnp.where(ratio <= ratio.min(axis=0) + _TIE, row, 0.0)
        leaves = goes * jnp.where(starts, column, _first(tied == tied.max(axis=0)))
        known = known & (goes | ~starts)
        return _exchanged(table, enters, leaves), known, steps + 1, starts | goes.any()

    z = jnp.broadcast_to(
        jnp.eye(unknowns, unknowns + 1)[..., None], (unknowns, unknowns + 1, lanes)
    )
    cost = jnp.concatenate([jnp.zeros((free, lanes)), c, jnp.zeros((1, lanes))])
    body = jnp.concatenate([jnp.concatenate([A, -b[:, None]], axis=1), z, cost[None]])
    basis = jnp.broadcast_to(jnp.arange(rows, rows + unknowns)[:, None], (unknowns, lanes))
    most = 10 * (rows + unknowns)  # met by programs that have no solution, or go in circles
    start = _Table(body, basis), jnp.full(lanes, True), jnp.array(0), jnp.array(True)
    return lax.while_loop(lambda carry: carry[3] & (carry[2] < most), step, start)[:2]


def _spare(table: _Table, spreads: int) -> Array:
    """By how much every row of the table is kept; 0 for the free unknowns and the cost."""
    value = table.body[:, -1]
    unknowns = len(table.basis)
    ones = np.ones((len(value), 1), bool)
    ones[-1 - unknowns : -1 - spreads] = ones[-1] = False
    return jnp.where(ones, value, 0.0)


def _exchanged(table: _Table, enters: Array, leaves: Array) -> _Table:
    """Another basis: a row ``(rows, L)`` and a column ``(unknowns, L)``, 1 at one place or 0."""
    row = (table.body * enters[:, None]).sum(axis=0)
    divisor = (row[:-1] * leaves).sum(axis=0) + (1.0 - leaves.sum(axis=0))
    column = (table.body[:, :-1] * leaves).sum(axis=1) / divisor
    row = row.at[:-1].add(-leaves)
    number = (enters * jnp.arange(len(enters))[:, None]).sum(axis=0).astype(table.basis.dtype)
    basis = jnp.where(leaves > 0, number, table.basis)
    return _Table(table.body - column[:, None] * row, basis)


def _first(these: Array) -> Array:
    """1 at the first true of a column and 0 elsewhere."""
    number = jnp.arange(len(these))[:, None]
    return (number == jnp.where(these, number, len(these)).min(axis=0)).astype(float)
