"""The certificate of a point: gradient, bounds, curvature, and what is not determined."""

import math
from typing import NamedTuple

import numpy as np

from tuner.certificate.kkt import NEAR, Held
from tuner.certificate.solution import Certificate, Starts, TunedParameter
from tuner.problem.problem import Problem

TENFOLD = math.log(10)
FLAT = 0.01
"""A direction is flat if a tenfold change along it changes the value by less than this share.

The intervals of :func:`estimates` are drawn where the value has risen by as much.
"""
STATIONARY = 1e-3
"""A point is stationary if a change by a factor e would, to first order, cost less than this."""


class Spectrum(NamedTuple):
    """How an objective curves around a point, relative to its value there.

    Attributes:
        curvatures: eigenvalues of the Hessian over the value, ascending, ``(k,)``.
        directions: their eigenvectors, one per column, ``(n, k)``; k < n where constraints hold.
    """

    curvatures: np.ndarray
    directions: np.ndarray


def spectrum(problem: Problem, z: np.ndarray, held: Held) -> Spectrum:
    """How a problem curves around a point ``(n,)`` along what keeps its active constraints.

    With constraints it is the Lagrangian that curves. NaN where the objective is not a number.
    """
    if not held.tangent.size:
        return Spectrum(np.zeros(0), held.tangent)
    hessian = problem.hessian(z) / (abs(problem.value(z)) or 1.0)
    if held.weights.any():
        hessian = hessian + problem.constraint_hessian(z, held.weights)
    if not np.isfinite(hessian).all():
        return Spectrum(np.full(len(z), np.nan), np.eye(len(z)))
    curvatures, directions = np.linalg.eigh(held.tangent.T @ hessian @ held.tangent)
    return Spectrum(curvatures, held.tangent @ directions)


def unknown_spectrum(size: int) -> Spectrum:
    """Where nobody asked how a problem of ``size`` coordinates curves."""
    return Spectrum(np.zeros(0), np.zeros((size, 0)))


def certify(
    problem: Problem, z: np.ndarray, held: Held, curved: Spectrum, starts: Starts
) -> Certificate:
    """Judge a point of a problem.

    Args:
        problem: the problem; its objective should be differentiable near z.
        z: the point, ``(n,)``.
        held: which constraints hold it.
        curved: how the problem curves around it.
        starts: what the starts came to.

    Returns:
        The certificate, without any word from other methods.
    """
    labels = problem.space.coordinates
    low, high = problem.space.box()
    bound = ((z <= low + NEAR) | (z >= high - NEAR)) & ~problem.space.limited()
    names = [constraint.name for constraint in problem.constraints]
    return Certificate(
        gradient={label: float(g) for label, g in zip(labels, held.gradient, strict=True)},
        active_bounds=tuple(label for label, at in zip(labels, bound, strict=True) if at),
        curvatures=tuple(float(c) for c in curved.curvatures),
        flat_directions=tuple(
            flat_in_words(labels, direction)
            for curvature, direction in zip(curved.curvatures, curved.directions.T, strict=True)
            if is_flat(float(held.gradient @ direction), float(curvature))
        ),
        starts=starts,
        methods={},
        multipliers=dict(zip(names, held.weights.tolist(), strict=True)) | held.limits,
    )


def is_flat(slope: float, curvature: float) -> bool:
    """Whether a tenfold change either way along a direction hardly changes the value.

    >>> is_flat(0.0, 1e-5), is_flat(0.0, 0.1), is_flat(0.1, 0.0), is_flat(0.0, -0.1)
    (True, False, False, False)
    """
    return abs(slope) * TENFOLD + abs(curvature) * TENFOLD**2 / 2 < FLAT


def is_stationary(problem: Problem, z: np.ndarray, gradient: dict[str, float]) -> tuple[bool, bool]:
    """Whether the gradient vanishes, and whether it does but for what pushes against a bound."""
    slopes = np.array(list(gradient.values()))
    low, high = problem.space.box()
    steep = ~(np.abs(slopes) <= STATIONARY)  # what is not a number is not stationary either
    held = ((z <= low + NEAR) & (slopes > 0)) | ((z >= high - NEAR) & (slopes < 0))
    return not steep.any(), not (steep & ~held).any()


def flat_in_words(labels: list[str], direction: np.ndarray) -> str:
    """Say which change of the parameters the data cannot see, and what is left determined.

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


def estimates(problem: Problem, z: np.ndarray, curved: Spectrum) -> dict[str, TunedParameter]:
    """The parameters at z ``(n,)`` with their units and 1 % intervals."""
    values = problem.parameters(z)
    spread = _spread(curved)
    found, at = {}, 0
    for name, parameter in problem.space.parameters:
        interval = None
        if parameter.size == 1 and 0 < spread[at] < np.inf:
            reach = np.where(np.arange(len(z)) == at, spread, 0.0)
            low, high = problem.parameters(z - reach)[name], problem.parameters(z + reach)[name]
            interval = float(low), float(high)
        found[name] = TunedParameter(values[name], parameter.unit, interval)
        at += parameter.size
    return found


def _spread(curved: Spectrum) -> np.ndarray:
    """Half-widths in z, ``(n,)``, within which the value rises by 1 %; infinite along flat ones."""
    curvatures, directions = curved
    rising = curvatures * TENFOLD**2 / 2 >= FLAT
    squared = (directions[:, rising] ** 2 / curvatures[rising]).sum(axis=1)
    squared[(np.abs(directions[:, ~rising]) > 0.02).any(axis=1)] = np.inf
    return np.asarray(np.sqrt(2 * FLAT * squared))
