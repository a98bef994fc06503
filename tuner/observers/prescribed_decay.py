"""Kalman filters with a prescribed degree of stability: fast within a bound already.

A search for the fastest observer begins from them.
"""

from typing import NamedTuple

import numpy as np

from objectives import LinearSystem, steady_kalman
from objectives.linear_systems.model import derived
from tuner.observers.gains import Variance

DRAWS = 24
"""Number of weightings that are tried beside the model's own noise."""
_SHARE_OF_BOUND = 0.98
"""A start uses this share of the bound."""


class Weights(NamedTuple):
    """The noise that a gain is computed for, true or not.

    Attributes:
        W: of the states, ``(n, n)``.
        V: of the measurements, ``(m, m)``, positive definite.
    """

    W: np.ndarray
    V: np.ndarray


def prescribed_decay(system: LinearSystem, variance: Variance, bound: float) -> np.ndarray:
    """The fastest Kalman gain of prescribed decay for the system's own noise, ``(n, m)``.

    It is the Kalman gain of a system which grows faster by e^(alpha t): all poles of the true one
    then decay faster than alpha (Anderson and Moore, 1969). alpha is as large as the bound allows.
    """
    found = _of_largest_decay(system, _own(system), variance, bound)
    return _gain(system, _own(system), 0.0) if found is None else found


def starting_gains(
    system: LinearSystem, variance: Variance, bound: float, size: np.ndarray
) -> list[np.ndarray]:
    """Such gains that meet the bound, for the system's noise and for drawn ones; fastest first.

    The draws (their seed is fixed: they belong to the problem, not to a solver) break symmetries
    in which a search would be caught.

    Args:
        system: the system.
        variance: that of the error that counts.
        bound: of the variance.
        size: a typical error of every state, ``(n,)``.
    """
    draw = np.random.default_rng(0)
    n, m = len(system.A), len(system.C)
    own = _own(system)
    weights = [own]
    for _ in range(DRAWS):
        G = size[:, None] * draw.normal(size=(n, n))
        V = np.diag(np.diag(own.V) * 10.0 ** draw.uniform(-3, 3, m))
        weights.append(Weights(G @ G.T, V))
    found = [_of_largest_decay(system, each, variance, bound) for each in weights]
    gains = [gain for gain in found if gain is not None]
    return sorted(gains, key=lambda gain: -system.decay(gain))


def gain_of_decay(system: LinearSystem, alpha: float) -> np.ndarray:
    """The Kalman gain of a system that grows faster by e^(alpha t), ``(n, m)``.

    Raises:
        ValueError: where there is none.
    """
    return _gain(system, _own(system), alpha)


def _own(system: LinearSystem) -> Weights:
    """The system's noise; measurements that have none get some, small enough not to count."""
    size = np.trace(system.V) or np.trace(system.C @ system.W @ system.C.T) or 1.0
    return Weights(system.W, system.V + 1e-9 * size * np.eye(len(system.V)))


def _gain(system: LinearSystem, weights: Weights, alpha: float) -> np.ndarray:
    grown = np.exp(alpha * system.dt) if system.dt else 1.0
    A = system.A * grown if system.discrete else system.A + alpha * np.eye(len(system.A))
    parts = {"A": A, "C": system.C, "W": weights.W, "V": weights.V, "S": np.zeros_like(system.S)}
    return np.asarray(steady_kalman(derived(parts, system.dt)).predictor / grown)


def _of_largest_decay(
    system: LinearSystem, weights: Weights, variance: Variance, bound: float
) -> np.ndarray | None:
    """The gain with the largest alpha that meets the bound, by bisection; None where none does."""

    def kept(alpha: float) -> np.ndarray | None:
        try:
            L = _gain(system, weights, alpha)
        except ValueError:
            return None
        within = variance.under(system.covariance(L)) <= _SHARE_OF_BOUND * bound
        return L if system.decay(L) > 0 and within else None

    unit = 1 / system.dt if system.dt else max(np.abs(np.linalg.eigvals(system.A)).max(), 1e-3)
    found: np.ndarray | None = None
    slow = fast = 0.0
    for fast in unit * np.geomspace(1e-4, 1e2 if system.dt else 1e4, 19):
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
