"""Steps that differ a little from given ones."""

import numpy as np

from tuner.code.covariances import symmetric
from tuner.code.states import Arrays

_SMALLEST, _LARGEST = -7.0, 0.5
"""Powers of ten of the changes, over the largest entry of a field."""
_BEGUN = 0.2
"""Share of the fields of zeros that do not stay so."""
_ZERO = 0.04
"""Share of the entries that become zero, and of those that change their sign."""

_EVEN = 0.06
"""Share of the fields whose entries are all zero or of one size, as where axes coincide."""


def varied(draw: np.random.Generator, steps: Arrays) -> Arrays:
    """The same steps with some entries of some fields moved, by much or by little.

    Args:
        draw: a generator.
        steps: states and samples, a field each, ``(count, ...)``.
    """
    return [_moved(draw, x) if x.dtype.kind == "f" else x for x in steps]


def _moved(draw: np.random.Generator, x: np.ndarray) -> np.ndarray:
    count, axes = len(x), (slice(None), *[None] * (x.ndim - 1))
    by = 10 ** draw.uniform(_SMALLEST, _LARGEST, count) * (draw.random(count) < 1 / 2)
    if symmetric(x):  # which stays so
        return np.asarray(x * (1 + by)[axes])
    size = np.abs(np.nan_to_num(x)).max(axis=tuple(range(1, x.ndim)), initial=0)
    begun = np.where(draw.random(count) < _BEGUN, 1.0, 0.0)
    scale = (by * np.where(size > 0, size, begun))[axes]
    moved = x + scale * draw.normal(size=x.shape) * (draw.random(x.shape) < 1 / 2)
    rare = draw.random(x.shape)
    found = np.where(rare < _ZERO, 0.0, np.where(rare > 1 - _ZERO, -moved, moved))
    even = (draw.random(count) < _EVEN)[axes]
    return np.where(even, size[axes] * draw.integers(-1, 2, x.shape), found)
