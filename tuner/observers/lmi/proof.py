"""Proofs about a least variance: its lower bound, and whether an observer reaches it."""

from itertools import pairwise

import numpy as np

from objectives.linear_systems.model import derived
from tuner.certificate.solution import Status
from tuner.convex import MARGIN, Answer, solve
from tuner.observers.lmi.design import Design
from tuner.observers.lmi.inequalities import gain_of, variance_program

AGREEMENT = 1e-6
"""Relative tolerance at which both sides of a certificate agree."""

CAPS = (1e1, 1e2, 1e3)
"""Bounds on Y, in the own units of a system, that show whether an optimum is reached."""

ROUNDING = 1e-11
"""Tolerance of an inequality for rounding, in the own units of a system."""


def proved(design: Design, gain: np.ndarray, primal: Answer, dual: Answer) -> float:
    """The larger of what both inequalities prove about trace M P M'.

    For every stable observer with covariance P, P - X solves a Lyapunov equation whose right-hand
    side is the Riccati inequality's matrix, so P >= X. What X lacks of the inequality is made up
    for by the covariance that a noise of that size would cause under the given gain.
    """
    bounds = [0.0]
    if primal.lower_bound is not None:
        bounds.append(primal.lower_bound * (1 - MARGIN * ROUNDING))
    if "X" in dual.variables:
        n, m, _ = design.sizes
        unit = {"W": np.eye(n), "V": np.eye(m), "S": np.zeros((n, m))}
        noisy = derived(design.system.matrices | unit, design.system.dt)
        lacking = MARGIN * max(dual.violation, ROUNDING) * Design(noisy, design.M).total(gain)
        bounds.append(float(design.variances(dual.variables["X"]).sum() - lacking))
    return max(bound for bound in bounds if np.isfinite(bound))


def met(value: float, lower: float) -> tuple[Status, str]:
    """Whether a variance meets its lower bound, and that in a sentence."""
    excess = value - lower
    share = excess / value if value and np.isfinite(value) else excess
    if share <= AGREEMENT:
        return Status.CONVERGED, f"the variance is within {max(share, 0.0):.1e} of its lower bound"
    return Status.STALLED, f"the variance is {share:.1e} of itself above its lower bound"


def limit(design: Design, lower: float) -> tuple[np.ndarray, Status, str]:
    """The optimum as Y may grow: whether it is a limit that no observer reaches.

    It is where each cap holds Y, and where the dual of each proves it worse than the next.

    Returns:
        The best gain, how it ended, and that in a sentence.
    """
    program = variance_program(design, capped=True)
    answers = [solve(program, {"cap": cap}) for cap in CAPS]
    gains = [gain_of(answer, design) for answer in answers]
    value, best = min((design.total(gain), i) for i, gain in enumerate(gains))
    held = all(_held(answer, cap) for answer, cap in zip(answers, CAPS, strict=True))
    if held and all(_worse(before, after) for before, after in pairwise(answers)):
        shares = ", ".join(f"{answer.value / answers[0].value:.4g}" for answer in answers)
        return (
            gains[best],
            Status.UNATTAINED,
            f"no observer reaches the lower bound: the variance falls (as {shares}) each time "
            "its inverse may grow tenfold",
        )
    return gains[best], *met(value, lower)


def _held(answer: Answer, cap: float) -> bool:
    """Whether a cap on Y is active."""
    return "Y" in answer.variables and np.linalg.eigvalsh(answer.variables["Y"])[-1] > 0.99 * cap


def _worse(before: Answer, after: Answer) -> bool:
    """Whether one program is proved to have a higher optimum than a point of another."""
    return before.lower_bound is not None and before.lower_bound > after.value
