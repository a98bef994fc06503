"""Descents from several starts at the same time, on as many processors as there are."""

import time
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from queue import Empty, SimpleQueue
from threading import Event
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np

from tuner.problem.problem import Problem
from tuner.processors import carry_out, helped
from tuner.solvers.minimum import Descent, Minimum

T = TypeVar("T")
Queue: TypeAlias = "SimpleQueue[int | None]"
"""Starts that nobody has begun; None ends a thread."""
LONG = 1.25e-4
"""Evaluations that take longer, s, are worth a thread. Much of the time of shorter ones goes to
Python, which one thread runs at a time: their descents gain nothing by running side by side."""
MANY = 10_000
"""Samples from which evaluations are long."""
_FIRST = 5
"""So many evaluations of a problem tell by the shortest: others may be long as they compile."""


def descents(
    problem: Problem, descend: Descent, points: np.ndarray, count: int, threads: int
) -> Iterator[Minimum]:
    """The ends of descents, in the order of their starts, until so many of them are finite.

    Where evaluations are long, other threads make descents, too. They compute without the
    interpreter's lock, and none of them changes what another computes: the ends are the same for
    any number of threads, to the last bit. Random starts are begun before the initial values and
    the known ones: descents from these are mostly the shortest, and short ones at the end let the
    processors end together.

    Args:
        problem: what is minimised.
        descend: one descent from one start.
        points: the starts, ``(m, n)``; no more are taken than it needs.
        count: how many ends are to be finite.
        threads: how many descents run at the same time, the caller's among them.
    """
    helpers = min(threads, count) - 1
    if helpers < 1 or _are_long(problem) is False:
        ends = (descend(problem, z) for z in points)
    else:
        ends = _side_by_side(problem, descend, points, count, helpers)
    with closing(ends):
        for end in ends:
            yield end
            count -= bool(np.isfinite(end.value))
            if not count:
                break


def _are_long(problem: Problem) -> bool | None:
    """Whether evaluations are; None where that is not known yet."""
    if problem.data.samples >= MANY:
        return True
    return min(problem.seconds) > LONG if len(problem.seconds) >= _FIRST else None


def _side_by_side(
    problem: Problem, descend: Descent, points: np.ndarray, count: int, helpers: int
) -> Generator[Minimum, None, None]:
    first, likely = min(count, len(points)), 1 + len(problem.known_starts)
    more = iter(range(first, len(points)))
    ends: list[Future[Minimum]] = [Future() for _ in points]
    waiting: Queue = SimpleQueue()
    for k in (*range(likely, first), *range(min(likely, first))):
        waiting.put(k)
    over = Event()

    def make(k: int) -> None:
        carry_out(ends[k], partial(descend, cast("Problem", watched)), points[k])

    def help() -> None:
        while (k := waiting.get()) is not None and not over.is_set():
            make(k)

    with helped(help, helpers) as ask, _ending(waiting, helpers, over):
        watched = _Watched(problem, over, ask)
        if _are_long(problem):
            ask()
        for end in ends:
            while not end.done() and (k := _next(waiting)) is not None:
                make(k)
            found = end.result()
            if not np.isfinite(found.value):
                waiting.put(next(more, None))
            yield found


def _next(waiting: Queue) -> int | None:
    try:
        return waiting.get_nowait()
    except Empty:
        return None


@contextmanager
def _ending(waiting: Queue, helpers: int, over: Event) -> Iterator[None]:
    """A search, at whose end the threads end, too: within a descent where it is given up."""
    try:
        yield
    except BaseException:
        over.set()
        raise
    finally:
        for _ in range(helpers):
            waiting.put(None)


@dataclass(frozen=True, eq=False)
class _Watched:
    """A problem that is evaluated until its search is given up.

    Attributes:
        problem: the problem.
        over: set where the search is given up.
        ask: asks others to make descents, too, where evaluations turn out to be long.
    """

    problem: Problem
    over: Event
    ask: Callable[[], None]

    def __getattr__(self, name: str) -> Any:
        return getattr(self.problem, name)

    def value(self, z: np.ndarray) -> float:
        """The objective at z ``(n,)``."""
        return self._made(self.problem.value, z)

    def value_and_gradient(self, z: np.ndarray) -> tuple[float, np.ndarray]:
        """The objective and its gradient at z ``(n,)``."""
        return self._made(self.problem.value_and_gradient, z)

    def _made(self, evaluate: Callable[[np.ndarray], T], z: np.ndarray) -> T:
        if self.over.is_set():
            raise CancelledError("the search was given up")
        seconds = self.problem.seconds
        if len(seconds) >= _FIRST:
            return evaluate(z)
        start = time.perf_counter()
        found = evaluate(z)
        seconds.append(time.perf_counter() - start)
        if _are_long(self.problem):
            self.ask()
        return found
