"""Threads that work side by side."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager


@contextmanager
def at_once(jobs: int) -> Iterator[ThreadPoolExecutor]:
    """A pool of threads, none of which is waited for once something was raised.

    After an interruption a thread may be in the middle of a search that takes minutes; what it has
    finished is saved, and the rest is lost in any case.

    >>> with at_once(2) as pool:
    ...     list(pool.map(abs, [-1, 2]))
    [1, 2]
    """
    pool = ThreadPoolExecutor(jobs)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()
