"""The fastest observer whose variances meet their bounds."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from objectives import LinearSystem, require_detectable
from tuner.certificate.solution import Status
from tuner.observers.lmi.design import design_of
from tuner.observers.lmi.reduction import largest_decay
from tuner.observers.lmi.search import Ended
from tuner.observers.lmi.units import Scaled, scaled


@dataclass(frozen=True)
class FastestObserver:
    """The observer whose error decays fastest while the variances of M e meet their bounds.

    Attributes:
        status: converged where ``alpha`` and ``limit`` meet; unattained where better observers
            have ever larger gains, towards the limit; unbounded where every rate is admissible.
        message: that, in a sentence.
        alpha: the decay rate that the matrix inequalities reach, in 1/s.
        limit: a rate that is out of their reach; inf where none is known.
        gain: L, ``(n, m)``.
        poles: eigenvalues of A - L C, ``(n,)``, the slowest first; in 1/s, or of a sample.
        rate: the decay rate of the slowest, in 1/s: what one Lyapunov matrix for both demands
            gives away is ``rate - alpha``, and what a better design has beyond ``rate``.
        covariance: of the error, ``(n, n)``, by its Lyapunov equation.
        variances: of M e, ``(k,)``, from that.
        multipliers: by how many per cent alpha rises where a bound is 1 % wider, ``(k,)``.
        needed: at ``limit``, no observer that meets the inequalities has all variances below this
            share of their bounds, as the dual solution proves: above 1. inf where no observer
            keeps them at all, nan where no limit is known.
        solved: how many matrix inequalities were solved.
        seconds: how long it took.
    """

    status: Status
    message: str
    alpha: float
    limit: float
    gain: np.ndarray
    poles: np.ndarray
    rate: float
    covariance: np.ndarray
    variances: np.ndarray
    multipliers: np.ndarray
    needed: float
    solved: int
    seconds: float


def fastest_observer(
    system: LinearSystem, errors: ArrayLike, bound: ArrayLike, *, tolerance: float = 1e-7
) -> FastestObserver:
    """The observer with the largest decay rate whose variances of M e meet their bounds.

    It is the fastest of those that one Lyapunov matrix proves to keep both rate and bounds
    (:mod:`tuner.observers.lmi.search`). A design with two Lyapunov matrices may be faster; none is
    slower.

    Args:
        system: the system; where it is discrete, the poles lie within exp(-alpha dt).
        errors: those that count, M, ``(k, n)``.
        bound: of the variances of M e, ``(k,)`` or a number, positive.
        tolerance: relative, of the rate.

    Raises:
        ValueError: for errors that do not fit, a system without any stable observer, or bounds
            that no observer keeps, with the least variances.

    >>> # e' = -(1 + l) e + w - l v has the variance (1 + l^2) / (2 + 2 l): 1 at l = 1 + sqrt(2).
    >>> system = LinearSystem([[-1.0]], [[1.0]], [[1.0]], [[1.0]])
    >>> fast = fastest_observer(system, [[1.0]], 1.0)
    >>> print(f"{fast.alpha:.5f}")
    3.41421
    """
    begun = time.perf_counter()
    design = design_of(system, errors)
    bounds = _bounds(bound, len(design.M))
    require_detectable(system)
    own = scaled(design, np.sqrt(bounds))
    found = largest_decay(own.inner, tolerance, bounds)
    return _in_outer_units(own, found, time.perf_counter() - begun)


def _in_outer_units(own: Scaled, found: Ended, seconds: float) -> FastestObserver:
    """The result for the outer design, from that for the inner one."""
    covariance = own.covariance(found.gain)
    return FastestObserver(
        status=found.status,
        message=found.message,
        alpha=found.alpha / own.time,
        limit=found.limit / own.time,
        gain=own.gain(found.gain),
        poles=own.poles(found.gain),
        rate=own.inner.system.decay(found.gain) / own.time,
        covariance=covariance,
        variances=own.outer.variances(covariance),
        multipliers=found.multipliers,
        needed=found.needed,
        solved=found.solved,
        seconds=seconds,
    )


def _bounds(bound: ArrayLike, count: int) -> np.ndarray:
    given = np.asarray(bound, float)
    if given.shape not in ((), (count,)):
        raise ValueError(f"bound has shape {given.shape}, but needs {(count,)} or a number")
    if not (np.isfinite(given) & (given > 0)).all():
        raise ValueError(f"bound is {given.tolist()}; give positive, finite variances")
    return np.array(np.broadcast_to(given, (count,)))
