"""Profile limits: where a value has risen by a given amount while the other parameters follow."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tuner.certificate.certify import TENFOLD
from tuner.certificate.yardstick import Yardstick
from tuner.problem.problem import Problem

INNER = {"likelihood": 6}
"""Steps of the other parameters towards their best, at each point of a profile; of a cost, 2."""
MANY = {"likelihood": 8}
"""From so many coordinates on, of a cost from 3 on, the others follow along the ridge of the
quadratic model alone: to move them at each point would cost many times what the search did."""
APART = 24
"""Points at which a coordinate that hardly matters is tried anew."""
PRECISION = 1e-3
"""Tolerance of a profile's limit, in the root of the rise."""


class Limit(NamedTuple):
    """One end of an interval.

    Attributes:
        z: the coordinate there.
        reached: whether the value rises that far within the box.
    """

    z: float
    reached: bool


class _Point(NamedTuple):
    """A point of a profile, and how far the value has risen there, in units."""

    z: np.ndarray
    rise: float


def limit(
    problem: Problem,
    yard: Yardstick,
    z: np.ndarray,
    hessian: np.ndarray,
    at: int,
    side: int,
    rise: float,
) -> Limit:
    """The end of a coordinate's profile, where the value has risen and the others have followed.

    Args:
        problem: the problem.
        yard: how rises are measured.
        z: the best point, ``(n,)``.
        hessian: in units, ``(n, n)``; where the model is wrong it costs evaluations, not digits.
        at: which coordinate.
        side: -1 for lower values, 1 for higher ones.
        rise: in units.

    Returns:
        The end, tried by evaluation: the value there has risen by that much, and is finite.
    """
    profile = _Profile.of(problem, yard, z, hessian, at)
    low, high = problem.space.box()
    furthest = high[at] - z[at] if side > 0 else z[at] - low[at]
    if furthest <= 0:
        return Limit(float(z[at]), False)
    span = float(np.clip(profile.deviation * np.sqrt(2 * rise), 1e-9, furthest))
    inside, outside = _Point(z, 0.0), None
    for _ in range(40):
        point = profile.at(inside, z[at] + side * span)
        if abs(np.sqrt(max(point.rise, 0.0) / rise) - 1) < PRECISION:
            return Limit(float(point.z[at]), True)
        if point.rise < rise:
            inside = point
            if span >= furthest:
                return Limit(float(point.z[at]), False)
        else:
            outside = point
        span = _next(z[at], inside, outside, rise, at, furthest)
        if outside is not None and span - abs(inside.z[at] - z[at]) < 1e-12 * (1 + span):
            break
    return Limit(float(inside.z[at]), outside is not None)


def _next(
    best: float, inside: _Point, outside: _Point | None, rise: float, at: int, furthest: float
) -> float:
    """The distance to try next: where the root of the rise, nearly a straight line, reaches it."""
    near, root = abs(inside.z[at] - best), np.sqrt(max(inside.rise, 0.0) / rise)
    if outside is None:
        guess = near / root if root > 0 else np.inf
        return float(min(max(1.05 * near, min(guess, 4 * near)), furthest))
    far = abs(outside.z[at] - best)
    beyond = np.sqrt(outside.rise / rise)
    share = (1 - root) / (beyond - root) if np.isfinite(beyond) else 0.5
    return float(near + np.clip(share, 0.1, 0.9) * (far - near))


