"""Measurements free of noise: what they show is followed, and the rest is designed for.

Such a measurement may be followed arbitrarily fast, so that its error vanishes, and its derivative
is the next measurement (Luenberger, IEEE TAC 11, 1966): what the matrix inequalities come to as Z,
then Y, grow without limit.
"""

from dataclasses import dataclass, replace

import numpy as np

from tuner.certificate.solution import Status
from tuner.observers.lmi.model import Model
from tuner.observers.lmi.search import EVERY, ROOM, Ended, search

CLEAN = 1e-10
"""A measurement with less noise, in the model's own units, counts as one without."""


@dataclass(frozen=True)
class Reduction:
    """A model without the errors that measurements free of noise show at once.

    Attributes:
        full: the model before.
        reduced: the model after; its measurements are the noisy ones, then the derivatives.
        noisy: the noisy measurements, as combinations of all, ``(m, m1)``.
        clean: the others, ``(m, r)``.
        rest: orthonormal basis of the states that remain, ``(n, n - r)``.
        shown: the states shown, ``(n, r)``: clean' C shown = 1.
    """

    full: Model
    reduced: Model
    noisy: np.ndarray
    clean: np.ndarray
    rest: np.ndarray
    shown: np.ndarray

    @property
    def complete(self) -> bool:
        """Whether no state remains."""
        return not self.reduced.A.size

    def lifted(self, gain: np.ndarray, speed: float) -> np.ndarray:
        """A gain for the full model: the reduced poles stay, the others go to about -speed."""
        count = self.noisy.shape[1]
        K, D = gain[:, :count], gain[:, count:]
        A, N, R, c = self.full.A, self.rest, self.shown, self.clean.T @ self.full.C
        F = self.reduced.A - gain @ self.reduced.C
        kept = N.T @ A @ R - K @ self.noisy.T @ self.full.C @ R + D * speed + F @ D
        shown = c @ A @ R + speed * np.eye(R.shape[1])
        return np.asarray(N @ K @ self.noisy.T + (N @ kept + R @ shown) @ self.clean.T)


def reduction(model: Model) -> Reduction | None:
    """What remains of a continuous model with measurements free of noise; None without such."""
    values, vectors = np.linalg.eigh(model.V)
    free = values <= CLEAN * max(values[-1], 1.0)
    if model.discrete or not free.any():
        return None
    noisy, clean = vectors[:, ~free], vectors[:, free]
    left, sizes, right = np.linalg.svd(clean.T @ model.C)
    rank = int(np.sum(sizes > 1e-9 * np.linalg.norm(model.C)))
    if not rank:
        return None
    clean = clean @ left[:, :rank]
    shown, rest = right[:rank].T / sizes[:rank], right[rank:].T
    return Reduction(model, _reduced(model, noisy, clean, rest), noisy, clean, rest, shown)


def _reduced(model: Model, noisy: np.ndarray, clean: np.ndarray, rest: np.ndarray) -> Model:
    c = clean.T @ model.C
    shared = c @ model.S @ noisy
    return Model(
        A=rest.T @ model.A @ rest,
        C=np.vstack([noisy.T @ model.C @ rest, c @ model.A @ rest]),
        W=rest.T @ model.W @ rest,
        V=np.block([[noisy.T @ model.V @ noisy, shared.T], [shared, c @ model.W @ c.T]]),
        M=model.M @ rest,
        S=np.hstack([rest.T @ model.S @ noisy, rest.T @ model.W @ c.T]),
        discrete=False,
    )


def fastest(model: Model, tolerance: float, bounds: np.ndarray) -> Ended:
    """The fastest observer of a model, by way of the reduced one where there is one.

    Args:
        model, tolerance, bounds: see :func:`tuner.observers.lmi.search.search`; here measurements
            may be free of noise.
    """
    step = reduction(model)
    if step is None:
        return search(model, tolerance, bounds)
    ended = _all_shown(step) if step.complete else fastest(step.reduced, tolerance, bounds)
    gain = _followed(step, ended.slower)
    if gain is None:
        return replace(
            ended,
            status=Status.FAILED,
            message="no finite gain was found that keeps the bounds",
            gain=np.full((len(model.A), len(model.C)), np.nan),
        )
    if ended.status is Status.CONVERGED:
        ended = replace(
            ended,
            status=Status.UNATTAINED,
            message=f"measurements free of noise may be followed ever faster; the gain gives away "
            f"up to {100 * ROOM:g} % of the rate",
        )
    return replace(ended, gain=gain, slower=gain)


def _all_shown(step: Reduction) -> Ended:
    """What a search comes to where nothing is left to be found out."""
    nothing = np.zeros((0, len(step.reduced.C)))
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
    """The slowest of a few speeds that takes at most half the room below the bounds."""
    inner, full = step.reduced, step.full
    used = np.zeros(len(full.M)) if step.complete else inner.variances_under(gain)
    for speed in 2.0 ** np.arange(0, 60):
        lifted = step.lifted(gain, speed)
        fast = step.complete or full.rate(lifted) >= inner.rate(gain) * (1 - 1e-6)
        if fast and np.all(full.variances_under(lifted) <= (1 + used) / 2):
            return lifted
    return None
