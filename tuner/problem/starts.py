"""Starts of a search that are worth beginning from: where the objective is a number."""

from dataclasses import dataclass

import numpy as np

from tuner.problem.problem import Problem

_TRIES = 32
"""Random points that are tried for each start that is lost."""


@dataclass(frozen=True, eq=False)
class UsableStarts:
    """Where to begin.

    Attributes:
        points: ``(count, size)``, in the order of :meth:`tuner.Problem.starts`; fewer where the
            objective is a number almost nowhere, and none where it is at no point that was tried.
        lost: how many of those that the problem suggested were no use and were drawn again.
    """

    points: np.ndarray
    lost: int


def usable_starts(problem: Problem, count: int, seed: int) -> UsableStarts:
    """Starts at which the objective is a number; those that are lost are drawn again.

    The first ``count`` of :meth:`tuner.Problem.starts` are kept, the initial values first, where
    the objective is finite there. For each of the others random points of the box are tried, from
    the same seed, until one is.

    Args:
        problem: the problem.
        count: how many starts.
        seed: where random points come from.

    >>> import jax.numpy as jnp
    >>> from tuner import Positive, Space
    >>> space = Space.of(a=Positive(1e8, 1e-9, 1e9))
    >>> half = lambda p, _: jnp.where(p["a"] < 1.0, p["a"], jnp.inf)
    >>> problem = Problem("half", space, filter=None, build=lambda p: p, objective=half)
    >>> found = usable_starts(problem, 4, seed=1)
    >>> len(found.points), bool((found.points < 0).all()), found.lost > 0
    (4, True, True)
    """
    suggested = problem.starts(count, seed)
    kept = [z for z in suggested if np.isfinite(problem.value(z))]
    lost = len(suggested) - len(kept)
    low, high = problem.space.box()
    draw = np.random.default_rng([seed, 1])  # not the points that the problem drew itself
    for _ in range(_TRIES * lost):
        if len(kept) == len(suggested):
            break
        z = draw.uniform(low, high)
        if np.isfinite(problem.value(z)):
            kept.append(z)
    return UsableStarts(np.reshape(kept, (-1, problem.space.size)), lost)
