"""How many compiled programs a process keeps that poses problem after problem."""

from collections.abc import Iterator
from typing import Any

from filters import protocol
from tuner.problem import programs, samples, surface

MOST = 24
"""So many are kept: those of some six fits, about 10 MB each."""


def forget_old_ones() -> None:
    """Let go of all programs where they are more than :data:`MOST`.

    A problem's box and its start follow from its data, and its programs hold both: those of earlier
    data are never asked for again, and JAX keeps thousands.
    """
    if sum(each._cache_size() for each in _compiled()) > MOST:
        for each in _compiled():
            each.clear_cache()


def _compiled() -> Iterator[Any]:
    for module in (protocol, programs, samples, surface):
        for each in vars(module).values():
            if hasattr(each, "clear_cache") and not isinstance(each, type):
                yield each
