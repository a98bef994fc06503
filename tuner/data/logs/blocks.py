"""Blocks of a file, passed on by whoever reads it to whoever needs the same bytes."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from queue import SimpleQueue
from threading import Event


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks in the order in which they are read, until no more of them come.

    >>> blocks = Blocks()
    >>> blocks.put(8, memoryview(b"samples"))
    >>> blocks.close()
    >>> [(at, bytes(block)) for at, block in blocks]
    [(8, b'samples')]
    """

    _queue: "SimpleQueue[tuple[int, memoryview] | None]" = field(default_factory=SimpleQueue)
    _closed: Event = field(default_factory=Event)

    def put(self, at: int, block: memoryview) -> None:
        """Pass on the bytes at a place of the file, which nobody changes; none after the end."""
        if not self._closed.is_set():
            self._queue.put((at, block))

    def close(self) -> None:
        """Say that no more blocks come."""
        self._closed.set()
        self._queue.put(None)

    def __iter__(self) -> Iterator[tuple[int, memoryview]]:
        """The blocks, each as soon as it has come."""
        while (block := self._queue.get()) is not None:
            yield block
