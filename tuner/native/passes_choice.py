"""The choice between scalars and arrays for a pass over a record and one back."""

from collections.abc import Callable
from typing import Any

from jax import Array

from tuner.code.graph import TooLargeError
from tuner.code.refused import NoCounterpartError
from tuner.native.array_passes import array_passes
from tuner.native.passes import passes
from tuner.native.passes_frame import Code
from tuner.native.passes_text import code
from tuner.native.reversal import MOST_TRACED, Before, reversal
from tuner.native.runner import Runner

FEW = 4000
"""Operations of scalars that are taken in any case: their code is small and fast."""
_FOLDED = 2
"""Share of traced operations on scalars that may turn out constant: beyond it arrays are chosen."""


def shortest(runner: Runner, build: Callable[[Array], Any], size: int) -> tuple[Before, Code]:
    """The C that takes fewer operations, and what precedes its loop.

    Of scalars no operation on a structural zero is left, and only one half of a symmetric matrix;
    of arrays several entries of a row are computed at once.

    Args:
        runner: the loop.
        build: the map from a point to the filter's parameters.
        size: of a point.

    Raises:
        NoCounterpartError: names the operation that has no counterpart in either.
        TooLargeError: for too many operations.
    """
    before = Before(runner, build, size)
    by_arrays = before.by_arrays()
    refused: ValueError | None = None
    try:
        rows = array_passes(runner, by_arrays)
    except NoCounterpartError as error:
        rows, refused = None, error
    most = MOST_TRACED if rows is None else _FOLDED * max(FEW, rows.operations)
    try:
        traced = reversal(runner, before, min(most, MOST_TRACED))
        flat = code(passes(traced), [real for _, real in traced.kept])
    except (NoCounterpartError, TooLargeError) as error:
        if rows is None:
            raise error from refused
        return by_arrays, rows
    if rows is None or flat.operations < max(FEW, rows.operations):
        return before, flat
    return by_arrays, rows
