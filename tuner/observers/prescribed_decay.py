"""Observers that are fast within a bound already, to begin a search from."""

from typing import NamedTuple

import numpy as np

from objectives import steady_kalman
from tuner.observers.model import LinearDesign

DRAWS = 24
"""How many weightings are tried beside the model's own noise."""
_ROOM = 0.98
"""A start uses this share of the bound."""


class Weights(NamedTuple):
    """The noise that a gain is worked out for, true or not.

    Attributes:
        W: of the states, ``(n, n)``.
        V: of the measurements, ``(m, m)``, positive definite.
    """

    W: np.ndarray
    V: np.ndarray


def hurried(design: LinearDesign, bound: float) -> np.ndarray:
    """The fastest of the hurried Kalman gains for the model's own noise, ``(n, m)``.

    A hurried gain is that of a model which grows faster by e^(alpha t): all poles of the true model
    then decay faster than alpha (Anderson and Moore, 1969). alpha is as large as the bound allows.
    """
    found = _fastest(design, _own(design), bound)
    return _gain(design, _own(design), 0.0) if found is None else found


def several(design: LinearDesign, bound: float, size: np.ndarray) -> list[np.ndarray]:
    """Hurried gains that keep the bound, for the model's noise and for drawn ones; fastest first.

    The draws (their seed is fixed: they belong to the problem, not to a solver) break symmetries
    in which a search would be caught.

    Args:
        design: the design.
        bound: of the variance.
        size: a typical error of every state, ``(n,)``.
    """
    draw = np.random.default_rng(0)
    n, m = len(design.states), len(design.C)
    own = _own(design)
    weights = [own]
    for _ in range(DRAWS):
        G = size[:, None] * draw.normal(size=(n, n))
        V = np.diag(np.diag(own.V) * 10.0 ** draw.uniform(-3, 3, m))
        weights.append(Weights(G @ G.T, V))
    gains = [gain for each in weights if (gain := _fastest(design, each, bound)) is not None]
    return sorted(gains, key=lambda gain: -design.decay(gain))


def _own(design: LinearDesign) -> Weights:
    """The model's noise; measurements that have none get some, small enough not to count."""
    size = np.trace(design.V) or np.trace(design.C @ design.W @ design.C.T) or 1.0
    return Weights(design.W, design.V + 1e-9 * size * np.eye(len(design.V)))


def _gain(design: LinearDesign, weights: Weights, alpha: float) -> np.ndarray:
    grown = np.exp(alpha * design.dt) if design.dt else 1.0
    A = design.A * grown if design.discrete else design.A + alpha * np.eye(len(design.A))
    K = steady_kalman(A, design.C, weights.W, weights.V, discrete=design.discrete).gain
    return np.asarray((A @ K if design.discrete else K) / grown)


def _fastest(design: LinearDesign, weights: Weights, bound: float) -> np.ndarray | None:
    """The gain with the largest alpha that keeps the bound, by bisection; None where none does."""

    def kept(alpha: float) -> np.ndarray | None:
        try:
            L = _gain(design, weights, alpha)
        except ValueError:
            return None
        return L if design.decay(L) > 0 and design.variance(L) <= _ROOM * bound else None

    unit = 1 / design.dt if design.dt else max(np.abs(np.linalg.eigvals(design.A)).max(), 1e-3)
    found: np.ndarray | None = None
    slow = fast = 0.0
    for fast in unit * np.geomspace(1e-4, 1e2 if design.dt else 1e4, 19):
        gain = kept(fast)
        if gain is not None:
            found, slow = gain, fast
        elif found is not None:
            break
    if found is None:
        return None
    for _ in range(8):
        middle = float(np.sqrt(slow * fast))
        gain = kept(middle)
        found, slow, fast = (found, slow, middle) if gain is None else (gain, middle, fast)
    return found
