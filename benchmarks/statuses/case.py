"""A problem whose optimum is known, stated once for JAX and for NumPy."""

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any, TypeAlias

import jax.numpy as jnp
import numpy as np
from jax import Array

from objectives import Data
from tuner import Limited, Positive, Problem, Space

Function: TypeAlias = Callable[[ModuleType, Any, Any], Any]
"""From jax.numpy or numpy, points ``(..., n)`` and numbers ``(k,)`` to values ``(...)``."""

POSITIVE = Space.of(a=Positive(1.0, 1e-2, 1e2), b=Positive(1.0, 1e-2, 1e2))
LIMITED = Space.of(x=Limited(0.0, -4.0, 4.0), y=Limited(0.0, -4.0, 4.0))
EDGE = Space.of(x=Limited(-4.0, -4.0, 4.0), y=Limited(0.0, -4.0, 4.0))
"""Begun on a limit."""
MANY = Space.of(**{f"p{i}": Limited(0.0, -4.0, 4.0) for i in range(1, 6)})
WIDE = Space.of(x=Limited(0.0, -4e5, 4e5), y=Limited(0.0, -4e5, 4e5))
"""Numbers of six digits without a scale."""
THRESHOLD = Space.of(a=Positive(1.0, 1e-2, 1e2, threshold=True), b=Positive(1.0, 1e-2, 1e2))


@dataclass(frozen=True)
class Stated:
    """A function as an objective: the numbers are the truth, the parameters give z."""

    function: Function

    def __call__(self, point: Array, numbers: Array) -> Array:
        """The value."""
        value: Array = self.function(jnp, point, numbers)
        return value


def logarithms(values: dict[str, Array]) -> Array:
    """Z of positive parameters."""
    return jnp.log(jnp.stack(list(values.values())))


def plain(values: dict[str, Array]) -> Array:
    """Z of limited parameters of scale 1."""
    return jnp.stack(list(values.values()))


@dataclass(frozen=True, eq=False, repr=False)
class Case:
    """A problem with its known solution.

    Attributes:
        family, kind, number: its name.
        problem: the problem to solve.
        values: the objective in NumPy, from points ``(B, n)`` to ``(B,)``; of a likelihood the
            mean negative log-density of a number.
        best: the least value in the box.
        where: a point that has it, ``(n,)``.
        count: count of a likelihood's numbers; None for a cost.
        starts: number of a solver's starts.
        smooth: whether it has derivatives that lead to the optimum.
        several: whether it has wells of different depth, so that starts may truly differ.
        flat: whether a tenfold change along some direction changes nothing; None: that is open.
        beyond: whether the optimum lies beyond an end of the search box.
    """

    family: str
    kind: str
    number: int
    problem: Problem
    values: Callable[[np.ndarray], np.ndarray]
    best: float
    where: np.ndarray
    count: int | None = None
    starts: int = 4
    smooth: bool = True
    several: bool = False
    flat: bool | None = False
    beyond: bool = False

    def __repr__(self) -> str:
        return f"<{self.name}>"

    @property
    def name(self) -> str:
        """Kind and number."""
        return f"{self.kind} {self.number}"

    @property
    def scale(self) -> float:
        """The reference of relative differences: that of the start for values near 0."""
        start = float(self.values(self.problem.space.start()[None])[0])
        return max(abs(self.best), 1e-6 * abs(start) if np.isfinite(start) else 0.0)

    @property
    def tolerance(self) -> float:
        """The tolerated excess over the best: 0.1 %; for likelihoods 0.05 nats."""
        return 1e-3 * self.scale if self.count is None else 0.05 / self.count

    @property
    def felt(self) -> float:
        """Least change that counts: 1 %; of likelihoods half the 95 % quantile of chi-square."""
        return 1e-2 * self.scale if self.count is None else 1.92 / self.count


def stated(
    family: str,
    kind: str,
    number: int,
    function: Function,
    space: Space,
    numbers: Any,
    best: float | None = None,
    where: Any = None,
    **known: Any,
) -> Case:
    """A case of a plain function; without ``best`` a dense search finds it."""
    told = np.asarray(numbers, float)
    build = plain if space in (LIMITED, EDGE, MANY, WIDE) else logarithms
    problem = Problem(
        f"{kind}_{number}", space, None, build, Stated(function), Data(None, jnp.asarray(told))
    )

    def values(points: np.ndarray) -> np.ndarray:
        return np.asarray(function(np, points, told))

    if best is None:
        where, best = lowest(values, *space.box())
    return Case(family, kind, number, problem, values, best, np.asarray(where, float), **known)


def lowest(
    values: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray, dense: int = 201
) -> tuple[np.ndarray, float]:
    """The lowest point of a box and its value: a grid, then ever finer ones around its best."""
    axes = [np.linspace(a, b, dense) for a, b in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(low))
    found = values(grid)
    points = grid[np.argsort(found)[:30]]
    reach = (high - low) / (dense - 1)
    around = np.linspace(-2, 2, 9 if len(low) < 3 else 3)
    offsets = np.stack(np.meshgrid(*[around] * len(low)), -1).reshape(-1, len(low))
    for _ in range(40):
        near = np.clip(points[:, None] + reach * offsets, low, high)
        each = values(near.reshape(-1, len(low))).reshape(near.shape[:2])
        points = near[np.arange(len(near)), each.argmin(axis=1)]
        reach = 0.6 * reach
    last = values(points)
    return points[last.argmin()], float(last.min())
