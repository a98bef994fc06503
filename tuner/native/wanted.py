"""C of a problem, made once for all records of the same kind: it goes forwards, or back."""

from collections.abc import Hashable
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, cast

import jax
import numpy as np
from jax import Array

from filters import AnyFilter
from objectives import Data, Objective
from tuner.code.graph import TooLargeError
from tuner.code.refused import NoCounterpartError
from tuner.native.kept_texts import KeptTexts
from tuner.stored_programs import stored_text

if TYPE_CHECKING:
    from tuner.native.backwards import Backwards
    from tuner.native.compiled import Native

_FEW = 4
"""Parameters whose derivatives always go forwards in C."""


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


class Shapes(NamedTuple):
    """Shapes and types of a record."""

    leaves: tuple[Any, ...]
    tree: Any

    @property
    def data(self) -> Data:
        """A record in their place."""
        leaves = [jax.ShapeDtypeStruct(*leaf) for leaf in self.leaves]
        return cast("Data", jax.tree.unflatten(self.tree, leaves))

    @property
    def plain(self) -> Any:
        """As plain data."""
        leaves = [(shape, np.dtype(dtype).str) for shape, dtype in self.leaves]
        return jax.tree.unflatten(self.tree, leaves)


class Wanted(NamedTuple):
    """What C is made for.

    Attributes:
        static: of the compilation.
        size: of a point.
        shapes: of a record.
        folder: for compiled code.
        settle: whether it may go on with constant gains where they have settled.
    """

    static: Static
    size: int
    shapes: Shapes
    folder: Path
    settle: bool = True

    @property
    def texts(self) -> KeptTexts:
        """Its texts, kept between runs."""
        return KeptTexts((self.static, self.size, self.shapes.plain, self.settle))


def shapes_of(data: Data, *, folds: bool) -> Shapes:
    """Shapes and types of a record; of any length where the loop sums everything up."""
    leaves, tree = jax.tree.flatten(data)
    arrays = [np.asarray(leaf) for leaf in leaves]
    return Shapes(tuple(((1, *x.shape[1:]) if folds else x.shape, x.dtype) for x in arrays), tree)


@lru_cache(maxsize=32)
def forwards(wanted: Wanted) -> "Native":
    """C that goes forwards, or takes several points at once.

    Raises:
        NoCounterpartError, TooLargeError: as :class:`tuner.native.compiled.Native`.
    """
    from tuner.native.compiled import Native

    static, size, shapes, folder, settle = wanted
    given = cast("AnyFilter", static.filter), static.objective, static.built, size, shapes.data
    return Native(*given, folder, wanted.texts, settle=settle)


@lru_cache(maxsize=32)
def _back(wanted: Wanted) -> "Backwards":
    from tuner.native.backwards import Backwards

    static, size, shapes, folder, _ = wanted
    given = cast("AnyFilter", static.filter), static.objective, static.built, size, shapes.data
    return Backwards(*given, folder, wanted.texts)


def shortest(wanted: Wanted) -> "Native | Backwards":
    """C that goes forwards for few parameters, and back for more where that is less work.

    Raises:
        NoCounterpartError, TooLargeError: as both of them.
    """
    if wanted.size <= _FEW or not wanted.texts.of("goes back", lambda: _back_is_less(wanted)):
        return forwards(wanted)
    return _back(wanted)


def _back_is_less(wanted: Wanted) -> bool:
    from tuner.native.compiled import LANES

    try:
        back = _back(wanted).work
    except (NoCounterpartError, TooLargeError):
        return False
    try:
        one = forwards(wanted).work if wanted.size <= LANES else None
    except (NoCounterpartError, TooLargeError):
        one = None
    return one is None or back < one


@lru_cache(maxsize=128)
def operations(static: Static, size: int, shapes: Shapes) -> int:
    """Approximate number of operations of a step."""
    one = Shapes(tuple((shape[1:], dtype) for shape, dtype in shapes.leaves), shapes.tree)

    def counted() -> str:
        return str(_counted(static, size, one))

    return int(stored_text(counted, "operations of a step", static, size, one.plain))


def _counted(static: Static, size: int, sample: Shapes) -> int:
    from tuner.code.straight_line import Slot, straight_line, work

    filter = cast("AnyFilter", static.filter)
    params = jax.eval_shape(static.built, jax.ShapeDtypeStruct((size,), float))
    given = params, jax.eval_shape(filter.init, params), sample.data.inputs
    closed = jax.make_jaxpr(filter.step)(*given)
    slots = [Slot(leaf.shape, np.dtype(leaf.dtype)) for leaf in jax.tree.leaves(given)]
    return work(straight_line(closed, slots).operations)
