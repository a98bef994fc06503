"""Compiled programs of the folder, loaded before they are asked for.

XLA takes a tenth of a second to load a program, without the interpreter's lock: another thread has
them ready while a run reads its recordings and poses its problem.
"""

import zlib
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from threading import Lock
from typing import Any, NamedTuple

import jax

from tuner.cached import kept, program_folder


class Program(NamedTuple):
    """A compiled program of the folder.

    Attributes:
        key: of its file.
        given, found: number of the arrays that it takes, and of those that it returns.
    """

    key: str
    given: int
    found: int


class Programs:
    """The programs that a process has taken from the folder, and those under way.

    Attributes:
        taken: the former, in their order.
        anything_compiled: whether one of them was not in the folder before.
    """

    def __init__(self) -> None:
        self.taken: dict[Program, None] = {}
        self.anything_compiled = False
        self._begun: dict[Program, Future[Any]] = {}
        self._lock = Lock()

    def note(self, program: Program, *, compiled: bool = False) -> None:
        """Count a program among those that were taken, and whether it had to be compiled."""
        self.taken.setdefault(program)
        self.anything_compiled |= compiled

    def loaded(self, program: Program) -> Any:
        """A program, ready to be called.

        Raises:
            Exception: of any kind, where it is missing or of no use.
        """
        with self._lock:
            begun = self._begun.pop(program, None)
        ready = load(program) if begun is None or begun.cancel() else begun.result()
        self.note(program)
        return ready

    @contextmanager
    def ahead(self, programs: Iterable[Program]) -> Iterator[None]:
        """Load programs in another thread meanwhile, in their order."""
        pool = ThreadPoolExecutor(1)
        with self._lock:
            self._begun |= {one: pool.submit(load, one) for one in programs}
        try:
            yield
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            with self._lock:
                self._begun.clear()


def load(program: Program) -> Any:
    """A program, read from the folder.

    Raises:
        Exception: of any kind, where it is missing or of no use.
    """
    from jax.experimental.serialize_executable import deserialize_and_load

    text = zlib.decompress(kept(program_folder(), program.key) or b"")
    given = jax.tree.structure(((0,) * program.given, {}))
    found = jax.tree.structure([0] * program.found)
    return deserialize_and_load(text, given, found, execution_devices=jax.devices()[:1])
