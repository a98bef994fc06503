"""Descents from several starts at the same time, on as many processors as there are."""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import Event
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np

from tuner.problem.problem import Problem
from tuner.processors import beside_others
from tuner.solvers.minimum import Descent, Minimum

Begin: TypeAlias = Callable[[np.ndarray], "Future[Minimum]"]
"""Begins a descent from a start ``(n,)``."""
T = TypeVar("T")
ALONE = 0.02
"""A descent that takes longer, s, gets others beside it. Shorter ones gain nothing by it: much of
their time goes to Python, which one thread runs at a time."""
LONG = 2.5e-4
"""An evaluation that takes longer, s, is one of a long descent."""
_ENOUGH = 5e-4
"""Time in long evaluations, s, after which the others begin; one may be long for other reasons."""


def descents(
    problem: Problem, descend: Descent, points: np.ndarray, count: int, threads: int
) -> Iterator[Minimum]:
    """The ends of descents, in the order of their starts, until so many of them are finite.

    The threads compute without the interpreter's lock, and none of them changes what another
    computes: the ends are the same for any number of threads, to the last bit. Random starts are
    begun before the initial values and the known ones: descents from these are mostly the shortest,
    and short ones at the end let the processors end together.

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
    first, likely = min(count, len(points)), 1 + len(problem.known_starts)
    order = [*range(likely, first), *range(min(likely, first)), *range(first, len(points))]
    begun: dict[int, Future[Minimum]] = {}
    wanted, short = count, True
    news = Event()
    with _pool(problem, descend, min(threads, count), news) as begin:
        for at in range(len(points)):
            while at not in begun or (not short and len(begun) < min(wanted, len(points))):
                k = order[len(begun)]
                begun[k] = begin(points[k])
                if short:
                    begun[k].add_done_callback(lambda _: news.set())
                    news.wait(ALONE)
                    short = begun[k].done()
                    news.clear()
            end = begun[at].result()
            wanted += not np.isfinite(end.value)
            yield end


@contextmanager
def _pool(problem: Problem, descend: Descent, threads: int, long: Event) -> Iterator[Begin]:
    """Threads that make descents; once something is raised, none of them goes on.

    All of them start before the first descent: one that starts while another computes begins its
    work up to 5 ms late. ``long`` is set where evaluations are so long that descents will be, too.
    """
    over, begun = Event(), Event()
    pool = ThreadPoolExecutor(threads, initializer=beside_others)
    watched = cast("Problem", _Watched(problem, over, long))

    def begin(z: np.ndarray) -> "Future[Minimum]":
        descent = pool.submit(descend, watched, z)
        begun.set()
        return descent

    for _ in range(threads - 1):
        pool.submit(begun.wait)
    try:
        yield begin
    except BaseException:
        over.set()
        raise
    finally:
        begun.set()
        pool.shutdown(wait=not over.is_set(), cancel_futures=True)


@dataclass(frozen=True, eq=False)
class _Watched:
    """A problem that is evaluated until its search is given up.

    Attributes:
        problem: the problem.
        over: set where the search is given up.
        long: set once long evaluations have taken a while.
    """

    problem: Problem
    over: Event
    long: Event
    _spent: list[float] = field(default_factory=lambda: [0.0])

    def __getattr__(self, name: str) -> Any:
        return getattr(self.problem, name)

    def value(self, z: np.ndarray) -> float:
        """The objective at z ``(n,)``."""
        return self._timed(self.problem.value, z)

    def value_and_gradient(self, z: np.ndarray) -> tuple[float, np.ndarray]:
        """The objective and its gradient at z ``(n,)``."""
        return self._timed(self.problem.value_and_gradient, z)

    def _timed(self, evaluate: Callable[[np.ndarray], T], z: np.ndarray) -> T:
        if self.over.is_set():
            raise CancelledError("the search was given up")
        start = time.perf_counter()
        found = evaluate(z)
        took = time.perf_counter() - start
        if self._spent[0] <= _ENOUGH and took > LONG:
            self._spent[0] += took
            if self._spent[0] > _ENOUGH:
                self.long.set()
        return found
