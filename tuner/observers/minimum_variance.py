"""The observer with the least variance: the Kalman filter, by a search and by its equation."""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jax import Array

from tuner.observers.gains import Entries, Observer, Variance
from tuner.observers.model import LinearDesign
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers.known import Known


def quietest(name: str, design: LinearDesign) -> Problem:
    """The observer with the least variance of the error: the Kalman filter, as a search.

    The model must be driven (:meth:`LinearDesign.driven`), and continuous measurements noisy.

    Raises:
        ValueError: where a measurement has no noise: better observers have ever larger gains.
    """
    if not design.finite:
        raise ValueError(
            "a measurement has no noise (the matrix of v is singular) and may be followed ever "
            "faster, so no gain is the best one; give the noise that it has, a bound, or the "
            "sample_time of the measurements"
        )
    best = _best(design)
    if not best.any():
        raise ValueError(
            "no gain is needed: nothing disturbs what the measurements could correct; give the "
            "noise w that there is, or a bound"
        )
    gains = _Gains(design, _entries(design))
    unit = np.maximum(np.abs(best), 1e-3 * np.abs(best).max())
    return Problem(
        name=name,
        space=Space.of(**gains.entries.parameters(_beside(design, best), unit)),
        filter=None,
        build=gains,
        objective=Variance(design.error),
    )


def riccati(design: LinearDesign) -> Known:
    """The quietest observer by the Riccati equation."""
    found = _entries(design).named(_best(design))
    return Known("riccati", lambda _: found, "the Riccati equation's solution")


@dataclass(frozen=True, eq=False)
class _Gains:
    """From single gains to a point of the design."""

    design: LinearDesign
    entries: Entries

    def __call__(self, values: dict[str, Array]) -> Observer:
        L = self.entries.matrix(values)
        return Observer(jnp.ones(()), L, self.design.steady(L))


def _entries(design: LinearDesign) -> Entries:
    return Entries("L", (len(design.states), len(design.C)))


def _best(design: LinearDesign) -> np.ndarray:
    return design.predictor_gain(design.kalman().gain)


def _beside(design: LinearDesign, best: np.ndarray) -> np.ndarray:
    """A stable gain beside the best one, to start from."""
    return next((f * best for f in (1.5, 1.2, 1.1, 1.02) if design.decay(f * best) > 0), best)
