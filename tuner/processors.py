"""Work for all processors: by the calling thread, and by threads that this process keeps."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from threading import Barrier
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


@contextmanager
def beside_others() -> Iterator[None]:
    """State that other threads of the same work compute beside this one meanwhile."""
    before = _BESIDE.set(True)
    try:
        yield
    finally:
        _BESIDE.reset(before)


def carry_out(end: "Future[B]", function: Callable[[A], B], given: A) -> None:
    """Make a call beside others, and keep its result or its error.

    Raises:
        BaseException: what ends a thread, besides keeping it.
    """
    try:
        with beside_others():
            end.set_result(function(given))
    except BaseException as error:
        end.set_exception(error)
        if not isinstance(error, Exception):
            raise


@contextmanager
def helped(work: Callable[[], None], helpers: int) -> Iterator[Callable[[], None]]:
    """Let other threads do a work, too, which takes from the calling one what is left to do.

    Those that are free begin it; they are one fewer than the processors, and other work may have
    them all. At the end those that have begun are waited for, unless something is raised.

    Args:
        work: returns where nothing is left to do.
        helpers: how many other threads are asked.

    Yields:
        What asks them, where it is called for the first time.
    """
    threads = _kept_threads(os.getpid(), os.cpu_count() or 1)
    asked: list[Future[None]] = []

    def ask() -> None:
        if not asked:
            asked.extend(threads.submit(work) for _ in range(helpers))

    try:
        yield ask
    except BaseException:
        for one in asked:
            one.cancel()
        raise
    wait([one for one in asked if not one.cancel()])


@cache
def _kept_threads(process: int, processors: int) -> ThreadPoolExecutor:
    """One for each other processor, started before there is work for them, and kept.

    Starting one takes as long as a short work, and one that starts while others compute begins its
    work up to 5 ms late.
    """
    count = max(1, processors - 1)
    threads = ThreadPoolExecutor(count, f"{process} beside")
    together = Barrier(count + 1)
    for _ in range(count):
        threads.submit(together.wait)
    together.wait()
    return threads


def side_by_side(function: Callable[[A], B], given: Sequence[A]) -> list[B]:
    """A function of each, by this thread and others, unless others compute beside it already.

    Raises:
        Exception: the first one of a call, in the order of what is given; no others begin then.
    """
    count = min(os.cpu_count() or 1, len(given))
    if count < 2 or not alone():
        return [function(one) for one in given]
    ends: list[Future[B]] = [Future() for _ in given]
    left = iter(zip(ends, given, strict=True))  # the next one is taken under Python's lock

    def work() -> None:
        for end, one in left:
            carry_out(end, function, one)
            if end.exception() is not None:
                list(left)

    with helped(work, count - 1) as ask:
        ask()
        try:
            work()
        finally:
            list(left)
    return [end.result() for end in ends]
