"""Calls side by side, in a thread for each processor, unless others compute beside them."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from typing import TypeVar

A = TypeVar("A")
B = TypeVar("B")
_BESIDE = ContextVar("beside", default=False)


def alone() -> bool:
    """Whether no other thread of the same work computes beside this one.

    >>> alone()
    True
    >>> side_by_side(lambda _: alone(), range(2))
    [False, False]
    """
    return not _BESIDE.get()


def beside_others() -> None:
    """State that other threads of the same work compute beside this one from now on."""
    _BESIDE.set(True)


def side_by_side(function: Callable[[A], B], given: Sequence[A]) -> list[B]:
    """A function of each; in threads, unless others compute beside this one already."""
    if len(given) == 1 or not alone():
        return [function(one) for one in given]
    with ThreadPoolExecutor(os.cpu_count(), initializer=beside_others) as pool:
        return list(pool.map(function, given))
