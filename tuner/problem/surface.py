"""An objective at many points at once: cost surfaces, sweeps, populations."""

import os
from collections.abc import Callable
from typing import TypeVar, cast

import jax
import numpy as np
from jax import Array

from objectives import Data, scores_and_gradients
from tuner.problem.problem import Problem
from tuner.problem.programs import Static
from tuner.processors import side_by_side
from tuner.stored_programs import stored_jit

T = TypeVar("T")
MEMORY = 200e6
"""Bytes that one call may hold, all threads together."""
_LANES = 64  # points side by side in one time loop: enough to fill the vector registers
_SHORT = 20e6
"""Samples, of all points together, that take less time than compiling for fewer points a thread."""
_TRANSFORMS = 12  # a stored record is cut, windowed and transformed: copies that exist at once


def values(problem: Problem, Z: np.ndarray) -> np.ndarray:
    """The objective at each of the points ``(B, n)``, as ``(B,)``; infinite where not a number.

    The points run side by side in one time loop and in as many threads as there are processors,
    unless other threads of the same work compute beside this one; memory stays below
    :data:`MEMORY`. Where the problem has many recordings they run side by side,
    and the points one after another; where its values go by C, in threads alone.
    """
    if problem.in_lines is not None:
        return np.array([problem.value(z) for z in Z])
    if problem.way is None and problem.route.value(problem.space.start()) is not None:
        return np.array(side_by_side(problem.value, [*Z]))
    found = np.concatenate(_batches(problem, Z, _values))
    return np.where(np.isfinite(found), found, np.inf)


def values_and_gradients(problem: Problem, Z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The objective ``(B,)`` and its gradients ``(B, n)`` at each of the points ``(B, n)``."""
    native = problem.route.values_and_gradients(Z)
    if native is not None:
        return np.where(np.isfinite(native[0]), native[0], np.inf), native[1]
    if problem.in_lines is not None:
        values, gradients = zip(*map(problem.value_and_gradient, Z), strict=True)
        return np.array(values), np.array(gradients)
    scores, gradients = zip(*_batches(problem, Z, _values_and_gradients), strict=True)
    found = np.concatenate(scores)
    return np.where(np.isfinite(found), found, np.inf), np.concatenate(gradients)


def grid(problem: Problem, axes: dict[str, np.ndarray]) -> np.ndarray:
    """The objective on a grid of two or more parameters, the others at their initial values.

    Args:
        problem: the problem.
        axes: values by parameter name, in the order of the result's axes.

    Returns:
        The objective, ``(len(first axis), len(second axis), ...)``.

    Raises:
        ValueError: for an unknown name, and for a value outside its constraint.

    >>> from tuner import Positive, Problem, Space
    >>> space = Space.of(a=Positive(1.0, 0.1, 10.0), b=Positive(1.0, 0.1, 10.0))
    >>> product = lambda p, _: p["a"] * p["b"]
    >>> problem = Problem("product", space, filter=None, build=lambda p: p, objective=product)
    >>> grid(problem, {"a": np.array([1.0, 2.0]), "b": np.array([3.0, 5.0])}).round(9).tolist()
    [[3.0, 5.0], [6.0, 10.0]]
    """
    mesh = np.meshgrid(*axes.values(), indexing="ij")
    points = zip(*(axis.ravel() for axis in mesh), strict=True)
    Z = [problem.space.unconstrain(dict(zip(axes, point, strict=True))) for point in points]
    return values(problem, np.array(Z)).reshape(mesh[0].shape)


def _batches(problem: Problem, Z: np.ndarray, evaluate: Callable[..., T]) -> list[T]:
    threads = os.cpu_count() or 1
    lanes = _lanes(problem, threads, len(Z))
    padded = np.vstack([Z, np.repeat(Z[-1:], -len(Z) % lanes, axis=0)])

    def one(start: int) -> T:
        found = evaluate(problem.static, padded[start : start + lanes], problem.data)
        # The last batch is filled up, so that every batch has the shape that was compiled.
        return cast("T", jax.tree.map(lambda leaf: np.asarray(leaf)[: len(Z) - start], found))

    return side_by_side(one, range(0, len(padded), lanes))


def _lanes(problem: Problem, threads: int, points: int) -> int:
    kept = problem.kept_bytes
    affordable = int(MEMORY / threads / _TRANSFORMS / kept) if kept else _LANES
    long = points * problem.data.samples > _SHORT
    return max(1, min(_LANES, affordable, -(-points // threads) if long else points))


# XLA uses a wider vector unit only on request, and only side-by-side points fill it.
_WIDE = {"xla_cpu_prefer_vector_width": 512}


@stored_jit(1, **_WIDE)
def _values(static: Static, Z: Array, data: Data) -> Array:
    return jax.vmap(lambda z: static.score(z, data))(Z)


@stored_jit(1, **_WIDE)
def _values_and_gradients(static: Static, Z: Array, data: Data) -> tuple[Array, Array]:
    return scores_and_gradients(static.filter, static.objective, static.built, Z, data)
