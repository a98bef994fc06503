"""Whether a constant that is changed shows in the results of a step, beyond rounding."""

from collections.abc import Collection, Sequence

import numpy as np

from tuner.code.array_step import Step
from tuner.code.expected import LONG, Expected, allowed, comparable
from tuner.code.mutants import CHANGE, Mutant
from tuner.code.sensitivity import sensitivities

FAINT, _CLEAR = 0.5, 60.0
"""The root of summed squares of moves over their tolerances below which a constant shows in none of
the results, and from which it does whichever of them share it."""
_PART = 64


def largest_moves(
    step: Step, mutants: Sequence[Mutant], right: Expected, change: float = CHANGE
) -> np.ndarray:
    """The largest move of a result over its tolerance, by a change of each constant, ``(M, B)``.

    0 in a step without finite results.
    """
    most = allowed(step, right)
    found = np.zeros((len(mutants), right.exact.shape[1]))
    with np.errstate(all="ignore"):
        for k, row in enumerate(step.results(right.values, mutants, change)):
            if row.ndim == 2:
                apart = np.abs(row.astype(float) - right.exact[k]) / most[k]
                other = np.isnan(row) != np.isnan(right.exact[k])
                found = np.fmax(found, np.where(other, np.inf, apart))
    return np.where(comparable(step, right), found, 0.0)


def detected(
    step: Step,
    mutants: Sequence[Mutant],
    right: Expected,
    margin: float,
    change: float = CHANGE,
) -> np.ndarray:
    """Which constants show in which steps, ``(M, B)``; none in a step without finite results."""
    return np.asarray(largest_moves(step, mutants, right, change) > margin)


def moves(
    step: Step,
    right: Expected,
    draw: np.random.Generator,
    whole: Collection[int] = (),
    uses: Sequence[Mutant] = (),
) -> dict[Mutant, np.ndarray]:
    """By how much each constant moves the results, over their tolerances, to first order.

    So do operations that are changed as a whole, and others where one operation uses them.

    The root of the sum of squares, ``(B,)``; 0 in steps that are not compared.
    """
    good = comparable(step, right)
    found = sensitivities(step, right.values, allowed(step, right), draw, whole, uses)
    return {one: np.where(good, size, 0.0) for one, size in found.items()}


def undetected(step: Step, right: Expected) -> list[Mutant]:
    """The constants that show in none of the steps."""
    mutants = step.mutants
    if not right.exact.shape[1]:
        return mutants
    if len(step.order) <= LONG:
        return _unseen(mutants, detected(step, mutants, right, 1.0))
    found = moves(step, right, np.random.default_rng(2))
    size = {one: float(x.max()) for one, x in found.items()}
    hidden = [one for one in mutants if one not in step.limits and size[one] <= FAINT]
    rest = [one for one in mutants if one in step.limits or FAINT < size[one] <= _CLEAR]
    for at in range(0, len(rest), _PART):
        part = rest[at : at + _PART]
        hidden += _unseen(part, detected(step, part, right, 1.0))
    return hidden


def _unseen(mutants: list[Mutant], shows: np.ndarray) -> list[Mutant]:
    return [one for one, row in zip(mutants, shows, strict=True) if not row.any()]
