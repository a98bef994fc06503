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

from objectives import LinearSystem, require_detectable
from tuner.certificate.solution import Status
from tuner.convex import Answer, solve
from tuner.observers.lmi.design import Design, design_of
from tuner.observers.lmi.inequalities import gain_of, riccati_program, variance_program
from tuner.observers.lmi.proof import limit, met, proved
from tuner.observers.lmi.units import Scaled, scaled

POLISHES = 3
"""Steps of Kleinman's iteration; each doubles the digits of the gain."""

SLOW = 1e-6
"""An observer that decays more slowly, over the size of A, may be on the stability limit."""


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


def h2_observer(system: LinearSystem, errors: ArrayLike) -> H2Observer:
    """The observer with the least sum of the variances of M e, proved from both sides.

    Args:
        system: the system.
        errors: those that count, M, ``(k, n)``.

    Raises:
        ValueError: for errors that do not fit, or a system without any stable observer.

    >>> observer = h2_observer(LinearSystem([[-1.0]], [[1.0]], [[3.0]], [[1.0]]), [[1.0]])
    >>> print(f"{observer.value:.6f} with gain {observer.gain.item():.6f}")
    1.000000 with gain 1.000000
    """
    begun = time.perf_counter()
    design = design_of(system, errors)
    require_detectable(system)
    plain = scaled(design)
    found = _least(plain)
    covariance = found.own.covariance(found.gain)
    variances = design.variances(covariance)
    return H2Observer(
        status=found.status,
        message=found.message,
        gain=found.own.gain(found.gain),
        poles=found.own.poles(found.gain),
        covariance=covariance,
        variances=variances,
        value=float(variances.sum()),
        lower_bound=found.lower * float(plain.errors[0]) ** 2,
        primal=found.primal,
        dual=found.dual,
        seconds=time.perf_counter() - begun,
    )


@dataclass(frozen=True)
class _Found:
    """A gain in coordinates of its own, its lower bound, and the status."""

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
    dual = solve(riccati_program(own.inner))
    primal = solve(variance_program(own.inner, capped=False))
    gain = gain_of(primal, own.inner)
    for _ in range(POLISHES):
        gain = _polished(own.inner, gain)
    gain = _or_zero(own.inner, gain)
    lower = proved(own.inner, gain, primal, dual)
    status, message = met(own.inner.total(gain), lower)
    found = _Found(own, gain, lower, primal, dual, status, message)
    slow = own.inner.system.decay(gain) < SLOW * np.linalg.norm(own.inner.system.A)
    if status is Status.CONVERGED and not slow:
        return found
    capped, ended, why = limit(plain.inner, lower)
    if status is Status.CONVERGED and ended is not Status.UNATTAINED:
        return found
    return replace(found, own=plain, gain=capped, status=ended, message=why)


def _whitened(plain: Scaled) -> Scaled:
    """Coordinates in which the Riccati inequality's solution is the identity."""
    dual = solve(riccati_program(plain.inner))
    return plain.whitened(dual.variables["X"]) if "X" in dual.variables else plain


def _polished(design: Design, gain: np.ndarray) -> np.ndarray:
    """The Kalman gain for the covariance that a gain leads to, unless that is worse."""
    s, P = design.system, design.covariance(gain)
    if not np.isfinite(P).all():
        return gain
    innovation = s.V + s.discrete * s.C @ P @ s.C.T
    if np.linalg.cond(innovation) > 1e10:
        return gain
    carried = (s.A @ P if s.discrete else P) @ s.C.T + s.S
    better = np.asarray(np.linalg.solve(innovation, carried.T).T)
    before, after = design.variances(P).sum(), design.total(better)
    return better if after <= before * (1 + 1e-12) else gain


def _or_zero(design: Design, gain: np.ndarray) -> np.ndarray:
    """A gain, or zero where the system without one does as well: what is not driven decays."""
    none = np.zeros_like(gain)
    return none if design.total(none) <= design.total(gain) else gain
