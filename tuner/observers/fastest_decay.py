"""The observer whose slowest pole decays fastest while a variance keeps its bound."""

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import ArrayLike

from objectives import LinearSystem, place, require_detectable, steady_kalman
from tuner.observers.gains import Observer, Spread, Variance
from tuner.observers.minimum_variance import least_variance
from tuner.observers.pole_placement import PolePlacement, pole_placements
from tuner.observers.prescribed_decay import prescribed_decay, starting_gains
from tuner.problem.constraint import Constraint
from tuner.problem.problem import Problem
from tuner.problem.space import Space

SPREAD = 1e4
"""Mean ratio that the states' variances may have to those of a fast Kalman filter."""


def fastest_decay(
    name: str, system: LinearSystem, error: ArrayLike, bound: float, unit: str = ""
) -> Problem:
    """The observer whose slowest pole decays fastest while a variance meets its bound.

    Its unknowns are coordinates of the poles (:mod:`tuner.observers.pole_placement`). With one
    measurement that sees every state the search begins where all poles coincide. Otherwise the
    optimum found may be a local one, and the problem brings observers to begin from
    (:func:`tuner.observers.prescribed_decay.starting_gains`). Several measurements might also
    trade a state that does not count for the one that does, without end: a second constraint,
    ``all_states``, keeps the mean of the states' variances within ``SPREAD`` times those of the
    first of these observers.

    Args:
        name: of the problem.
        system: the system.
        error: weights of the error that counts, ``(n,)``.
        bound: of that error's variance.
        unit: of the variance.

    Raises:
        ValueError: for a bound that no observer meets, with the least variance, one that even the
            deadbeat observer of a discrete system meets, or a system without a stable observer.
    """
    variance = Variance.of(system, error)
    require_detectable(system)
    least = least_variance(system, error)
    if not bound > least:
        raise ValueError(
            f"the bound {bound:g} is not above {least:.6g}, the least variance that any observer "
            "reaches; widen it, measure more, or measure better"
        )
    size = _sizes(system, variance)
    ways = pole_placements(system, size)
    limits: tuple[Constraint, ...] = (Constraint("variance", variance, bound, unit),)
    alone = len(ways) == 1 and ways[0].seen == len(size)
    if alone and len(system.C) == 1:
        _refuse_deadbeat(system, variance, bound)
        placement, starts = ways[0], [_coinciding(ways[0], variance, bound)]
    else:
        gains = starting_gains(system, variance, bound, size)
        placement, starts = _best_placement(ways, gains)
        limits += (Constraint("all_states", Spread.beyond(system, gains[0]), SPREAD),)
    space = Space.of(**placement.parameters(starts[0]))
    return Problem(
        name=name,
        space=space,
        filter=None,
        build=placement,
        objective=_time_constant,
        constraints=limits,
        known_starts=tuple(space.unconstrain(start) for start in starts[1:]),
    )


def _time_constant(observer: Observer, _: None) -> Array:
    """Time constant of the slowest pole, s."""
    return 1 / observer.decay


def _best_placement(
    ways: list[PolePlacement], gains: list[np.ndarray]
) -> tuple[PolePlacement, list[dict[str, float]]]:
    """The guide that can place the poles of the most gains, and their coordinates."""
    found = [
        (way, [at for gain in gains if (at := way.coordinates(gain)) is not None]) for way in ways
    ]
    return max(found, key=lambda each: len(each[1]))


def _coinciding(placement: PolePlacement, variance: Variance, bound: float) -> dict[str, float]:
    """Coinciding poles of the fastest decay rate that meets the bound, else of least variance."""
    system = placement.system
    unit = max(float(np.abs(np.linalg.eigvals(system.A)).max()), 1e-6)
    rates = np.geomspace(1e-6, 1e6, 241) * unit
    if system.dt is not None:
        rates = np.geomspace(1e-6, 10.0, 141) / system.dt
    at = {name: jnp.asarray(value) for name, value in placement.coinciding(1.0).items()}
    along = jax.jit(jax.vmap(lambda decay: variance(placement(at | {"decay": decay}), None)))
    found = np.asarray(along(jnp.asarray(rates)))
    found = np.where(np.isfinite(found) & (found >= 0), found, np.inf)
    kept = np.flatnonzero(found <= bound)
    return placement.coinciding(float(rates[kept[-1] if kept.size else np.argmin(found)]))


def _refuse_deadbeat(system: LinearSystem, variance: Variance, bound: float) -> None:
    if not system.discrete:
        return
    power = jnp.eye(len(system.A) + 1)[0]
    L = np.asarray(place(jnp.asarray(system.A), jnp.asarray(system.C[0]), power))[:, None]
    found = variance.under(system.covariance(L))
    if found <= bound:
        entries = ", ".join(f"{entry:.9g}" for entry in L[:, 0])
        raise ValueError(
            f"even the deadbeat observer, L = [{entries}], meets the bound {bound:g} with variance "
            f"{found:.6g}; use it, for nothing is faster, or give a lower bound"
        )


def _sizes(system: LinearSystem, variance: Variance) -> np.ndarray:
    """A typical error of every state, ``(n,)``: in these units nothing depends on the user's."""
    if system.discrete or system.noisy:
        P = steady_kalman(system).predicted
    else:
        P = system.covariance(prescribed_decay(system, variance, np.inf))
    size = np.sqrt(np.maximum(np.diag(P), 0.0))
    return np.asarray(np.where(size > 0, size, size.max() or 1.0))
