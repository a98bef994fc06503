"""The observer whose slowest pole decays fastest while a variance keeps its bound."""

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from objectives import place
from tuner.observers.gains import Observer, Spread, Variance
from tuner.observers.model import LinearDesign
from tuner.observers.pole_placement import Placed, guided
from tuner.observers.prescribed_decay import hurried, several
from tuner.problem.constraint import Constraint
from tuner.problem.problem import Problem
from tuner.problem.space import Space

SPREAD = 1e4
"""How much larger than a fast Kalman filter's the states' variances may be, on average."""


def fastest(name: str, design: LinearDesign, bound: float, unit: str = "") -> Problem:
    """The observer whose slowest pole decays fastest while the variance keeps a bound.

    Its unknowns are coordinates of the poles (:mod:`tuner.observers.pole_placement`). With one
    measurement that sees every state the search begins where all poles coincide. Otherwise the
    optimum found may be a local one, and the problem brings observers to begin from
    (:func:`tuner.observers.prescribed_decay.several`). Several measurements might also trade a
    state that does not count for the one that does, without end: a second constraint,
    ``all_states``, keeps the mean of the states' variances within ``SPREAD`` times those of the
    first of these observers.

    Raises:
        ValueError: for a bound that no observer keeps, with the least variance, or one that even
            the deadbeat observer of a discrete model keeps.
    """
    least = design.least()
    if not bound > least:
        raise ValueError(
            f"the bound {bound:g} is not above {least:.6g}, the least variance that any observer "
            "reaches; widen it, measure more, or measure better"
        )
    size = _sizes(design)
    ways = guided(design, size)
    limits: tuple[Constraint, ...] = (Constraint("variance", Variance(design.error), bound, unit),)
    alone = len(ways) == 1 and ways[0].seen == len(size)
    if alone and len(design.C) == 1:
        _refuse_deadbeat(ways[0], bound)
        placed, starts = ways[0], [_coinciding(ways[0], bound)]
    else:
        gains = several(design, bound, size)
        placed, starts = _placed(ways, gains)
        limits += (Constraint("all_states", Spread.beyond(design, gains[0]), SPREAD),)
    space = Space.of(**placed.parameters(starts[0]))
    return Problem(
        name=name,
        space=space,
        filter=None,
        build=placed,
        objective=_time_constant,
        constraints=limits,
        known_starts=tuple(space.unconstrain(start) for start in starts[1:]),
    )


def _time_constant(observer: Observer, _: None) -> Array:
    """Of the slowest pole, s."""
    return 1 / observer.decay


def _placed(ways: list[Placed], gains: list[np.ndarray]) -> tuple[Placed, list[dict[str, float]]]:
    """The guide that can place the poles of the most gains, and their coordinates."""
    found = [
        (way, [at for gain in gains if (at := way.coordinates(gain)) is not None]) for way in ways
    ]
    return max(found, key=lambda each: len(each[1]))


def _coinciding(placed: Placed, bound: float) -> dict[str, float]:
    """The fastest decay rate at which coinciding poles keep the bound; or the quietest."""
    design = placed.design
    unit = max(float(np.abs(np.linalg.eigvals(design.A)).max()), 1e-6)
    rates = np.geomspace(1e-6, 1e6, 241) * unit
    if design.dt is not None:
        rates = np.geomspace(1e-6, 10.0, 141) / design.dt
    at = {name: jnp.asarray(value) for name, value in placed.coinciding(1.0).items()}
    variance = Variance(design.error)
    along = jax.jit(jax.vmap(lambda decay: variance(placed(at | {"decay": decay}), None)))
    found = np.asarray(along(jnp.asarray(rates)))
    found = np.where(np.isfinite(found) & (found >= 0), found, np.inf)
    kept = np.flatnonzero(found <= bound)
    return placed.coinciding(float(rates[kept[-1] if kept.size else np.argmin(found)]))


def _refuse_deadbeat(placed: Placed, bound: float) -> None:
    design = placed.design
    if not design.discrete:
        return
    power = jnp.eye(len(design.states) + 1)[0]
    L = np.asarray(place(jnp.asarray(design.A), jnp.asarray(design.C[0]), power))[:, None]
    variance = design.variance(L)
    if variance <= bound:
        entries = ", ".join(f"{entry:.9g}" for entry in L[:, 0])
        raise ValueError(
            f"even the deadbeat observer, L = [{entries}], keeps the bound {bound:g}: its variance "
            f"is {variance:.6g}, an error is gone after {len(L)} samples, and nothing is faster; "
            "use it, or give a bound below its variance"
        )


def _sizes(design: LinearDesign) -> np.ndarray:
    """A typical error of every state, ``(n,)``: in its units nothing depends on the user's."""
    L = None if design.finite else hurried(design, np.inf)
    P = design.kalman().predicted if L is None else design.covariance(L)
    size = np.sqrt(np.maximum(np.diag(P), 0.0))
    return np.asarray(np.where(size > 0, size, size.max() or 1.0))
