"""A run of both passes over a record, with its memory."""

import ctypes
from typing import Any, NamedTuple

import numpy as np

from tuner.native.filled import address
from tuner.native.pass_struct import Given
from tuner.native.passes_frame import Code

STORED = 64 << 20
"""Bytes that are stored of a whole record; above it those of parts, which are run again."""
PART = 128 << 10
"""Bytes stored of a part."""


class Steps(NamedTuple):
    """Addresses of the functions before, between and after the passes, for runs in one call.

    See :class:`tuner.native.pass_struct.Given`; a value alone needs no ``pull``.
    """

    number: int
    judge: int
    pull: int = 0


class PassRun:
    """A run over a record, or over one of those that lie end to end, with its memory.

    Python goes from step to step, or it calls C once for all of them. The latter takes a few
    microseconds less where nothing else is done in between, and a tenth of a millisecond where
    megabytes of a record have displaced the interpreter from the caches.

    Args:
        library: of the C.
        code: the C.
        size: of a point.
        count: of the numbers that vary with a point.
        samples: of a record.

    Attributes:
        samples: as given.
        end: the numbers needed at the end.
        kept: the values kept of each sample.
    """

    def __init__(self, library: Any, code: Code, size: int, count: int, samples: int) -> None:
        self._library, self._code, self._size, self.samples = library, code, size, samples
        self._part = part_of(samples, 8 * max(1, code.stored))
        self._store = self._saved = np.empty(0)
        self.end, self.kept = np.empty(code.total), np.empty((samples, code.kept))
        self._point, self._numbers = np.empty(size + count), np.empty(count)
        self._judged, self._slope = np.empty(1 + code.total), np.empty(size)
        self._by_numbers = self._point[size:]
        self._given = Given(
            n=samples,
            part=self._part,
            count=count,
            z=address(self._point),
            p=address(self._numbers),
            by_p=address(self._by_numbers),
            kept=address(self.kept),
            end=address(self.end),
            judged=address(self._judged),
            slope=address(self._slope),
        )
        self._at = ctypes.addressof(self._given)

    def value(self, z: np.ndarray, rows: np.ndarray, steps: Steps) -> float:
        """The objective at a point, in one call."""
        self._begin_at(z, rows, steps)
        self._library.value(self._at)
        return float(self._judged[0])

    def value_and_gradient(
        self, z: np.ndarray, rows: np.ndarray, steps: Steps
    ) -> tuple[float, np.ndarray]:
        """The objective and its gradient at a point, in one call."""
        self._begin_at(z, rows, steps)
        self._have_room()
        self._library.gradient(self._at)
        return float(self._judged[0]), self._slope.copy()

    def begun(self, numbers: np.ndarray, rows: np.ndarray) -> "PassRun":
        """The run with some of the numbers that vary with a point, over a record."""
        self._numbers[:] = numbers
        self._read(rows)
        return self

    def forwards(self, *, storing: bool) -> None:
        """The pass over the record, which stores what the way back needs, or does not."""
        if storing:
            self._have_room()
        self._library.forwards(self._at, storing)

    def backwards(self, by_end: np.ndarray, by_kept: np.ndarray) -> np.ndarray:
        """The pass back: the derivatives by the numbers that vary with a point."""
        self._library.backwards(self._at, address(by_end), address(by_kept))
        return self._by_numbers

    def _begin_at(self, z: np.ndarray, rows: np.ndarray, steps: Steps) -> None:
        self._point[: self._size] = z
        self._given.number, self._given.judge, self._given.pull = steps
        self._read(rows)

    def _read(self, rows: np.ndarray) -> None:
        """Go over a record from now on, which is kept in memory as long."""
        self._rows, self._given.width, self._given.u = rows, rows.shape[1], address(rows)

    def _have_room(self) -> None:
        """Memory for what is stored, from the first time on that it is."""
        if not self._store.size:
            parts = -(-self.samples // self._part)
            self._saved = np.empty(parts * max(1, self._code.carried))
            self._store = np.empty(self._part * max(1, self._code.stored))
            self._given.saved, self._given.store = address(self._saved), address(self._store)


def linked(library: ctypes.CDLL) -> ctypes.CDLL:
    """A library of both passes, with the types of its functions."""
    run, array = ctypes.c_void_p, ctypes.c_void_p
    library.forwards.argtypes = run, ctypes.c_bool
    library.backwards.argtypes = run, array, array
    library.value.argtypes = library.gradient.argtypes = (run,)
    for name in ("forwards", "backwards", "value", "gradient"):
        getattr(library, name).restype = None
    return library


def part_of(samples: int, stored: int) -> int:
    """Number of samples of a part, of which each stores some bytes."""
    return samples if samples * stored <= STORED else max(1, PART // stored)
