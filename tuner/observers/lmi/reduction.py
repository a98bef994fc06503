"""Measurements free of noise: the states they show are followed, the rest is designed for.

Such a measurement may be followed arbitrarily fast, so that its error vanishes, and its derivative
is the next measurement (Luenberger, IEEE TAC 11, 1966): what the matrix inequalities come to as Z,
then Y, grow without limit.
"""

from dataclasses import dataclass, replace

import numpy as np

from objectives.linear_systems.model import derived
from tuner.certificate.solution import Status
from tuner.observers.lmi.design import Design
from tuner.observers.lmi.search import EVERY, ROOM, Ended, search

CLEAN = 1e-10
"""A measurement with less noise, in the own units of a system, counts as one without."""


@dataclass(frozen=True)
class Reduction:
    """A design without the errors that measurements free of noise show at once.

    Attributes:
        full: the design before.
        reduced: the design after; its measurements are the noisy ones, then the derivatives.
        noisy: the noisy measurements, as combinations of all, ``(m, m1)``.
        clean: the others, ``(m, r)``.
        rest: orthonormal basis of the states that remain, ``(n, n - r)``.
        shown: the states shown, ``(n, r)``: clean' C shown = 1.
    """

    full: Design
    reduced: Design
    noisy: np.ndarray
    clean: np.ndarray
    rest: np.ndarray
    shown: np.ndarray

    @property
    def complete(self) -> bool:
        """Whether no state remains."""
        return not self.reduced.system.A.size

    def lifted(self, gain: np.ndarray, speed: float) -> np.ndarray:
        """A gain for the full design: the reduced poles stay, the others go to about -speed."""
        count = self.noisy.shape[1]
        K, D = gain[:, :count], gain[:, count:]
        A, C, N, R = self.full.system.A, self.full.system.C, self.rest, self.shown
        c = self.clean.T @ C
        F = self.reduced.system.A - gain @ self.reduced.system.C
        kept = N.T @ A @ R - K @ self.noisy.T @ C @ R + D * speed + F @ D
        shown = c @ A @ R + speed * np.eye(R.shape[1])
        return np.asarray(N @ K @ self.noisy.T + (N @ kept + R @ shown) @ self.clean.T)


def reduction(design: Design) -> Reduction | None:
    """The reduced system where some measurements are free of noise; None where none are."""
    system = design.system
    values, vectors = np.linalg.eigh(system.V)
    free = values <= CLEAN * max(values[-1], 1.0)
    if system.discrete or not free.any():
        return None
    noisy, clean = vectors[:, ~free], vectors[:, free]
    left, sizes, right = np.linalg.svd(clean.T @ system.C)
    rank = int(np.sum(sizes > 1e-9 * np.linalg.norm(system.C)))
    if not rank:
        return None
    clean = clean @ left[:, :rank]
    shown, rest = right[:rank].T / sizes[:rank], right[rank:].T
    return Reduction(design, _reduced(design, noisy, clean, rest), noisy, clean, rest, shown)


def _reduced(design: Design, noisy: np.ndarray, clean: np.ndarray, rest: np.ndarray) -> Design:
    s = design.system
    c = clean.T @ s.C
    shared = c @ s.S @ noisy
    parts = {
        "A": rest.T @ s.A @ rest,
        "C": np.vstack([noisy.T @ s.C @ rest, c @ s.A @ rest]),
        "W": rest.T @ s.W @ rest,
        "V": np.block([[noisy.T @ s.V @ noisy, shared.T], [shared, c @ s.W @ c.T]]),
        "S": np.hstack([rest.T @ s.S @ noisy, rest.T @ s.W @ c.T]),
    }
    return Design(derived(parts, None), design.M @ rest)


def largest_decay(design: Design, tolerance: float, bounds: np.ndarray) -> Ended:
    """The fastest observer of a design, by way of the reduced one where there is one.

    Args:
        design, tolerance, bounds: see :func:`tuner.observers.lmi.search.search`; here measurements
            may be free of noise.
    """
    step = reduction(design)
    if step is None:
        return search(design, tolerance, bounds)
    ended = (
        _all_states_known(step) if step.complete else largest_decay(step.reduced, tolerance, bounds)
    )
    gain = _followed(step, ended.slower)
    if gain is None:
        return replace(
            ended,
            status=Status.FAILED,
            message="no finite gain was found that meets the bounds",
            gain=np.full(design.sizes[:2], np.nan),
        )
    if ended.status is Status.CONVERGED:
        ended = replace(
            ended,
            status=Status.UNATTAINED,
            message=f"measurements free of noise may be followed ever faster; the gain gives away "
            f"up to {100 * ROOM:g} % of the rate",
        )
    return replace(ended, gain=gain, slower=gain)


def _all_states_known(step: Reduction) -> Ended:
    """The result of a search in which no state remains to be estimated."""
    nothing = np.zeros(step.reduced.sizes[:2])
    return Ended(
        status=Status.UNBOUNDED,
        message=EVERY,
        alpha=np.inf,
        limit=np.inf,
        gain=nothing,
        slower=nothing,
        multipliers=np.zeros(len(step.full.M)),
        needed=np.nan,
        solved=0,
    )


def _followed(step: Reduction, gain: np.ndarray) -> np.ndarray | None:
    """The slowest of a few speeds that takes at most half the margin below the bounds."""
    inner, full = step.reduced, step.full
    used = np.zeros(len(full.M)) if step.complete else inner.variances_under(gain)
    for speed in 2.0 ** np.arange(0, 60):
        lifted = step.lifted(gain, speed)
        fast = step.complete or full.system.decay(lifted) >= inner.system.decay(gain) * (1 - 1e-6)
        if fast and np.all(full.variances_under(lifted) <= (1 + used) / 2):
            return lifted
    return None
