"""Test for angles that jump by a full turn."""

import numpy as np

from tuner.diagnostics.column import Column
from tuner.diagnostics.finding import Finding, judged, not_tried
from tuner.diagnostics.innovations import Innovations
from tuner.diagnostics.outliers import outlying

NAME, WHAT = "full turns", "innovations at a multiple of a full turn"
NEAR = 3.0
"""In deviations."""
LIKELY, SURE = 0.05, 0.2
"""Probabilities below which it fails: normal noise makes no such number, so they need only tell
wrapped angles from other outliers; the second where the measurements are known to be angles."""
APART = 8.0
"""The fewest deviations in a turn for noise not to be mistaken for one."""


def of_turns(innovations: Innovations, columns: tuple[Column, ...], way: str) -> Finding:
    """Test whether the first innovation of each disturbance is a multiple of a full turn.

    The probability is that of outliers of any size to be as near to one.

    Args:
        innovations: of the run.
        columns: their measurements.
        way: the remedy, in words.
    """
    from tuner.distributions import more_than

    looks = []
    for turn in innovations.turns:
        for column in columns:
            deviation = np.abs(column.y / np.where(column.e == 0, 1.0, column.e)) * column.scale
            far = (np.abs(column.y) > turn / 2) & (APART * deviation < turn)
            begun = np.flatnonzero(outlying(column) & far)
            typical = float(np.median(deviation))
            if not 0 < APART * typical < turn:
                continue
            off = np.abs(column.y[begun] - turn * np.rint(column.y[begun] / turn))
            whole = np.rint(column.y[begun] / turn) != 0
            near = begun[(off <= NEAR * deviation[begun]) & whole]
            share = 2 * NEAR * float(np.mean(deviation[begun])) / turn if len(begun) else 1.0
            p = more_than(len(near) - 1, len(begun), min(share, 1.0))
            looks.append((p, len(near), turn, column, near))
    if not looks:
        why = "no measurement is an angle" if not innovations.turns else "noise is as large"
        return not_tried(NAME, WHAT, why)
    p, count, turn, column, near = min(looks, key=lambda look: (look[0], -look[1]))
    where = innovations.place(column, int(near[0])) if count else ""
    plural = "innovation lies" if count == 1 else "innovations lie"
    sentence = (
        f"{count} {plural} within the noise of a full turn ({turn:.6g}), the first {where}: the "
        f"angle is wrapped; {way}"
    )
    known = len(innovations.turns) == 1
    level = SURE if known else LIKELY
    return judged(NAME, WHAT, count, p if count else 1.0, sentence, {"turn": turn}, level)
