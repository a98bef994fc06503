"""The choice between compiled C and XLA for a problem's gradient, with its reason."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from pathlib import Path
from threading import Lock, RLock
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, cast

import jax
import numpy as np
from jax import Array

from filters import AnyFilter
from objectives import Data, Objective, is_fold
from tuner.cached import code_folder
from tuner.code.graph import TooLargeError
from tuner.code.refused import NoCounterpartError
from tuner.compiler import NoCodeError, compiler, use
from tuner.native.kept_texts import KeptTexts
from tuner.stored_programs import in_use, key_of, stored_text

if TYPE_CHECKING:
    from tuner.native.backwards import Backwards
    from tuner.native.compiled import Native

PAYS, KEPT_PAYS, COMPILED = 7e7, 1e7, 2e4
"""Operations of a gradient from which compiling pays over a search, and from which it does where
later runs find what was written; and the same for each operation of a step."""
AGREED = 1e-9
"""Tolerance of value and gradient against XLA's, over the largest of these numbers."""
PRICES = {"forwards": 0, "backwards": 3, "backwards in parts": 5}
"""Cost in passes of a gradient by XLA that goes backwards; 0 of one forwards."""
_EVEN, _EVEN_BACK = 6, 3
"""Operations of XLA, those of a step times its passes, over those of C, where both take as long: of
C that goes forwards, and of a pass with one back."""
_FEW = 4
"""Parameters whose derivatives always go forwards in C."""
_MOST = 4000
"""Most operations of a step in C."""
_FAILURES = (ValueError, TypeError, LookupError, AttributeError, OSError, MemoryError, NoCodeError)
"""Errors that prevent C code of a loop: none of them may end a search."""


_making = RLock()
"""Held by the thread that writes C: another one that wants the same waits for it."""


class Static(Hashable, Protocol):
    """The static part of a compilation; equal ones share one."""

    @property
    def filter(self) -> AnyFilter | None:
        """The filter; None where nothing is run."""

    @property
    def objective(self) -> Objective:
        """The objective."""

    def built(self, z: Array) -> Any:
        """The filter's parameters at a point."""


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
        choice: the choice in words; "" before it is made.
        values_by: that values without a gradient go by C; "" where they do not.
    """

    static: Static
    data: Data
    size: int
    exact: Callable[[np.ndarray], Both]
    exact_value: Callable[[np.ndarray], float]
    price: Callable[[], tuple[int, float]] = lambda: (0, 0.0)
    at: tuple[int, ...] = ()
    choice: str = ""
    values_by: str = ""
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
            native = self._shortest()
            found = native.value_and_gradient(z, self._rows, self.data, self.at)
            if not self._agrees(found, z):
                return None
        except _FAILURES as error:
            self.choice = f"XLA: {error}"
            return None
        self._single, self.choice = native, f"C, compiled by {compiler().name}"
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
            native = self._shortest()
            found, right = native.value(z, self._rows, self.data, self.at), self.exact_value(z)
        except _FAILURES:
            return False
        if not np.isfinite(right):
            return True
        if not abs(found - right) <= AGREED * abs(right):
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
            native = _made(self.static, self.size, *shapes, code_folder())
        if not self._rows.size:
            self._rows = native.rows(self.data)
        return native

    def _shortest(self) -> "Native | Backwards":
        """The same with one point."""
        shapes = self._possible(1)
        with _making:
            native = _shortest(self.static, self.size, *shapes, code_folder())
        if use() == "auto" and self._slower_than_backward(native, shapes):
            raise NoCodeError("its way back through the loop is shorter than C's")
        if not self._rows.size:
            self._rows = native.rows(self.data)
        return native

    def _possible(self, points: int) -> tuple[tuple[Any, ...], Any]:
        """Shapes and types of the record, where C may pay."""
        wish = use()
        if wish == "off":
            raise NoCodeError("TUNER_NATIVE is off")
        if self.static.filter is None or self.size == 0:
            raise NoCodeError("no loop over time is differentiated")
        shapes = _shapes(self.data, is_fold(self.static.objective))
        if wish == "auto" and not self._pays(shapes, points):
            raise NoCodeError("the record is too short for compiling C to pay")
        if wish == "auto" and points == 1 and self._priced[1]:
            raise NoCodeError("constant gains take less than C does")
        compiler()
        return shapes

    @cached_property
    def _priced(self) -> tuple[int, float]:
        return self.price()

    def _pays(self, shapes: Any, points: int) -> bool:
        samples = len(jax.tree.leaves(self.data.inputs)[0])
        least = KEPT_PAYS if in_use() and key_of(self.static) is not None else PAYS
        if (samples * points * max(1 + self.size, *PRICES.values()) - COMPILED) * _MOST < least:
            return False
        backwards, _ = self._priced
        passes = backwards if backwards and points == 1 else 1 + self.size
        turns = samples * passes * points - COMPILED
        return bool(turns * _operations(self.static, self.size, *shapes) >= least)

    def _slower_than_backward(self, native: "Native | Backwards", shapes: Any) -> bool:
        """Whether derivatives in C cost more than XLA's way back, as through dense matrices."""
        backwards, _ = self._priced
        if not backwards:
            return False
        most = backwards * _operations(self.static, self.size, *shapes)
        even = _EVEN_BACK if native.returns else _EVEN
        return bool(even * native.operations > most)

    def _agrees(self, found: Both, z: np.ndarray) -> bool:
        """Whether both equal XLA's; also False where XLA's are not finite.

        Raises:
            NoCodeError: where they differ.
        """
        value, gradient = self.exact(z)
        right = np.array([value, *gradient])
        apart = np.abs(np.array([found[0], *found[1]]) - right).max()
        if not np.isfinite(right).all():
            return False
        if not apart <= AGREED * np.abs(right).max():
            raise NoCodeError(f"compiled C differs from it by {apart:.1g} at the first point")
        return True


