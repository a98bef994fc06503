"""Passes over long columns, in blocks that stay in the processor's cache.

An operation on all rows at once takes as long as memory does to bring them, and its results as long
again. NumPy works on blocks without the interpreter's lock, so parts of a column share the
processors.
"""

import os
from collections.abc import Callable
from itertools import pairwise
from typing import TypeVar

from tuner.processors import side_by_side

BLOCK = 1 << 17
"""Rows that nearly fit in a processor's own cache. Threads wait for Python between blocks: with a
quarter of the rows two of them take a fifth more processor time, and half as long again."""
_LONG = 1 << 21
"""Rows from which it pays to ask other threads."""
_SHARES = 4
"""Parts for each processor: one that has other work, as the digest of the file, takes fewer."""

A = TypeVar("A")


def in_parts(function: Callable[[range], A], rows: int) -> list[A]:
    """A function of each part of the rows, in their order: of the places at which its blocks begin.

    The blocks are the same for any number of processors; no row makes one block without any.

    >>> in_parts(list, 140_000), in_parts(list, 0)
    ([[0, 131072]], [[0]])
    """
    processors = os.cpu_count() or 1
    parts = _SHARES * processors if rows >= _LONG and processors > 1 else 1
    blocks = max(1, -(-rows // BLOCK))
    ends = [BLOCK * (blocks * part // parts) for part in range(parts + 1)]
    ranges = [range(*pair, BLOCK) for pair in pairwise(ends)]
    return side_by_side(function, [part for part in ranges if part])
