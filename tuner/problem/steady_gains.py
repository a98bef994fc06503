"""Values per sample of a filter's parameters: Q, the steady gains K and L, alpha and beta."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from filters.declared import Channel
from filters.linear import LinearForm
from objectives import LinearSystem, steady_kalman, tracker_gains
from objectives.in_numpy import Method, in_numpy
from objectives.linear_systems.model import derived

Derived = dict[str, tuple[Any, Channel]]
"""Numbers by name, each with its unit and meaning."""
_SAME = 1e-6


def a_sample(filter: Any, params: Any) -> Derived:
    """Numbers that a filter derives of its parameters, and that follow from its linear model.

    A method ``linear`` adds to its own derived numbers: Q and K where it does not
    derive them, F and C where they are those of K and nothing else moves the state, the gain
    L = F K of the predicting observer, where that is another one, and alpha, beta and gamma
    where the model is a position with its derivatives.

    Args:
        filter: the filter, for its own sample time.
        params: its parameters.
    """
    facts: Mapping[str, Channel] = dict(getattr(filter, "derived", {}))
    values = in_numpy(Method(filter, "derive"), params) if facts else {}
    found: Derived = {name: (value, facts[name]) for name, value in values.items()}
    if not hasattr(filter, "linear"):
        return found
    try:
        more = _of_model(in_numpy(Method(filter, "linear"), params), float(filter.dt), found)
    except ValueError:  # no steady state, and so no gain
        more = {}
    return found | {name: gain for name, gain in more.items() if name not in found}


def system_of(form: LinearForm, dt: float) -> LinearSystem:
    """The linear model of a filter, as designs take it.

    Raises:
        ValueError: where its noise is not a covariance.
    """
    move = form.transition
    G, R = np.asarray(move.G), np.asarray(form.R)
    W = G @ np.asarray(move.Q) @ G.T
    return LinearSystem(move.F, form.H, (W + W.T) / 2, R if R.ndim == 2 else np.diag(R), dt=dt)


def _of_model(form: LinearForm, dt: float, known: Derived) -> Derived:
    whole = system_of(form, dt)
    found: Derived = {
        "Q": (whole.W, Channel("", f"covariance that enters in a sample, {whole.W.shape}"))
    }
    if "K" not in known:
        K, system, shape, unit = steady_kalman(whole).gain, whole, whole.C.T.shape, ""
        found["K"] = K, Channel("", "steady gain on a measurement: x+ = x + K (z - C x)")
    else:
        gains, fact = known["K"]
        shape, unit = np.shape(gains), fact.unit
        K = np.asarray(gains, float).reshape(-1, shape[1] if len(shape) == 2 else 1)
        system = _of_one_axis(whole, *K.shape)
        if not _is_steady(system, K):  # of other states than those of the model
            return found
    if form.transition.B is None:
        F, C = (np.squeeze(part) if np.size(part) == 1 else part for part in (system.A, system.C))
        found["F"] = F, Channel("", f"what a sample makes of the state, {system.A.shape}: x' = F x")
        found["C"] = C, Channel("", f"what is measured of it, {system.C.shape}: z = C x")
    L = system.A @ K
    if not np.allclose(L, K, rtol=1e-12, atol=0):
        words = "gain of the observer that predicts, x' = F x + L (z - C x): L = F K"
        found["L"] = L.reshape(shape), Channel(unit, words)
    for name, value in tracker_gains(system.A, system.C, K, dt).items():
        found[name] = value, Channel("", "the steady gain, as trackers name it")
    return found


def _of_one_axis(system: LinearSystem, n: int, m: int) -> LinearSystem:
    """The first of several equal axes, whose gain has the shape ``(n, m)``."""
    parts = {"A": system.A[:n, :n], "C": system.C[:m, :n], "W": system.W[:n, :n]}
    return derived(parts | {"V": system.V[:m, :m], "S": system.S[:n, :m]}, system.dt)


def _is_steady(system: LinearSystem, K: np.ndarray) -> bool:
    """Whether K is the gain of the steady filter, that of its own steady covariance."""
    from scipy.linalg import solve_discrete_lyapunov

    A, C, V = system.A, system.C, system.V
    if K.shape != C.T.shape or not np.isfinite(K).all():
        return False
    L = A @ K
    if not np.abs(np.linalg.eigvals(A - L @ C)).max() < 1:
        return False
    P = solve_discrete_lyapunov(A - L @ C, system.W + L @ V @ L.T)
    own = np.linalg.solve(C @ P @ C.T + V, C @ P).T
    return bool(np.abs(own - K).max() <= _SAME * np.abs(K).max())
