"""Measured angles: differences within half a turn."""

from collections.abc import Sequence

import jax.numpy as jnp
from jax import Array


def wrapped(angle: Array) -> Array:
    """An angle within half a turn.

    >>> wrapped(jnp.array(5.0)).round(3).item()
    -1.283
    """
    turn = 2 * jnp.pi
    return angle - turn * jnp.round(angle / turn)


def difference(a: Array, b: Array, angles: Sequence[bool]) -> Array:
    """``a - b``, of angles within half a turn.

    Args:
        a: numbers, ``(m,)``; angles in rad.
        b: the same.
        angles: which of them are angles, m flags; empty where none is.

    Raises:
        ValueError: where there are not as many flags as numbers.

    >>> a, b = jnp.array([3.0, 3.0]), jnp.array([-3.0, -3.0])
    >>> [round(d, 3) for d in difference(a, b, (True, False)).tolist()]
    [-0.283, 6.0]
    """
    if not any(angles):
        return a - b
    if len(angles) != a.shape[-1]:
        raise ValueError(
            f"angles has {len(angles)} entries for {a.shape[-1]} numbers; give one for each, True "
            "where it is an angle in rad"
        )
    return jnp.where(jnp.array(angles), wrapped(a - b), a - b)
