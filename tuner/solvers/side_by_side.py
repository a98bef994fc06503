"""Descents from several starts at the same time, on as many processors as there are."""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager
from dataclasses import dataclass, field
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
_IN_A_ROW, _TRIALS = 2, 8
"""So many long ones in a row decide, of so many; one may be long for other reasons."""
MANY = 10_000
"""Samples from which evaluations are taken for long ones."""


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
        threads: how many descents run at the same time, the caller's among them.
    """
    if threads < 2 or count < 2:
        yield from (descend(problem, z) for z in points)
        return
    first, likely = min(count, len(points)), 1 + len(problem.known_starts)
    more = iter(range(first, len(points)))
    ends: list[Future[Minimum]] = [Future() for _ in points]
    waiting: Queue = SimpleQueue()
    for k in (*range(likely, first), *range(min(likely, first))):
        waiting.put(k)
    over = Event()

    def make(k: int) -> None:
        carry_out(ends[k], partial(descend, cast("Problem", evaluated)), points[k])

    def help() -> None:
        while (k := waiting.get()) is not None and not over.is_set():
            make(k)

    helpers = min(threads, count) - 1
    with helped(help, helpers) as ask, _ending(waiting, helpers, over):
        evaluated = _Evaluated(problem, over, ask)
        if problem.data.samples >= MANY:
            ask()
        for end in ends:
            while not end.done() and (k := _next(waiting)) is not None:
                make(k)
            found = end.result()
            yield found
            if not np.isfinite(found.value):
                waiting.put(next(more, None))
                continue
            count -= 1
            if not count:
                break


def _next(waiting: Queue) -> int | None:
    try:
        return waiting.get_nowait()
    except Empty:
        return None


@contextmanager
def _ending(waiting: Queue, helpers: int, over: Event) -> Iterator[None]:
    """A search, at whose end the threads end, too: within a descent where something is raised."""
    try:
        yield
    except BaseException:
        over.set()
        raise
    finally:
        for _ in range(helpers):
            waiting.put(None)


@dataclass(eq=False)
class _Evaluated:
    """A problem that is evaluated until its search is given up.

    Attributes:
        problem: the problem.
        over: set where the search is given up.
        ask: asks others to make descents, too; called where evaluations are long.
    """

    problem: Problem
    over: Event
    ask: Callable[[], None]
    _before: set[str] = field(default_factory=set)
    _long: int = 0
    _trials: int = _TRIALS

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
        if self._trials <= 0:
            return evaluate(z)
        start = time.perf_counter()
        found = evaluate(z)
        took = time.perf_counter() - start
        self._trials -= 1
        if evaluate.__name__ in self._before:
            self._long = self._long + 1 if took > LONG else 0
            if self._long == _IN_A_ROW:
                self.ask()
        self._before.add(evaluate.__name__)  # the first of a kind may be long as it is compiled
        return found
