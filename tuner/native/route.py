"""The choice between compiled C and XLA for a problem's gradient, with its reason."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from threading import Lock, RLock
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from objectives import Data, is_fold
from tuner.cached import code_folder
from tuner.code.graph import TooLargeError
from tuner.code.refused import NoCounterpartError
from tuner.compiler import NoCodeError, compiler, use
from tuner.native.wanted import Shapes, Static, Wanted, forwards, operations, shapes_of, shortest
from tuner.stored_programs import in_use, key_of

if TYPE_CHECKING:
    from tuner.native.backwards import Backwards
    from tuner.native.compiled import Native

PAYS, KEPT_PAYS, COMPILED = 7e7, 1e7, 2e4
"""Operations of a gradient from which compiling pays over a search, and from which it does where
later runs find what was written; and the same for each operation of a step."""
AGREED = 1e-9
"""Tolerance of value and gradient against XLA's, over the largest of these numbers."""
_NUDGE = 1e-13
"""A step that a regular problem hardly notices, absolute and relative."""
_CHAOTIC = 1e-9
"""Where that step changes XLA's numbers by more, over the largest, they judge nothing."""
PRICES = {"forwards": 0, "backwards": 3, "backwards in parts": 5}
"""Cost in passes of a gradient by XLA that goes backwards; 0 of one forwards."""
_EVEN, _EVEN_BACK = 6, 3
"""Operations of XLA, those of a step times its passes, over those of C, where both take as long: of
C that goes forwards, and of a pass with one back."""
_MOST_SETTLED = 8
"""Parameters up to which C with constant gains, one pass of derivatives, beats XLA's."""
LEAST = 0.5
"""Share of a record with constant gains from which C that has them is taken."""
_STEADY = "its constant gains take less than C does"
_MOST = 4000
"""Most operations of a step in C."""
_FAILURES = (ValueError, TypeError, LookupError, AttributeError, OSError, MemoryError, NoCodeError)
"""Errors that prevent C code of a loop: none of them may end a search."""


_making = RLock()
"""Held by the thread that writes C: another one that wants the same waits for it."""


Both: TypeAlias = tuple[float, np.ndarray]
"""A value and its gradient."""


