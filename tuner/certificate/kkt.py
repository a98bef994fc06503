"""Constraints and limits at a point: their multipliers, and the directions they leave."""

from typing import NamedTuple

import numpy as np

from tuner.problem.constraint import ALLOWED
from tuner.problem.problem import Problem

PUSHING = 1e-6
"""Multipliers below this count as 0: without the constraint the optimum would hardly move."""
NEAR = 0.01
"""A coordinate this close to a bound counts as on it: barriers and samplers never reach it."""


class Held(NamedTuple):
    """A point with its active constraints and limits, in units of its yardstick.

    Attributes:
        gradient: of the Lagrangian: the objective's less the constraints' shares, ``(n,)``.
        weights: multiplier of every constraint, ``(m,)``, 0 where it is not active.
        limits: multiplier of every active limit of a coordinate, by its description.
        tangent: orthonormal directions along all active ones, ``(n, k)``; none along thresholds.
        excess: how far the worst constraint is exceeded, as a share of its bound.
        stepped: which coordinates are thresholds, ``(n,)`` of bool.
    """

    gradient: np.ndarray
    weights: np.ndarray
    limits: dict[str, float]
    tangent: np.ndarray
    excess: float
    stepped: np.ndarray


def hold(problem: Problem, z: np.ndarray, unit: float) -> Held:
    """The active constraints and limits at a point ``(n,)``; multipliers in units of the value.

    The multipliers are found from the gradients alone, by non-negative least squares, and so do
    not depend on what a solver says about them (Karush, Kuhn and Tucker's conditions).
    """
    gradient = problem.value_and_gradient(z)[1] / unit
    excess, slopes = problem.excesses(z)
    labels, limits, ends = _boundaries(problem, z)
    size, count = problem.space.size, len(labels)
    touched = excess >= -ALLOWED
    rows = np.vstack([slopes[touched], limits])
    # Along a threshold every derivative is 0 and carries no information.
    stepped = problem.space.thresholds()
    steps = np.eye(size)[stepped]
    worst, weights = float(excess.max(initial=-np.inf)), np.zeros(len(excess))
    if not len(rows) or not (np.isfinite(gradient).all() and np.isfinite(rows).all()):
        return Held(gradient, weights, {}, _orthogonal(steps, size), worst, stepped)
    from scipy.optimize import nnls

    # The box's own ends take their part as well, but their share stays in the gradient: a slope
    # against such an end says that the optimum lies beyond it.
    multipliers = nnls(np.vstack([rows, ends]).T, -gradient)[0][: len(rows)]
    weights[touched] = multipliers[: len(rows) - count]
    by_limit = dict(zip(labels, multipliers[len(rows) - count :].tolist(), strict=True))
    tangent = _orthogonal(np.vstack([rows[multipliers > PUSHING], steps]), size)
    return Held(gradient + rows.T @ multipliers, weights, by_limit, tangent, worst, stepped)


def at_ends(problem: Problem, z: np.ndarray) -> np.ndarray:
    """Which coordinates lie at an end of the search box, ``(n,)`` of bool."""
    low, high = problem.space.box()
    ends: np.ndarray = ((z <= low + NEAR) | (z >= high - NEAR)) & ~problem.space.limited()
    return ends


def pushed(problem: Problem, z: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Which coordinates the slope pushes against an end of the search box, ``(n,)`` of bool."""
    low, high = problem.space.box()
    outward = ((z <= low + NEAR) & (slopes > 0)) | ((z >= high - NEAR) & (slopes < 0))
    found: np.ndarray = outward & at_ends(problem, z)
    return found


def _boundaries(problem: Problem, z: np.ndarray) -> tuple[list[str], np.ndarray, np.ndarray]:
    """The limits that z lies on, in words and as outward normals; the normals of the box's ends."""
    low, high = problem.space.box()
    size, limited = problem.space.size, problem.space.limited()
    near = np.where(limited, ALLOWED * (high - low), NEAR)
    labels, limits, ends = [], np.zeros((0, size)), np.zeros((0, size))
    for i, name in enumerate(problem.space.coordinates):
        for end, word, sign in ((low[i], ">=", -1.0), (high[i], "<=", 1.0)):
            outward = sign * np.eye(size)[i]
            if abs(z[i] - end) > near[i]:
                continue
            if limited[i]:
                labels.append(f"{name} {word} {end:g}")
                limits = np.vstack([limits, outward])
            else:
                ends = np.vstack([ends, outward])
    return labels, limits, ends


def _orthogonal(rows: np.ndarray, size: int) -> np.ndarray:
    """An orthonormal basis of the directions orthogonal to all rows, ``(size, k)``."""
    if not len(rows):
        return np.eye(size)
    from scipy.linalg import null_space

    return np.asarray(null_space(rows))
