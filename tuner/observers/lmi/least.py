"""The observer with the least variance.

The gain is what some steps of Kleinman's iteration (IEEE TAC 13, 1968) make of that of the matrix
inequality, where V (in discrete time C P C' + V) is regular: the value is quadratic in the gain, so
that the inequality alone gives the gain to half the digits of the value.

Where V is singular, or a mode on the stability limit is not driven by noise, the optimum may be a
limit that no observer reaches; it is then shown by :data:`tuner.observers.lmi.proof.CAPS` on Y, and
the observer of the best of them is returned.
"""

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from tuner.certificate.solution import Status
from tuner.convex import Answer, solve
from tuner.observers.lmi.inequalities import gain_of, largest_covariance, least_variance
from tuner.observers.lmi.model import Model, observer_model, refuse_undetectable
from tuner.observers.lmi.proof import limit, met, proved
from tuner.observers.lmi.units import Scaled, scaled

POLISHES = 3
"""Steps of Kleinman's iteration; each doubles the digits of the gain."""

SLOW = 1e-6
"""An observer that forgets slower, over the size of A, may be about not to forget at all."""


@dataclass(frozen=True)
class H2Observer:
    """The observer whose error has the least variance: the Kalman filter in steady state.

    Attributes:
        status: converged where the two certificates meet; unattained where better observers have
            ever larger gains or ever slower poles, towards the lower bound.
        message: that, in a sentence.
        gain: L, ``(n, m)``.
        poles: eigenvalues of A - L C, ``(n,)``, the slowest first; in 1/s, or of a sample.
        covariance: of the error under this gain, ``(n, n)``, by its Lyapunov equation.
        variances: of M e, ``(k,)``, from that.
        value: their sum.
        lower_bound: no observer has a lower sum.
        primal: the matrix inequality of the observer, in coordinates of its own.
        dual: the Riccati inequality, whose every point bounds all covariances from below.
        seconds: how long it took.
    """

    status: Status
    message: str
    gain: np.ndarray
    poles: np.ndarray
    covariance: np.ndarray
    variances: np.ndarray
    value: float
    lower_bound: float
    primal: Answer
    dual: Answer
    seconds: float


def h2_observer(
    A: ArrayLike,
    C: ArrayLike,
    W: ArrayLike,
    V: ArrayLike,
    M: ArrayLike,
    *,
    discrete: bool = False,
) -> H2Observer:
    """The observer with the least sum of the variances of M e, proved from both sides.

    Args:
        A, C, W, V, M, discrete: see :class:`tuner.observers.lmi.Model`.

    Raises:
        ValueError: for shapes that do not fit, noise that is no covariance, or a model without
            any stable observer.

    >>> observer = h2_observer([[-1.0]], [[1.0]], [[3.0]], [[1.0]], [[1.0]])
    >>> print(f"{observer.value:.6f} with gain {observer.gain.item():.6f}")
    1.000000 with gain 1.000000
    """
    begun = time.perf_counter()
    model = observer_model(A, C, W, V, M, discrete)
    plain = scaled(model)
    refuse_undetectable(plain.inner, plain.units.time)
    found = _least(plain)
    covariance = found.own.covariance(found.gain)
    variances = model.variances(covariance)
    return H2Observer(
        status=found.status,
        message=found.message,
        gain=found.own.units.gain(found.gain),
        poles=found.own.poles(found.gain),
        covariance=covariance,
        variances=variances,
        value=float(variances.sum()),
        lower_bound=found.lower * float(plain.units.errors[0]) ** 2,
        primal=found.primal,
        dual=found.dual,
        seconds=time.perf_counter() - begun,
    )


@dataclass(frozen=True)
class _Found:
    """A gain in coordinates of its own, the bound it is held against, and how that ended."""

    own: Scaled
    gain: np.ndarray
    lower: float
    primal: Answer
    dual: Answer
    status: Status
    message: str


def _least(plain: Scaled) -> _Found:
    """The best gain in coordinates in which all covariances are near one, or else in plain ones."""
    own = _whitened(plain)
    dual = solve(largest_covariance(own.inner))
    primal = solve(least_variance(own.inner, capped=False))
    gain = gain_of(primal, own.inner)
    for _ in range(POLISHES):
        gain = _polished(own.inner, gain)
    gain = _better(own.inner, gain)
    lower = proved(own.inner, gain, primal, dual)
    status, message = met(own.inner.total(gain), lower)
    found = _Found(own, gain, lower, primal, dual, status, message)
    slow = own.inner.rate(gain) < SLOW * np.linalg.norm(own.inner.A)
    if status is Status.CONVERGED and not slow:
        return found
    capped, ended, why = limit(plain.inner, lower)
    if status is Status.CONVERGED and ended is not Status.UNATTAINED:
        return found
    return replace(found, own=plain, gain=capped, status=ended, message=why)


def _whitened(plain: Scaled) -> Scaled:
    """Coordinates in which the Riccati inequality's solution is the unit matrix."""
    dual = solve(largest_covariance(plain.inner))
    return plain.whitened(dual.variables["X"]) if "X" in dual.variables else plain


def _polished(model: Model, gain: np.ndarray) -> np.ndarray:
    """The Kalman gain for the covariance that a gain leads to, unless that is worse."""
    P = model.covariance(gain)
    if not np.isfinite(P).all():
        return gain
    innovation = model.V + model.discrete * model.C @ P @ model.C.T
    if np.linalg.cond(innovation) > 1e10:
        return gain
    carried = (model.A @ P if model.discrete else P) @ model.C.T
    better = np.asarray(np.linalg.solve(innovation, carried.T).T)
    before, after = model.variances(P).sum(), model.total(better)
    return better if after <= before * (1 + 1e-12) else gain


def _better(model: Model, gain: np.ndarray) -> np.ndarray:
    """A gain, or none where the model left alone does as well: what is not driven decays."""
    none = np.zeros_like(gain)
    return none if model.total(none) <= model.total(gain) else gain
