"""The identity of a problem: a digest that differs wherever the numbers would."""

import hashlib
from collections.abc import Iterable

import jax
import numpy as np

from objectives import Data
from tuner.problem.space import Space


def identity_of(programs: Iterable[str], space: Space, data: Data) -> str:
    """The SHA-256 of what is computed, over what and on which data.

    Args:
        programs: digests of the traced programs, with all constants: they hold everything that a
            filter, an objective or a function of the user's own reads during tracing.
        space: the coordinates.
        data: the arrays, to the bit.
    """
    digest = hashlib.sha256()
    for text in programs:
        digest.update(_sized(text.encode()))
    low, high = space.box()
    for array in (space.start(), low, high, *jax.tree.leaves(data)):
        bits = np.asarray(array)
        digest.update(_sized(f"{bits.dtype.str}{bits.shape}".encode()) + _sized(bits.tobytes()))
    digest.update(_sized(repr((space.coordinates, jax.tree.structure(data))).encode()))
    return digest.hexdigest()


def _sized(part: bytes) -> bytes:
    return f"{len(part)}:".encode() + part
