"""A function of a few numbers for many rows of them, in C where all its operations have some."""

import ctypes
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jax import Array

from tuner.code.graph import Graph, TooLargeError
from tuner.code.interpreter import objects
from tuner.code.primitives import interpreter
from tuner.code.refused import NoCounterpartError
from tuner.compiler import library
from tuner.native.filled import address
from tuner.native.kept_texts import Kept, at_once
from tuner.native.scalars import Scalars
from tuner.native.sines import sines

MOST = 2000
"""Most operations in C: of more the compiler takes longer than they save."""
_HEAD = """\
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
"""
_TEXT = """\
void rows(size_t n, const double *restrict x, double *restrict y)
{{
    for (; n-- > 0; x += {given}, y += {found}) {{
{lines}
    }}
}}
"""


class RowFunction:
    """A function from rows of numbers to rows of numbers.

    A call of C takes a microsecond or two; JAX takes some fifty, most of which it waits for its
    own threads.

    Args:
        function: from real numbers ``(n,)`` to real numbers ``(m,)``.
        size: n.
        folder: for compiled code.
        kept: gives its C, made or kept.

    >>> from tempfile import mkdtemp
    >>> twice = RowFunction(lambda x: x + x[::-1], 2, Path(mkdtemp(), "code"))
    >>> twice(np.array([[1.0, 2.0], [3.0, 5.0]])).tolist()
    [[3.0, 3.0], [8.0, 8.0]]
    """

    def __init__(
        self,
        function: Callable[[Array], Array],
        size: int,
        folder: Path,
        kept: Kept = at_once,
    ) -> None:
        self._function, self._size, self._folder, self._kept = function, size, folder, kept

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """The function of each row ``(B, n)``: ``(B, m)``.

        Raises:
            NoCodeError: where there is no compiler that works.
        """
        if self._compiled is None:
            one = len(rows) == 1
            return np.asarray(self._by_jax(rows[0])[None] if one else self._all_by_jax(rows))
        call, count = self._compiled
        given = np.ascontiguousarray(rows, float)
        found = np.empty((len(rows), count))
        call(len(rows), address(given), address(found))
        return found

    @property
    def address(self) -> int:
        """Its address in C, ``void rows(size_t B, const double *x, double *y)``; 0 without any."""
        call = self._compiled and self._compiled[0]
        return ctypes.cast(call, ctypes.c_void_p).value or 0 if call else 0

    @cached_property
    def _by_jax(self) -> Callable[[np.ndarray], Array]:
        return jax.jit(self._function)

    @cached_property
    def _all_by_jax(self) -> Callable[[np.ndarray], Array]:
        return jax.jit(jax.vmap(self._function))

    @cached_property
    def _compiled(self) -> tuple[Any, int] | None:
        """The function of addresses in C, and m; None where there is none."""
        try:
            text, count = self._kept(lambda: _source(self._function, self._size))
        except (NoCounterpartError, TooLargeError):
            return None
        call = library(text, self._folder).rows
        call.argtypes = [ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]
        call.restype = None
        return call, count


def _source(function: Callable[[Array], Array], size: int) -> tuple[str, int]:
    """The C of a function, and the number of its results."""
    graph = Graph(most=MOST)
    given = np.empty(size, object)
    given[:] = [graph.input(("x", k)) for k in range(size)]
    closed = jax.make_jaxpr(function)(np.zeros(size))
    (found,) = objects(graph, interpreter(graph).closed(closed, [given]))
    scalars = Scalars(graph)
    scalars.names = {entry: f"x[{k}]" for k, entry in enumerate(given)}
    scalars.state(graph.reached(found))
    lines = [
        *scalars.lines,
        *(f"y[{k}] = (double){scalars.name(entry)};" for k, entry in enumerate(found)),
    ]
    body = "\n".join(f"        {line}" for line in lines)
    text = _TEXT.format(given=size, found=len(found), lines=body)
    return "\n".join([_HEAD, sines() if scalars.turns else "", text]), len(found)
