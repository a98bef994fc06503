"""The direction of a gradient through a problem's time loop."""

from typing import Any

import jax
from jax import Array
from jax.extend.core import Jaxpr, jaxprs_in_params

from filters import AnyFilter, Estimate, Gated, LinearKalman, Student, bare
from objectives import Way


def way_of(filter: AnyFilter | None, params: Any, size: int, forced: Way | None = None) -> Way:
    """Forwards or backwards: the faster one by measured cost, or the forced one.

    Backwards where a Kalman filter has many parameters, and in parts where its transition or its
    measurement rows have derivatives: see the table in docs/performance.md. Forwards otherwise: a
    few numbers, a filter whose step repeats itself for a gate, and a design.

    Args:
        filter: the filter, or None.
        params: its parameters, or their shapes.
        size: number of free parameters.
        forced: the direction that is wanted, if any.

    >>> from filters import Complementary, ComplementaryGain
    >>> gain = ComplementaryGain(jax.numpy.ones(()), jax.numpy.zeros(()))
    >>> way_of(Complementary(dt=0.1), gain, 1)
    'forwards'
    """
    if forced is not None or filter is None:
        return forced or "forwards"
    states = _states(filter, params)
    inner = bare(filter)
    linear = isinstance(inner, LinearKalman) or hasattr(inner, "linear")
    if not states or size < _least(states, linear=linear):
        return "forwards"
    return "backwards" if linear else "backwards in parts"


def turns_round(jaxpr: Jaxpr) -> bool:
    """Whether a formula can be differentiated backwards: it has no loop of unknown length."""
    for equation in jaxpr.eqns:
        if equation.primitive.name == "while":
            return False
        if not all(map(turns_round, jaxprs_in_params(equation.params))):
            return False
    return True


def _least(states: int, *, linear: bool) -> int:
    """Number of parameters from which backwards is faster, for a filter of n states.

    An extended filter's gradient is faster in parts from two or three on, but takes two to four
    seconds longer to compile: with a few states a search does not regain them before C takes over.
    """
    if not linear:
        return 6 if states < 5 else 4 if states < 9 else 3
    return 5 if states < 6 else 4 if states < 9 else 2


def _states(filter: AnyFilter, params: Any) -> int:
    """The states of a Kalman filter made of `filters.predict` and `filters.update`; else 0."""
    if isinstance(filter, Gated | Student):
        return 0
    state = jax.eval_shape(filter.init, params)
    inner = jax.tree.leaves(state, is_leaf=_known)
    covariances: list[Array] = [one.P for one in inner if _known(one)]
    return sum(P.shape[-1] for P in covariances)


def _known(state: Any) -> bool:
    return isinstance(state, Estimate)
