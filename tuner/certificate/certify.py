"""The certificate of a point: gradient, bounds, curvature, and what is not determined."""

import math

import numpy as np

from tuner.certificate.kkt import Held, at_ends, pushed
from tuner.certificate.solution import Certificate, Starts
from tuner.certificate.spectrum import Spectrum
from tuner.certificate.yardstick import Best, Yardstick
from tuner.problem.problem import Problem

TENFOLD = math.log(10)
HARDLY = 0.1
"""Components of a direction below this share are left out of its sentence, if it holds without."""


def certify(
    problem: Problem,
    z: np.ndarray,
    held: Held,
    curved: Spectrum,
    undetermined: list[np.ndarray],
    starts: Starts,
) -> Certificate:
    """Judge a point of a problem.

    Args:
        problem: the problem; its objective should be differentiable near z.
        z: the point, ``(n,)``.
        held: which constraints hold it.
        curved: how the problem curves around it.
        undetermined: the directions that :func:`flat` found.
        starts: what the starts came to.

    Returns:
        The certificate, without any word from other methods.
    """
    labels = problem.space.coordinates
    bound = at_ends(problem, z)
    names = [constraint.name for constraint in problem.constraints]
    return Certificate(
        gradient={label: float(g) for label, g in zip(labels, held.gradient, strict=True)},
        active_bounds=tuple(label for label, at in zip(labels, bound, strict=True) if at),
        curvatures=tuple(float(c) for c in curved.curvatures),
        flat_directions=tuple(flat_in_words(labels, each) for each in undetermined),
        starts=starts,
        methods={},
        multipliers=dict(zip(names, held.weights.tolist(), strict=True)) | held.limits,
    )


def flat(problem: Problem, yard: Yardstick, z: np.ndarray, curved: Spectrum) -> list[np.ndarray]:
    """Directions along which a tenfold change either way is not distinguishable, found by trial.

    Each is ``(n,)``, of the largest entry 1: those axes of the curvature, or the one coordinate
    that such an axis is nearly, where that is flat by itself.
    """
    best, found = Best(problem, yard, z, problem.value(z)), []
    for direction in curved.directions.T[np.isfinite(curved.curvatures)]:
        step = direction / direction[np.argmax(np.abs(direction))]
        alone = np.where(np.abs(step) < HARDLY, 0.0, step)
        alike = next((each for each in (alone, step) if not _distinguishable(best, each)), None)
        found += [] if alike is None else [alike]
    return found


def _distinguishable(best: Best, direction: np.ndarray) -> bool:
    """Whether a tenfold change along a direction is distinguishable, to one side at least."""
    limited = best.problem.space.limited()
    low, high = best.problem.space.box()

    def moved(side: int) -> np.ndarray:
        point = best.z + side * TENFOLD * direction
        return np.where(limited, np.clip(point, low, high), point)

    return any(best.differs_from(moved(side)) for side in (1, -1))


def predicted_fall(problem: Problem, z: np.ndarray, held: Held, curved: Spectrum) -> float:
    """How far the value should fall from a point ``(n,)``, in units, by its derivatives there.

    To where the quadratic model is lowest, within a step of 1 along each axis and within the box.
    What pushes against an end of the box is left out. Without curvatures, or where they are not
    numbers, the slope alone predicts; NaN where that is not a number either.
    """
    slopes = np.where(pushed(problem, z, held.gradient), 0.0, held.gradient)
    known = len(curved.curvatures) > 0 and bool(np.isfinite(curved.curvatures).all())
    axes = curved.directions if known else held.tangent
    curvatures = curved.curvatures if known else np.zeros(axes.shape[1])
    along = np.abs(axes.T @ (slopes * _within(problem, z, slopes, curved.hessian)))
    near = (curvatures >= along) & (curvatures > 0)  # the model's lowest point is within 1
    inside = np.divide(along**2, 2 * curvatures, out=np.zeros_like(along), where=near)
    return float(np.where(near, inside, along - curvatures / 2).sum())


def _within(
    problem: Problem, z: np.ndarray, slopes: np.ndarray, hessian: np.ndarray | None
) -> np.ndarray:
    """Shares of the slopes that the box leaves: how far one can go down each, at most 1."""
    low, high = problem.space.box()
    left = np.where(slopes > 0, z - low, high - z)
    bend = np.zeros(len(z)) if hessian is None else np.maximum(np.diag(hessian), 0.0)
    reached = bend * left >= np.abs(slopes)  # the lowest point lies before the end
    return np.where(reached, 1.0, np.clip(left, 0.0, 1.0))


def flat_in_words(labels: list[str], direction: np.ndarray) -> str:
    """The change of the parameters that the data do not show, and the combination they determine.

    >>> flat_in_words(["ln R", "ln Q"], np.array([0.7, 0.7]))
    'R x 10 with Q x 10 changes nothing: only Q/R is determined'
    >>> flat_in_words(["ln R", "ln Q"], np.array([1.0, 0.0]))
    'R x 10 changes nothing: R is not determined'
    """
    direction = direction / direction[np.argmax(np.abs(direction))]
    moved = [(label, d) for label, d in zip(labels, direction, strict=True) if abs(d) > 0.02]
    steps = [
        f"{label[3:]} x {10**d:.3g}" if label.startswith("ln ") else f"{label} {d:+.2g}"
        for label, d in moved
    ]
    sentence = f"{' with '.join(steps)} changes nothing"
    if len(moved) == 1:
        name = moved[0][0].removeprefix("ln ").removeprefix("logit ")
        return f"{sentence}: {name} is not determined"
    if len(moved) > 2 or not all(label.startswith("ln ") for label, _ in moved):
        return f"{sentence}: these are determined up to that"
    (first, d1), (second, d2) = ((label[3:], d) for label, d in moved)
    power = d2 / d1
    name = first if abs(abs(power) - 1) < 0.02 else f"{first}^{abs(power):.2g}"
    return f"{sentence}: only {second}{'/' if power > 0 else '*'}{name} is determined"
