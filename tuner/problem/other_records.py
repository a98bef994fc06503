"""A problem's objective on other records than its own, by the same compilation."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import jax
import numpy as np

from filters import Lanes
from objectives import Data
from tuner.problem.problem import Problem
from tuner.problem.programs import by_name, value_of


def mean_on(problem: Problem, parameters: Mapping[str, Any], data: Data) -> float:
    """The mean objective over records that were not tuned on, exactly at given parameters.

    They run as many at a time as the problem has, so that its compilation serves them all; a rest
    of fewer takes another one.

    Args:
        problem: one whose filter is :class:`filters.Lanes` and whose objective is a mean of equal
            weights over its records.
        parameters: by name, fixed ones included; bounds are not looked at.
        data: records as long as the problem's, second axis ``(N, k, ...)``.

    Raises:
        ValueError: for a problem without lanes, and for a parameter without a value.
    """
    if not isinstance(problem.filter, Lanes):
        raise ValueError(f"{problem.name} runs no records side by side; pose it with filters.Lanes")
    missing = [name for name in problem.space.names if name not in parameters]
    if missing:
        raise ValueError(f"{problem.name} has no value for {', '.join(missing)}: give them all")
    values = {name: np.asarray(parameters[name], float) for name in problem.space.names}
    given = by_name(values, given=True)
    records = np.shape(jax.tree.leaves(data)[0])[1]
    total: float = 0.0
    for first in range(0, records, problem.filter.count):
        count = min(problem.filter.count, records - first)
        which = slice(first, first + count)
        part = jax.tree.map(lambda leaf, at=which: np.asarray(leaf)[:, at], data)
        static = problem.static._replace(filter=replace(problem.filter, count=count))
        total += count * float(value_of(static, problem.space.start(), *given, part))
    return float(total / records)
