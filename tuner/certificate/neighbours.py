"""Tests of a point by its neighbours: is one lower, is there a kink, are there steps?"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tuner.certificate.kkt import Held, pushed
from tuner.certificate.spectrum import Spectrum
from tuner.certificate.yardstick import Yardstick
from tuner.problem.constraint import ALLOWED
from tuner.problem.problem import Problem

DISTANCES = (0.03, 0.3, 1.0)
"""How far from a point its neighbours are tried, along every axis of its curvature."""
APART = 1.5
"""Points of a search through the whole box lie no further apart, unless the box is enormous."""
NEAR = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
"""How far they are tried down the slope."""
FINE = 1e-3
"""At this distance a smooth value follows its gradient."""


class Neighbours(NamedTuple):
    """The values of a point's neighbours, and their verdict on it.

    Attributes:
        lower: the lowest of them, ``(n,)``, where one is lower by more than is negligible.
        rough: whether the derivatives say nothing: the value rises where they say it falls, or
            changes where they are 0.
        steps: whether it does not change at all in between.
        evaluations: how many there were.
    """

    lower: np.ndarray | None
    rough: bool
    steps: bool
    evaluations: int


class _Trial(NamedTuple):
    """Values in units above the point's, at points within the box."""

    problem: Problem
    yard: Yardstick
    value: float

    def rise(self, point: np.ndarray) -> float:
        return self.yard.of(self.problem.value(point) - self.value)

    def clipped(self, point: np.ndarray) -> np.ndarray:
        low, high = self.problem.space.box()
        return np.asarray(np.clip(point, low, high))


def neighbours(
    problem: Problem, yard: Yardstick, z: np.ndarray, held: Held, curved: Spectrum
) -> Neighbours:
    """Evaluate the neighbours of a point ``(n,)`` that meet every constraint.

    Down the slope at all distances, where the quadratic model has its lowest point, and along every
    axis of the curvature both ways. At a kink the slope is that of the steepest side; the direction
    down the shortest mean of the slopes around it is tried instead (Burke, Lewis, Overton, SIAM J.
    Optim. 15, 2005).
    """
    trial = _Trial(problem, yard, problem.value(z))
    slope = np.asarray(held.tangent @ (held.tangent.T @ _inward(problem, z, held.gradient)))
    points = [trial.clipped(point) for point in _points(z, slope, curved, held)]
    rises = [trial.rise(point) for point in points]
    rough, steps = _roughness(trial, z, slope, held, curved)
    if rough:
        points += [trial.clipped(z + step) for step in _past_kinks(problem, z, held)]
        rises += [trial.rise(point) for point in points[len(rises) :]]
    lower = _lowest(problem, yard, points, rises)
    return Neighbours(lower, rough, steps, len(points) + 3)


def lower_afar(problem: Problem, yard: Yardstick, z: np.ndarray) -> np.ndarray | None:
    """The lowest point along the coordinates of z ``(n,)``, all through the box; None: itself.

    A plateau may be wider than any neighbourhood.
    """
    trial = _Trial(problem, yard, problem.value(z))
    low, high = problem.space.box()
    points, steps = [], problem.space.thresholds()
    for at in range(len(z)):
        # A threshold has no slope that would lead on from a point nearby.
        count = 60 if steps[at] else int(np.clip((high[at] - low[at]) / APART, 8, 40))
        for end in np.linspace(low[at], high[at], count):
            points.append(np.where(np.arange(len(z)) == at, end, z))
    return _lowest(problem, yard, points, [trial.rise(point) for point in points])


