"""In which frame an attitude is: told by where it turns gravity's reaction."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tuner.data.record import Floats

_FITS = 0.95


@dataclass(frozen=True, eq=False)
class Frame:
    """How an attitude stands to sensor-to-earth with earth z up.

    Attributes:
        fits: whether it is just that.
        up: where it turns the mean direction of the specific force, a unit vector or shorter.
        meaning: what it is instead, as far as gravity shows.
        columns: how it would be mapped, of q0 to q3; empty where nothing fits.
    """

    fits: bool
    up: Floats
    meaning: str = ""
    columns: str = ""


def rotated(q: Floats, vectors: Floats) -> Floats:
    """Vectors ``(N, 3)`` turned by unit quaternions w x y z, ``(N, 4)``.

    >>> rotated(np.array([[0.0, 1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])).tolist()
    [[0.0, 0.0, -1.0]]
    """
    w, xyz = q[:, :1], q[:, 1:]
    once = 2.0 * np.cross(xyz, vectors)
    return vectors + w * once + np.cross(xyz, once)


def frame_of(truth: Floats, acc: Floats) -> Frame | None:
    """Find how a true attitude has to be read so that gravity's reaction points up.

    A turn about the vertical cannot be seen: the heading may be of any zero.

    Args:
        truth: quaternions, ``(N, 4)``; rows with NaN do not count.
        acc: specific force in sensor axes, ``(N, 3)``.

    Returns:
        None where there are too few samples, or hardly any tilt and so nothing to tell.
    """
    rows = ~np.isnan(truth).any(axis=1) & ~np.isnan(acc).any(axis=1)
    size, force = np.linalg.norm(truth, axis=1), np.linalg.norm(acc, axis=1)
    rows &= (size > 0.0) & (force > 0.0)
    if rows.sum() < 10:
        return None
    q, f = truth[rows] / size[rows, None], acc[rows] / force[rows, None]
    up = rotated(q, f).mean(axis=0)
    if up[2] > _FITS:
        return Frame(True, up)
    for meaning, order, signs in _readings():
        if rotated(q[:, order] * signs, f).mean(axis=0)[2] > _FITS:
            return Frame(False, up, meaning, _written(order, signs))
    return Frame(False, up)


def _readings() -> Iterator[tuple[str, list[int], Floats]]:
    """Other readings of four columns, the usual ones first: meaning, order and signs."""
    orders = {"": [0, 1, 2, 3], "x y z w": [3, 0, 1, 2]}
    turns = {
        "": ([0, 1, 2, 3], [1, 1, 1, 1]),
        "earth to sensor": ([0, 1, 2, 3], [1, -1, -1, -1]),
        "of axes forward, right, down in north, east, down": ([0, 1, 2, 3], [1, 1, -1, -1]),
        "in an earth frame with z down": ([1, 0, 3, 2], [-1, 1, -1, 1]),
        "of sensor axes with z down": ([1, 0, 3, 2], [-1, 1, 1, -1]),
        "earth to sensor, forward, right, down in north, east, down": (
            [0, 1, 2, 3],
            [1, -1, 1, 1],
        ),
        "earth to sensor, with earth z down": ([1, 0, 3, 2], [1, 1, 1, -1]),
        "earth to sensor, with sensor z down": ([1, 0, 3, 2], [1, 1, -1, 1]),
    }
    for order, columns in orders.items():
        for turn, (places, signs) in turns.items():
            if order or turn:
                meaning = ", ".join(word for word in (order, turn) if word)
                yield meaning, [columns[place] for place in places], np.array(signs, float)


def _written(order: list[int], signs: Floats) -> str:
    """The columns of a reading as ``--truth`` takes them."""
    return ",".join(
        f"{'-' if sign < 0 else ''}q{column}" for column, sign in zip(order, signs, strict=True)
    )