@dataclass(frozen=True, eq=False)
class _Profile:
    """A profile of a value along a coordinate: its minimum with that coordinate held.

    Attributes:
        best, value: the best point, and the value there.
        held: the coordinate.
        others: which coordinates follow, ``(n,)`` of bool.
        deviation: how far a rise of half a unit is, by the quadratic model.
        ridge: how the coordinates follow in that model, per step of the one held, ``(n,)``.
        inverse: the inverse Hessian of the others in that model.
        insensitive: which of the others hardly matter there.
    """

    problem: Problem
    yard: Yardstick
    best: np.ndarray
    value: float
    held: int
    others: np.ndarray
    deviation: float
    ridge: np.ndarray
    inverse: np.ndarray
    insensitive: np.ndarray
    _tried: dict[bytes, float] = field(default_factory=dict)

    @classmethod
    def of(
        cls, problem: Problem, yard: Yardstick, z: np.ndarray, hessian: np.ndarray, held: int
    ) -> "_Profile":
        model, others = _positive(hessian), np.arange(len(z)) != held
        covariance = np.linalg.inv(model)
        return cls(
            problem,
            yard,
            z,
            problem.value(z),
            held,
            others,
            deviation=float(np.sqrt(covariance[held, held])),
            ridge=covariance[:, held] / covariance[held, held],
            inverse=np.linalg.inv(model[np.ix_(others, others)]),
            insensitive=_insensitive(problem, yard, hessian, others),
        )

    def at(self, near: _Point, coordinate: float) -> _Point:
        """The best point with the coordinate held there, searched from a point nearby."""
        start = self._start_near(near, coordinate)
        if not self.others.any() or len(start) >= MANY.get(self.yard.kind, 3):
            return self._measured(start)
        point = self._minimised(start)
        if len(self.insensitive):
            point = self._searched_globally(point)
        return self._measured(point)

    def _start_near(self, near: _Point, coordinate: float) -> np.ndarray:
        """On the ridge of the model, or with the others as they were: whichever is better.

        Beside a jump the model's curvatures are those of the jump, and its ridge leads across.
        """
        ridge = near.z + self.ridge * (coordinate - near.z[self.held])
        box = self.problem.space.box()
        start, plain = (np.asarray(np.clip(z, *box)) for z in (ridge, near.z))
        start[self.held] = plain[self.held] = coordinate
        if not self.others.any():
            return start
        better = self._value(start) <= self._value(plain)
        return start if better else plain

    def _searched_globally(self, point: np.ndarray) -> np.ndarray:
        """The point with the insensitive coordinates searched through their whole range.

        No slope shows where such a coordinate begins to matter, as one variance of two does whose
        sum alone is known.
        """
        low, high = self.problem.space.box()
        tried = [point]
        for at in self.insensitive:
            ends = np.linspace(low[at], high[at], APART)
            tried += [np.where(np.arange(len(point)) == at, end, point) for end in ends]
        values = [self._value(each) for each in tried]
        best = int(np.argmin(values))
        return self._minimised(tried[best]) if best else point

    def _measured(self, point: np.ndarray) -> _Point:
        return _Point(point, self.yard.of(self._value(point) - self.value))

    def _value(self, point: np.ndarray) -> float:
        """The value at a point, which is worked out once: most points are ends of no step."""
        key = point.tobytes()
        if key not in self._tried:
            self._tried[key] = self.problem.value(point)
        return self._tried[key]

    def _minimised(self, point: np.ndarray) -> np.ndarray:
        """The others moved to their best by quasi-Newton steps (BFGS) from the model's inverse."""
        inverse = self.inverse
        value, slope = self._slope(point)
        for _ in range(INNER.get(self.yard.kind, 2)):
            step = -inverse @ slope
            if not np.isfinite(step).all() or -(slope @ step) / 2 < 0.002 * self.yard.rise:
                break
            step = step * min(1.0, 2.0 / np.abs(step).max())
            moved, value_moved, slope_moved, taken = self._downhill(point, step, value)
            if not value_moved < value:
                break
            inverse = _bfgs(inverse, taken, slope_moved - slope)
            point, value, slope = moved, value_moved, slope_moved
        return point

    def _downhill(
        self, point: np.ndarray, step: np.ndarray, value: float
    ) -> tuple[np.ndarray, float, np.ndarray, np.ndarray]:
        for _ in range(6):
            moved = point.copy()
            moved[self.others] += step
            moved = np.clip(moved, *self.problem.space.box())
            found, slope = self._slope(moved)
            if found < value:
                break
            step = step / 4
        return moved, found, slope, (moved - point)[self.others]

    def _slope(self, point: np.ndarray) -> tuple[float, np.ndarray]:
        value, gradient = self.problem.value_and_gradient(point)
        return value / self.yard.unit, gradient[self.others] / self.yard.unit


def _insensitive(
    problem: Problem, yard: Yardstick, hessian: np.ndarray, others: np.ndarray
) -> np.ndarray:
    """Which of the others hardly matter: a factor of ten either way is as good as the best."""
    if yard.kind != "likelihood":
        return np.zeros(0, int)
    slight = np.diag(hessian) * TENFOLD**2 / 2 < yard.rise
    return np.flatnonzero(others & slight & ~problem.space.thresholds())


def _positive(hessian: np.ndarray) -> np.ndarray:
    """A Hessian whose curvatures are positive: a factor e^7 either way rises by a unit at least."""
    curvatures, directions = np.linalg.eigh(np.where(np.isfinite(hessian), hessian, 0.0))
    return np.asarray((directions * np.maximum(np.abs(curvatures), 0.04)) @ directions.T)


def _bfgs(inverse: np.ndarray, step: np.ndarray, change: np.ndarray) -> np.ndarray:
    """The inverse Hessian updated by a step and the change of the slope along it."""
    along = float(step @ change)
    if along <= 1e-12 * float(np.linalg.norm(step) * np.linalg.norm(change)):
        return inverse
    left = np.eye(len(step)) - np.outer(step, change) / along
    return np.asarray(left @ inverse @ left.T + np.outer(step, step) / along)
