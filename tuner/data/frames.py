"""The frame of an attitude, found by the direction in which it turns gravity's reaction."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tuner.data.signal import Floats

_FITS = 0.05  # mean of 1 - cos of the angle to the vertical: 18 deg by accelerations
_BETTER = 1.5
_TELLING = 0.005  # 6 deg
_NO_FRAME = 0.3
_CALM = 0.05  # only samples within this distance of the usual force count: the others accelerate


@dataclass(frozen=True, eq=False)
class Frame:
    """The relation of an attitude to sensor-to-earth with earth z up.

    Attributes:
        fits: whether it is the same.
        up: mean direction of the specific force, turned by it: a unit vector or shorter.
        meaning: what it is instead, as far as gravity shows; empty where nothing fits.
        columns: how it would be mapped, of q0 to q3; empty where no order and signs will do.
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

    A turn about the vertical cannot be seen: the heading may have any zero.

    Args:
        truth: quaternions, ``(N, 4)``; rows with NaN do not count.
        acc: specific force in sensor axes, ``(N, 3)``.

    Returns:
        None where there are too few samples, or too little tilt to tell.
    """
    rows = ~np.isnan(truth).any(axis=1) & ~np.isnan(acc).any(axis=1)
    size, force = np.linalg.norm(truth, axis=1), np.linalg.norm(acc, axis=1)
    rows &= (size > 0.0) & (force > 0.0)
    if rows.sum() < 10:
        return None
    calm = rows & (np.abs(force - np.median(force[rows])) < _CALM * np.median(force[rows]))
    rows = calm if calm.sum() >= 10 else rows
    q, f = truth[rows] / size[rows, None], acc[rows] / force[rows, None]
    up = rotated(q, f).mean(axis=0)
    miss, (meaning, order, signs) = min(
        ((1.0 - rotated(q[:, r[1]] * r[2], f).mean(axis=0)[2], r) for r in _readings()),
        key=lambda found: found[0],
    )
    ours = 1.0 - up[2]
    if miss <= _FITS and ours > _BETTER * miss + _TELLING:
        return Frame(False, up, meaning, _written(order, signs))
    turn = _turned(q, f, ours) if ours > _FITS else ""
    return Frame(ours <= _NO_FRAME and not turn, up, turn)


def _turned(q: Floats, f: Floats, miss: float) -> str:
    """The rotation of sensor axes that makes a truth fit; empty where none does.

    The best one in the sense of least squares, by the singular values (Kabsch, Acta Cryst. A32,
    1976).
    """
    conjugate = q * np.array([1.0, -1.0, -1.0, -1.0])
    vertical = rotated(conjugate, np.tile([0.0, 0.0, 1.0], (len(q), 1)))
    left, sizes, right = np.linalg.svd(vertical.T @ f / len(f))
    if sizes[1] < _TELLING:
        return ""  # gravity was always along one axis
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    if 1.0 - float((vertical * (f @ turn.T)).sum(axis=1).mean()) > min(_FITS, 0.5 * miss):
        return ""
    angle = np.degrees(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0)))
    axis = np.linalg.eigh(turn + turn.T)[1][:, -1]
    sense = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    axis = -axis if axis @ sense < 0.0 else axis
    text = ", ".join(f"{part + 0.0:.2f}" for part in np.round(axis, 2))
    return f"that of axes turned by {angle:.0f} deg about ({text}) of the sensor's"


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