def _inward(problem: Problem, z: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    """The gradient without what pushes against an end of the box."""
    known = np.where(np.isfinite(gradient), gradient, 0.0)
    return np.where(pushed(problem, z, known), 0.0, known)


def _points(z: np.ndarray, slope: np.ndarray, curved: Spectrum, held: Held) -> Iterator[np.ndarray]:
    size = float(np.linalg.norm(slope))
    if size > 0:
        yield from (z - far * slope / size for far in NEAR)
        yield from (z - step for step in _model_steps(slope, curved))
    axes = curved.directions.T if len(curved.curvatures) else held.tangent.T
    for axis in (*axes, *_thresholds(held)):
        yield from (z + side * far * axis for far in DISTANCES for side in (-1, 1))


def _thresholds(held: Held) -> np.ndarray:
    """The axes without a tangent, along which every derivative is 0."""
    size = len(held.tangent)
    covered = (held.tangent**2).sum(axis=1) > 1e-9
    axes: np.ndarray = np.eye(size)[~covered & held.stepped]
    return axes


def _model_steps(slope: np.ndarray, curved: Spectrum) -> Iterator[np.ndarray]:
    """Newton's step, flat axes at most 1 long; the same by the curvature's size alone."""
    if not len(curved.curvatures) or not np.isfinite(curved.curvatures).all():
        return
    along = curved.directions.T @ slope
    safe = np.maximum(np.abs(curved.curvatures), np.abs(along))
    yield curved.directions @ np.divide(along, safe, out=np.zeros_like(along), where=safe > 0)


def _bends_too_late(
    trial: _Trial, z: np.ndarray, slope: np.ndarray, held: Held, curved: Spectrum
) -> bool:
    """Whether the slope half-way to where the curvature has it vanish is still the whole one.

    Differences over a step that a kink lies within make a curvature of it.
    """
    for step in _model_steps(slope, curved):
        if 0 < np.abs(step).max() < 2 * FINE:
            _, gradient = trial.problem.value_and_gradient(trial.clipped(z - step / 2))
            half = held.tangent @ (held.tangent.T @ (gradient / trial.yard.unit))
            return bool(np.linalg.norm(half - slope / 2) > np.linalg.norm(slope) / 4)
    return False


def _roughness(
    trial: _Trial, z: np.ndarray, slope: np.ndarray, held: Held, curved: Spectrum
) -> tuple[bool, bool]:
    """Whether derivatives mislead, and whether the value stays the same in between."""
    if _has_steps(trial, z, held):
        return True, True
    size = float(np.linalg.norm(slope))
    if not size * FINE > 1e-3 * trial.yard.negligible:
        return False, False
    if _bends_too_late(trial, z, slope, held, curved):
        return True, False
    down = -slope / size
    bend = float(down @ curved.hessian @ down) if curved.hessian is not None else 0.0
    near, nearer = (trial.rise(trial.clipped(z + far * down)) for far in (FINE, FINE / 10))
    rough = all(
        rise - (bend * far**2 / 2 - size * far) > 0.5 * size * far
        for rise, far in ((near, FINE), (nearer, FINE / 10))
    )
    # A jump is as high from close by as from afar.
    steps = rough and (near == nearer == 0.0 or (nearer > 0 and near < 2 * nearer))
    return rough, steps


def _has_steps(trial: _Trial, z: np.ndarray, held: Held) -> bool:
    """Whether a coordinate has a slope of exactly 0 and matters only at a distance."""
    for axis in np.eye(len(z))[(held.gradient == 0) & ~held.stepped]:
        around = (trial.clipped(z + side * FINE / 10 * axis) for side in (-1, 1))
        if all(trial.rise(point) == 0 for point in around):
            afar = (trial.clipped(z + side * far * axis) for side in (-1, 1) for far in DISTANCES)
            if any(abs(trial.rise(point)) > trial.yard.negligible for point in afar):
                return True
    return False


def _past_kinks(problem: Problem, z: np.ndarray, held: Held) -> Iterator[np.ndarray]:
    """Steps down the shortest mean of the slopes around a point."""
    size = len(z)
    offsets = np.vstack([np.eye(size), -np.eye(size)]) * FINE
    low, high = problem.space.box()
    around = [problem.value_and_gradient(np.clip(z + step, low, high))[1] for step in offsets]
    slopes = np.array([g for g in around if np.isfinite(g).all()])
    if not len(slopes):
        return
    mean = held.tangent @ (held.tangent.T @ _shortest_mean(slopes))
    length = float(np.linalg.norm(mean))
    if length > 0:
        yield from (-far * mean / length for far in NEAR)


def _shortest_mean(slopes: np.ndarray) -> np.ndarray:
    """The shortest vector among the weighted means of vectors ``(m, n)``.

    >>> _shortest_mean(np.array([[1.0, 1.0], [-1.0, 1.0]])).round(6).tolist()
    [0.0, 1.0]
    """
    from scipy.optimize import nnls

    scale = np.abs(slopes).max() or 1.0
    # Weights that add up to 1, by a row that outweighs the others.
    weight = 1e4
    system = np.vstack([slopes.T / scale, np.full(len(slopes), weight)])
    weights, _ = nnls(system, np.append(np.zeros(slopes.shape[1]), weight))
    return np.asarray(weights @ slopes)


def _lowest(
    problem: Problem, yard: Yardstick, points: list[np.ndarray], rises: list[float]
) -> np.ndarray | None:
    for index in np.argsort(rises):
        if not rises[index] < -yard.negligible:
            return None
        if problem.excesses(points[index])[0].max(initial=-np.inf) <= ALLOWED:
            lower: np.ndarray = points[index]
            return lower
    return None
