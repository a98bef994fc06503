"""The terms of an objective sample by sample, so that two filters can be paired."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from objectives import is_additive, is_fold
from objectives.in_numpy import in_numpy
from tuner.problem.problem import Problem
from tuner.problem.programs import run_filter
from tuner.problem.samples import added_by
from tuner.run.blocks import block_mean


@dataclass(frozen=True, eq=False)
class SampleTerms:
    """The terms of an objective in each of N samples of k recordings, and their weights.

    Attributes:
        added: sums over what counts, ``(N, k)``.
        counts: how much counts, ``(N, k)``.
    """

    added: np.ndarray
    counts: np.ndarray

    def only(self, judges: np.ndarray) -> "SampleTerms":
        """Those of some samples ``(N, 1)`` or recordings ``(1, k)``; nothing counts elsewhere."""
        return SampleTerms(np.where(judges, self.added, 0.0), np.where(judges, self.counts, 0.0))

    def finite(self) -> "SampleTerms":
        """Those that are finite; nothing counts elsewhere."""
        return self.only(np.isfinite(self.added))

    def __add__(self, other: "SampleTerms") -> "SampleTerms":
        return SampleTerms(self.added + other.added, self.counts + other.counts)

    @property
    def mean(self) -> float:
        """Over all that counts; NaN where nothing does."""
        counts = float(self.counts.sum())
        return float(self.added.sum()) / counts if counts else float("nan")


@dataclass(frozen=True)
class Improvement:
    """By which share of a value another one is lower on the same samples.

    Attributes:
        share: 0.1 where it is lower by a tenth; negative where it is higher.
        low, high: its 95 % interval, over blocks of the samples; infinite where there are too few.
        blocks: of how many blocks it is.
    """

    share: float
    low: float
    high: float
    blocks: int

    @property
    def verdict(self) -> str:
        """``better``, ``worse``, or where the interval holds 0 ``no better``."""
        if self.low > 0:
            return "better"
        return "worse" if self.high < 0 else "no better"


def sample_terms(problem: Problem, values: Mapping[str, Any]) -> SampleTerms | None:
    """The objective's terms for some parameters; None where it is no sum over samples."""
    if problem.filter is None or not adds_up(problem):
        return None
    return terms_of(problem, run_with(problem, values))


def run_with(problem: Problem, values: Mapping[str, Any]) -> Any:
    """The filter's outputs for some parameters, time first."""
    if problem.filter is None:
        raise ValueError(f"{problem.name} runs no filter")
    params = problem.made(values)
    return run_filter(problem.filter, params, problem.data.inputs)


def adds_up(problem: Problem) -> bool:
    """Whether the objective is a sum over samples, divided by what counts."""
    if not (is_fold(problem.objective) and is_additive(problem.objective)):
        return False
    objective: Any = problem.objective
    total = jax.eval_shape(objective.init)
    return isinstance(total, tuple) and [np.shape(leaf) for leaf in total] == [(), ()]


def terms_of(problem: Problem, outputs: Any) -> SampleTerms:
    """The same of outputs, time first, whoever made them; infinite where one is not a number."""
    found = added_by(problem, outputs)
    return SampleTerms(np.where(np.isfinite(found.amounts), found.amounts, np.inf), found.counts)


def value_of(problem: Problem, mean: float) -> float:
    """The objective where it adds up to a mean; of a likelihood the equivalent deviation."""
    return float(in_numpy(_Value(problem.objective), float(mean)))


@dataclass(frozen=True)
class _Value:
    """An objective's value where it adds up to a mean."""

    objective: Any

    def __call__(self, mean: Array) -> Array:
        """Of a likelihood the equivalent deviation."""
        objective = self.objective
        total = type(objective.init())(mean, jnp.ones(()))
        value: Array = objective.value(total, None)
        return jnp.asarray(objective.deviation(value)) if hasattr(objective, "deviation") else value


@dataclass(frozen=True)
class _Slope:
    """The derivative of its logarithm."""

    objective: Any

    def __call__(self, mean: Array) -> Array:
        """At a mean."""
        slope: Array = jax.grad(lambda at: jnp.log(_Value(self.objective)(at)))(mean)
        return slope


def improvement(problem: Problem, before: SampleTerms, now: SampleTerms) -> Improvement:
    """By how much one filter is better than another, where both count the same.

    The interval is that of the difference of both values' logarithms, to first order in what each
    block adds to both.

    Args:
        problem: whose objective both have added up.
        before: what the one adds up.
        now: the other.
    """
    same = (before.counts == now.counts) & (now.counts > 0)
    pair = before.only(same), now.only(same)
    values = [value_of(problem, each.mean) for each in pair]
    if not all(0 < value < np.inf for value in values):
        return _without_interval(*values)
    pulls = [_pull(problem.objective, each) for each in pair]
    apart = block_mean(pulls[1] - pulls[0], pair[0].counts)
    log = np.log(values[1] / values[0])
    share, low, high = (float(-np.expm1(log + end)) for end in (0.0, apart.high, apart.low))
    return Improvement(share, low, high, apart.blocks)


def _pull(objective: Any, found: SampleTerms) -> np.ndarray:
    """How far each sample moves the logarithm of the value, times how much counts."""
    slope = in_numpy(_Slope(objective), found.mean)
    return np.asarray(float(slope) * (found.added - found.mean * found.counts))


def _without_interval(before: float, now: float) -> Improvement:
    """Where one of two values is 0 or infinite, or nothing counts."""
    if np.isnan([before, now]).any():
        return Improvement(float("nan"), -np.inf, np.inf, 0)
    share = 0.0 if before == now else 1 - now / before if before else -np.inf
    return Improvement(float(share), float(share), float(share), 0)
