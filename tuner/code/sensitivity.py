"""How far a change of every constant of a step moves its results, from one pass backwards."""

from collections.abc import Collection, Sequence

import numpy as np

from tuner.code.array_step import Step
from tuner.code.evaluation import Sums, Values
from tuner.code.mutants import CHANGE, WHOLE, Mutant

_WEIGHTINGS = 4
"""Random sums of the results whose derivatives are taken together."""
_SHIFT = 1e-6
"""Half the distance of a difference quotient, over the operand."""


def sensitivities(
    step: Step,
    values: Values,
    scales: np.ndarray,
    draw: np.random.Generator,
    whole: Collection[int] = (),
    uses: Sequence[Mutant] = (),
) -> dict[Mutant, np.ndarray]:
    """By how much a change of each constant moves the results of steps, ``(B,)`` each.

    The root of the sum of squared moves, each over its scale, to first order and estimated with
    random weights: all constants are had at the price of a few evaluations of the step. A limit
    that is passed has no derivative, and is 0 here.

    Args:
        step: the filter's.
        values: all its nodes, ``(B,)`` or ``(1,)`` each.
        scales: a size of each result, ``(roots, B)``.
        draw: a generator.
        whole: operations whose results are changed by the same share, as if they had a factor.
        uses: operands that are no constants and are changed by the same share, each where one
            operation uses it.
    """
    wanted = [*step.mutants, *uses, *(Mutant(k, WHOLE) for k in sorted(whole))]
    weights = _weights(scales, draw)
    squares = step.whole.slopes(values, Sums(step.roots, weights, wanted, CHANGE, _SHIFT))
    return dict(zip(wanted, np.sqrt(squares / _WEIGHTINGS), strict=True))


def _weights(scales: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """Random weights of the results over their scales, ``(_WEIGHTINGS, roots, B)``."""
    with np.errstate(all="ignore"):
        found = draw.normal(size=(len(scales), _WEIGHTINGS, 1)) / scales[:, None]
    return np.where(np.isfinite(found), found, 0.0).transpose(1, 0, 2)
