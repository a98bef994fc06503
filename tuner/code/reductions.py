"""Reductions of JAX: sums, products, the largest."""

import math
from itertools import product as indices
from typing import Any

import numpy as np

from tuner.code.interpreter import Algebra, Arrays, Rule, each, objects, rows_of


def reduced(op: str) -> Rule:
    """A reduction along some axes by a binary operation."""

    def rule(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
        axes = equation.params["axes"]
        kept = [k for k in range(given[0].ndim) if k not in axes]
        shape = [given[0].shape[k] for k in kept]
        out = np.empty(shape, object)
        rows = given[0].transpose((*kept, *axes)).reshape((*shape, -1))
        for index in np.ndindex(*shape):
            total = rows[index][0]
            for entry in rows[index][1:]:
                total = algebra.apply(op, total, entry)
            out[index] = total
        return [out]

    return rule


def place(better: str) -> Rule:
    """The position of the largest (gt) or smallest (lt) entry."""

    def rule(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
        (axis,), dtype = equation.params["axes"], np.dtype(equation.params["index_dtype"])
        rows = rows_of(given[0], axis)
        best, at = rows[0], each(lambda _: algebra.constant(dtype.type(0)), rows[0])
        for k, row in enumerate(rows[1:], 1):
            here = algebra.constant(dtype.type(k))
            wins = each(lambda x, y: algebra.apply(better, x, y), row, best)
            best = each(algebra.choose, wins, best, row)
            at = each(lambda c, old, new=here: algebra.choose(c, old, new), wins, at)
        return [at]

    return rule


def cumulated(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    """Cumulative sums."""
    rows = rows_of(given[0], equation.params["axis"])
    back = slice(None, None, -1 if equation.params["reverse"] else 1)
    sums = [rows[back][0]]
    for row in rows[back][1:]:
        sums.append(each(lambda x, y: algebra.apply("add", x, y), sums[-1], row))
    return [np.moveaxis(np.stack(sums)[back], 0, equation.params["axis"])]


def product(algebra: Algebra, equation: Any, given: Arrays) -> Arrays:
    """A product of arrays, as sums."""
    (cx, cy), (bx, by) = equation.params["dimension_numbers"]
    x, y = objects(algebra, given)
    fx = [k for k in range(x.ndim) if k not in (*cx, *bx)]
    fy = [k for k in range(y.ndim) if k not in (*cy, *by)]
    batch, rows, columns = ([a.shape[k] for k in axes] for a, axes in ((x, bx), (x, fx), (y, fy)))
    length = math.prod(x.shape[k] for k in cx)
    x = x.transpose(*bx, *fx, *cx).reshape(math.prod(batch), math.prod(rows), length)
    y = y.transpose(*by, *fy, *cy).reshape(math.prod(batch), math.prod(columns), length)
    out = np.empty((math.prod(batch), math.prod(rows), math.prod(columns)), object)
    for b, i, j in indices(*map(range, out.shape)):
        total = algebra.constant(equation.outvars[0].aval.dtype.type(0))
        for k in range(length):
            total = algebra.apply("add", total, algebra.apply("mul", x[b, i, k], y[b, j, k]))
        out[b, i, j] = total
    return [out.reshape((*batch, *rows, *columns))]
