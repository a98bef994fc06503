"""Contributions of single samples to a likelihood or a mean square, and their slopes."""

from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import jax
import numpy as np
from jax import Array

from filters import Batched, Lanes
from objectives import Data, contributions, is_additive
from objectives.in_numpy import in_numpy
from tuner.problem.problem import Problem
from tuner.problem.programs import Static
from tuner.stored_programs import stored_jit


class Added(NamedTuple):
    """Contributions of samples, for k records side by side; k = 1 for a single one.

    Attributes:
        amounts: nats or squares, ``(N, k)``.
        counts: number of measured numbers in each, ``(N, k)``.
    """

    amounts: np.ndarray
    counts: np.ndarray


def added(problem: Problem, z: np.ndarray) -> Added:
    """The contribution of each sample at z ``(n,)``.

    Raises:
        ValueError: for an objective that is not a sum over samples.
    """
    _check(problem)
    amounts, counts = _added(problem.static, np.asarray(z, float), problem.data)
    return Added(np.asarray(amounts), np.asarray(counts))


def numbers(problem: Problem, z: np.ndarray) -> float:
    """Number of measured numbers in a likelihood or a mean square at z ``(n,)``.

    Raises:
        ValueError: for an objective that is not a sum over samples.
    """
    return float(_sloped(problem, z)[1].sum())


def slopes(problem: Problem, z: np.ndarray) -> np.ndarray:
    """The derivative of each sample's contribution by each coordinate, ``(N, k, n)``.

    Raises:
        ValueError: for an objective that is not a sum over samples.
    """
    return _sloped(problem, z)[0]


def _sloped(problem: Problem, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slopes and counts of one compilation, which costs more than many runs."""
    _check(problem)
    slopes, counts = _slopes(problem.static, np.asarray(z, float), problem.data)
    return np.asarray(slopes), np.asarray(counts)


def added_by(problem: Problem, outputs: Any) -> Added:
    """The contribution of each sample of some outputs, time first, whatever made them.

    Raises:
        ValueError: for an objective that is not a sum over samples.
    """
    _check(problem)
    return Added(*in_numpy(_OfOutputs(problem.static), outputs, problem.data.truth))


def _check(problem: Problem) -> None:
    if problem.filter is None or not is_additive(problem.objective):
        raise ValueError(f"the objective of {problem.name} is not a sum over samples")


def _added_at(static: Static, z: Array, data: Data) -> tuple[Array, Array]:
    filter, objective = cast("tuple[Any, Any]", (static.filter, static.objective))
    return _by_record(filter, *contributions(filter, objective, static.built(z), data))


@dataclass(frozen=True)
class _OfOutputs:
    """The contribution of each sample of some outputs."""

    static: Static

    def __call__(self, outputs: Any, truth: Any) -> tuple[Array, Array]:
        """Of each record, ``(N, k)``."""
        objective: Any = self.static.objective
        return _by_record(self.static.filter, *objective.added(outputs, truth))


def _by_record(filter: Any, amounts: Array, counts: Array) -> tuple[Array, Array]:
    """The contribution of each sample of each record, ``(N, k)``, its numbers summed."""
    records = amounts.shape[1] if isinstance(filter, Batched | Lanes) else 1
    shape = (len(amounts), records, -1)
    counted = counts.astype(amounts.dtype)
    return amounts.reshape(shape).sum(axis=-1), counted.reshape(shape).sum(axis=-1)


_added = stored_jit(1)(_added_at)


@stored_jit(1)
def _slopes(static: Static, z: Array, data: Data) -> tuple[Array, Array]:
    found: tuple[Array, Array] = jax.jacfwd(lambda at: _added_at(static, at, data), has_aux=True)(z)
    return found
