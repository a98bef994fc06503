"""Descents from several starts at the same time, on as many processors as there are."""

from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from threading import Event
from typing import Any, TypeAlias, cast

import numpy as np

from tuner.native.threads import beside_others
from tuner.problem.problem import Problem
from tuner.solvers.minimum import Descent, Minimum

Begin: TypeAlias = Callable[[np.ndarray], "Future[Minimum]"]
"""Begins a descent from a start ``(n,)``."""
ALONE = 0.02
"""A descent that takes longer, s, gets others beside it. Shorter ones gain nothing by it: much of
their time goes to Python, which one thread runs at a time."""


def descents(
    problem: Problem, descend: Descent, points: np.ndarray, count: int, threads: int
) -> Iterator[Minimum]:
    """The ends of descents, in the order of their starts, until so many of them are finite.

    The threads compute without the interpreter's lock, and none of them changes what another
    computes: the ends are the same for any number of threads, to the last bit.

    Args:
        problem: what is minimised.
        descend: one descent from one start.
        points: the starts, ``(m, n)``; no more are taken than it needs.
        count: how many ends are to be finite.
        threads: how many descents run at the same time.
    """
    if threads < 2 or count < 2:
        yield from (descend(problem, z) for z in points)
        return
    begun: list[Future[Minimum]] = []
    wanted, short = count, True
    with _pool(problem, descend, threads) as begin:
        for at in range(len(points)):
            begun += map(begin, points[len(begun) : at + 1 if short else wanted])
            if short and not wait(begun[at:], timeout=ALONE).done:
                short = False
                begun += map(begin, points[len(begun) : wanted])
            end = begun[at].result()
            wanted += not np.isfinite(end.value)
            yield end


@contextmanager
def _pool(problem: Problem, descend: Descent, threads: int) -> Iterator[Begin]:
    """Threads that make descents; once something is raised, none of them goes on."""
    over, pool = Event(), ThreadPoolExecutor(threads, initializer=beside_others)
    watched = cast("Problem", _Watched(problem, over))
    try:
        yield lambda z: pool.submit(descend, watched, z)
    except BaseException:
        over.set()
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


@dataclass(frozen=True, eq=False)
class _Watched:
    """A problem that is evaluated until its search is given up.

    Attributes:
        problem: the problem.
        over: set where the search is given up.
    """

    problem: Problem
    over: Event

    def __getattr__(self, name: str) -> Any:
        return getattr(self.problem, name)

    def value(self, z: np.ndarray) -> float:
        """The objective at z ``(n,)``."""
        self._check()
        return self.problem.value(z)

    def value_and_gradient(self, z: np.ndarray) -> tuple[float, np.ndarray]:
        """The objective and its gradient at z ``(n,)``."""
        self._check()
        return self.problem.value_and_gradient(z)

    def _check(self) -> None:
        if self.over.is_set():
            raise CancelledError("the search was given up")