@dataclass
class Route:
    """The way to a problem's gradient, decided at its first use.

    Attributes:
        static: of the compilation.
        data: the record.
        size: of a point.
        exact: value and gradient by XLA, with which C is compared once.
        exact_value: the value by XLA.
        price: of a gradient by XLA in passes, where it goes backwards through the loop, 0 where
            it goes forwards; and the share of the samples that it takes with constant gains. Both
            are worked out where C is possible.
        at: samples where the loop begins anew, and another thread takes over.
        settle: whether C may go on with constant gains where they have settled.
        choice: the choice in words; "" before it is made.
        settled: share of the record that C takes with constant gains at the first point.
        values_by: that values without a gradient go by C; "" where they do not.
    """

    static: Static
    data: Data
    size: int
    exact: Callable[[np.ndarray], Both]
    exact_value: Callable[[np.ndarray], float]
    price: Callable[[], tuple[int, float]] = lambda: (0, 0.0)
    at: tuple[int, ...] = ()
    settle: bool = True
    choice: str = ""
    values_by: str = ""
    settled: float = 0.0
    _single: "Native | Backwards | None" = None
    _valued: "Native | Backwards | bool" = True
    _many: bool | None = None
    _rows: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    _lock: Lock = field(default_factory=Lock)

    @property
    def goes_back(self) -> bool:
        """Whether gradients go by C that goes back through the record."""
        return self._single is not None and self._single.returns

    def value_and_gradient(self, z: np.ndarray) -> Both | None:
        """Both at z ``(n,)`` by C; None where XLA has to compute them."""
        if not self.choice:
            with self._lock:  # of several threads one decides
                if not self.choice:
                    return self._decided(z)
        if self._single is None:
            return None
        return self._single.value_and_gradient(z, self._rows, self.data, self.at)

    def _decided(self, z: np.ndarray) -> Both | None:
        """Both at z by C where that is possible and pays; otherwise the reason is kept."""
        try:
            native = self._shortest(z)
            found = native.value_and_gradient(z, self._rows, self.data, self.at)
            if not self._agrees(found, z):
                return None
        except _FAILURES as error:
            self.choice = f"XLA: {error}"
            return None
        gains = f", constant gains for {self.settled:.1%}" if native.settles else ""
        self._single, self.choice = native, f"C, compiled by {compiler().name}{gains}"
        return found

    def value(self, z: np.ndarray) -> float | None:
        """The value alone by C, where that pays for gradients; None where XLA computes it."""
        if self._valued is True:
            with self._lock:
                if self._valued is True:
                    self._valued = self._decided_value(z)
        if isinstance(self._valued, bool):
            return None
        return self._valued.value(z, self._rows, self.data, self.at)

    def _decided_value(self, z: np.ndarray) -> "Native | Backwards | bool":
        try:
            native = self._shortest(z)
            found = native.value(z, self._rows, self.data, self.at)
        except _FAILURES:
            return False
        apart = _apart(found, self.exact_value, z)
        if apart is None:
            return True
        if not apart <= AGREED:
            return False
        self.values_by = f"values by C, compiled by {compiler().name}"
        return native

    def values_and_gradients(self, Z: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """The same at points ``(B, n)``."""
        if self._many is False:
            return None
        try:
            native = self._native(len(Z))
            values, gradients = native.values_and_gradients(Z, self._rows, self.data)
            if not self._many and not self._agrees((values[0], gradients[0]), Z[0]):
                return None
        except _FAILURES:
            self._many = False
            return None
        self._many = True
        return values, gradients

    def _native(self, points: int) -> "Native":
        """C for the loop with several points.

        Raises:
            NoCodeError: where there is none, or it does not pay.
            ValueError: where an operation has no counterpart in it.
        """
        shapes = self._possible(points)
        with _making:
            native = forwards(self._wanted(shapes))
        self._begin(native)
        return native

    def _shortest(self, z: np.ndarray) -> "Native | Backwards":
        """The same with one point, z ``(n,)`` at first."""
        shapes = self._possible(1)
        with _making:
            native = self._settling(shapes, z)
            if native is not None:
                return native
            found = shortest(self._wanted(shapes))
        if use() == "auto":
            if self._steady:
                raise NoCodeError(_STEADY)
            if self._slower_than_backward(found, shapes):
                raise NoCodeError("its way back through the loop is shorter than C's")
        self._begin(found)
        return found

    def _settling(self, shapes: Shapes, z: np.ndarray) -> "Native | None":
        """C that goes forwards, where it takes half of the record with constant gains, or more."""
        if self.size > _MOST_SETTLED:
            return None
        try:
            native = forwards(self._wanted(shapes))
            if not native.settles:
                return None
        except (NoCounterpartError, TooLargeError):
            return None
        self._begin(native)
        self.settled = native.settled(z, self._rows, self.at)
        return native if self.settled >= LEAST else None

    def _begin(self, native: "Native | Backwards") -> None:
        """Lay out the record as C reads it."""
        if not self._rows.size:
            self._rows = native.rows(self.data)

    def _wanted(self, shapes: Shapes) -> Wanted:
        return Wanted(self.static, self.size, shapes, code_folder(), self.settle)

    def _possible(self, points: int) -> Shapes:
        """Shapes and types of the record, where C may pay."""
        wish = use()
        if wish == "off":
            raise NoCodeError("TUNER_NATIVE is off")
        if self.static.filter is None or self.size == 0:
            raise NoCodeError("no loop over time is differentiated")
        shapes = shapes_of(self.data, folds=is_fold(self.static.objective))
        if wish == "auto" and not self._pays(shapes, points):
            raise NoCodeError("the record is too short for compiling C to pay")
        if wish == "auto" and points == 1 and self._steady and self.size > _MOST_SETTLED:
            raise NoCodeError(_STEADY)
        compiler()
        return shapes

    @cached_property
    def _priced(self) -> tuple[int, float]:
        return self.price()

    @property
    def _steady(self) -> bool:
        """Whether XLA takes a good part of the record with constant gains."""
        return self._priced[1] > 0

    def _pays(self, shapes: Shapes, points: int) -> bool:
        samples = self.data.samples
        least = KEPT_PAYS if in_use() and key_of(self.static) is not None else PAYS
        if (samples * points * max(1 + self.size, *PRICES.values()) - COMPILED) * _MOST < least:
            return False
        backwards, _ = self._priced
        passes = backwards if backwards and points == 1 else 1 + self.size
        turns = samples * passes * points - COMPILED
        return bool(turns * operations(self.static, self.size, shapes) >= least)

    def _slower_than_backward(self, native: "Native | Backwards", shapes: Shapes) -> bool:
        """Whether derivatives in C cost more than XLA's way back, as through dense matrices."""
        backwards, _ = self._priced
        if not backwards:
            return False
        most = backwards * operations(self.static, self.size, shapes)
        even = _EVEN_BACK if native.returns else _EVEN
        return bool(even * native.operations > most)

    def _agrees(self, found: Both, z: np.ndarray) -> bool:
        """Whether both equal XLA's; also False where XLA's are not finite, or chaotic.

        Raises:
            NoCodeError: where they differ.
        """

        def right(point: np.ndarray) -> np.ndarray:
            value, gradient = self.exact(point)
            return np.array([value, *gradient])

        apart = _apart(np.array([found[0], *found[1]]), right, z)
        if apart is None:
            return False
        if not apart <= AGREED:
            raise NoCodeError(f"compiled C differs from it by {apart:.1g} at the first point")
        return True


def _apart(found: Any, right: Callable[[np.ndarray], Any], z: np.ndarray) -> float | None:
    """How far results are from XLA's, over the largest; None where XLA's tell nothing at z.

    They do not where they are not finite, or differ from those nearby: a likelihood may be chaotic
    for noises far from the true ones, and then rounding alone decides what comes out.
    """
    exact = right(z)
    if not np.isfinite(exact).all():
        return None
    scale = np.abs(exact).max() or 1.0
    apart = float(np.abs(found - exact).max() / scale)
    if apart <= AGREED:
        return apart
    # Not equally far along all coordinates: a common factor of all noises leaves estimates alone.
    nudged = z + _NUDGE * (1 + np.abs(z)) * np.linspace(1, 2, len(z))
    nearby = np.abs(right(nudged) - exact).max() / scale
    return apart if nearby <= _CHAOTIC else None
