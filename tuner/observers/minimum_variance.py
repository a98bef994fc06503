"""The observer of minimum variance: the Kalman filter, by a search and by its equation."""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import ArrayLike

from objectives import LinearSystem, steady_kalman
from tuner.observers.gains import Entries, Observer, Variance
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers.known import Known


def minimum_variance(name: str, system: LinearSystem, error: ArrayLike) -> Problem:
    """The observer with the least variance of the error: the Kalman filter, as a search.

    Args:
        name: of the problem.
        system: the system; noise must drive every mode that does not decay
            (:func:`objectives.without_undriven` removes the others).
        error: weights of the error that counts, ``(n,)``.

    Raises:
        ValueError: where a continuous measurement has no noise (better observers have ever larger
            gains), no observer is stable, or no gain is needed.
    """
    variance = Variance.of(system, error)
    best = steady_kalman(system).predictor
    if not best.any():
        raise ValueError(
            "no gain is needed: nothing disturbs what the measurements could correct; give the "
            "noise w that there is, or a bound"
        )
    gains = _Gains(system, _entries(system))
    unit = np.maximum(np.abs(best), 1e-3 * np.abs(best).max())
    return Problem(
        name=name,
        space=Space.of(**gains.entries.parameters(_start_gain(system, best), unit)),
        filter=None,
        build=gains,
        objective=variance,
    )


def least_variance(system: LinearSystem, error: ArrayLike) -> float:
    """The least variance of an error over all observers.

    Where a continuous measurement has no noise, the value is not known, and 0 is returned.

    Args:
        system: the system.
        error: weights of the error that counts, ``(n,)``.

    >>> least_variance(LinearSystem([[0.0]], [[1.0]], [[4.0]], [[1.0]]), [1.0])
    2.0
    """
    variance = Variance.of(system, error)
    if not (system.discrete or system.noisy):
        return 0.0
    return variance.under(steady_kalman(system).predicted)


def riccati(system: LinearSystem) -> Known:
    """The minimum-variance observer by the Riccati equation."""
    found = _entries(system).named(steady_kalman(system).predictor)
    return Known("riccati", lambda _: found, "the Riccati equation's solution")


@dataclass(frozen=True, eq=False)
class _Gains:
    """The map from single gains to a point of the design."""

    system: LinearSystem
    entries: Entries

    def __call__(self, values: dict[str, Array]) -> Observer:
        L = self.entries.matrix(values)
        return Observer(jnp.ones(()), L, self.system.steady(L))


def _entries(system: LinearSystem) -> Entries:
    return Entries("L", (len(system.A), len(system.C)))


def _start_gain(system: LinearSystem, best: np.ndarray) -> np.ndarray:
    """A stable gain near the best one, to start from."""
    return next((f * best for f in (1.5, 1.2, 1.1, 1.02) if system.decay(f * best) > 0), best)