def _shapes(data: Data, folds: bool) -> tuple[tuple[Any, ...], Any]:
    """Shapes and types of a record; of any length where the loop sums everything up."""
    leaves, tree = jax.tree.flatten(data)
    arrays = [np.asarray(leaf) for leaf in leaves]
    return tuple(((1, *x.shape[1:]) if folds else x.shape, x.dtype) for x in arrays), tree


def _data(leaves: tuple[Any, ...], tree: Any) -> Data:
    return cast("Data", jax.tree.unflatten(tree, [jax.ShapeDtypeStruct(*leaf) for leaf in leaves]))


@lru_cache(maxsize=32)
def _made(static: Static, size: int, leaves: tuple[Any, ...], tree: Any, folder: Path) -> "Native":
    from tuner.native.compiled import Native

    filter, data = cast("AnyFilter", static.filter), _data(leaves, tree)
    texts = KeptTexts((static, size, _plain(leaves, tree)))
    return Native(filter, static.objective, static.built, size, data, folder, texts)


@lru_cache(maxsize=32)
def _back(
    static: Static, size: int, leaves: tuple[Any, ...], tree: Any, folder: Path
) -> "Backwards":
    from tuner.native.backwards import Backwards

    filter, data = cast("AnyFilter", static.filter), _data(leaves, tree)
    texts = KeptTexts((static, size, _plain(leaves, tree)))
    return Backwards(filter, static.objective, static.built, size, data, folder, texts)


def _shortest(
    static: Static, size: int, leaves: tuple[Any, ...], tree: Any, folder: Path
) -> "Native | Backwards":
    """C that goes forwards for few parameters, and back for more where that is less work."""
    given = static, size, leaves, tree, folder
    texts = KeptTexts((static, size, _plain(leaves, tree)))
    if size <= _FEW or not texts.of("goes back", partial(_back_is_less, *given)):
        return _made(*given)
    return _back(*given)


def _back_is_less(static: Static, size: int, *given: Any) -> bool:
    from tuner.native.compiled import LANES

    try:
        back = _back(static, size, *given).work
    except (NoCounterpartError, TooLargeError):
        return False
    try:
        one = _made(static, size, *given).work if size <= LANES else None
    except (NoCounterpartError, TooLargeError):
        one = None
    return one is None or back < one


def _plain(leaves: tuple[Any, ...], tree: Any) -> Any:
    """Shapes and types as plain data."""
    return jax.tree.unflatten(tree, [(shape, dtype.str) for shape, dtype in leaves])


@lru_cache(maxsize=128)
def _operations(static: Static, size: int, leaves: tuple[Any, ...], tree: Any) -> int:
    """Approximate number of operations of a step."""
    plain = _plain(tuple((shape[1:], dtype) for shape, dtype in leaves), tree)

    def counted() -> str:
        return str(_counted(static, size, leaves, tree))

    return int(stored_text(counted, "operations of a step", static, size, plain))


def _counted(static: Static, size: int, leaves: tuple[Any, ...], tree: Any) -> int:
    from tuner.code.straight_line import Slot, straight_line, work

    filter, data = cast("AnyFilter", static.filter), _data(leaves, tree)
    one = jax.tree.map(lambda leaf: jax.ShapeDtypeStruct(leaf.shape[1:], leaf.dtype), data.inputs)
    params = jax.eval_shape(static.built, jax.ShapeDtypeStruct((size,), float))
    given = params, jax.eval_shape(filter.init, params), one
    closed = jax.make_jaxpr(filter.step)(*given)
    slots = [Slot(leaf.shape, np.dtype(leaf.dtype)) for leaf in jax.tree.leaves(given)]
    return work(straight_line(closed, slots).operations)
