"""VQF by its own implementation, where it is installed."""

from functools import cache
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from objectives import Records
from studies.broad.contest import Contest, Error
from tuner.solvers import nelder_mead


class Peer(NamedTuple):
    """Errors of another program's filter on single trials, deg, ``(k,)``.

    Attributes:
        default: with its own parameters.
        tuned: with the accelerometers' time constant tuned on these very trials.
        tau: that time constant, s.
    """

    default: np.ndarray
    tuned: np.ndarray
    tau: float


def vqf(contest: Contest) -> Peer | None:
    """VQF (Laidig and Seel, Information Fusion 91, 2023), six axes; None where it is missing."""
    try:
        import vqf as package
    except ImportError:
        return None
    truth = contest.data("mahony").truth
    samples = [
        [np.ascontiguousarray(part[: len(truth)]) for part in (trial.rate, trial.acceleration)]
        for trial in contest.trials
    ]
    q = np.ones(truth.shape)

    @cache
    def errors(tau: float) -> np.ndarray:
        for i, (rate, acceleration) in enumerate(samples):
            filter = package.VQF(1 / contest.rate_hz, tauAcc=tau)
            q[: len(rate), i] = filter.updateBatch(rate, acceleration)["quat6D"]
        return np.asarray(_errors(jnp.asarray(q), truth))

    best = nelder_mead(
        lambda z: float(errors(float(np.exp(z[0]))).mean()),
        np.log([[_DEFAULT], [1.3 * _DEFAULT]]),
        xtol=0.02,
        ftol=np.inf,
        limit=15,
    )
    tau = float(np.exp(best.z[0]))
    return Peer(errors(_DEFAULT), errors(tau), tau)


_errors = jax.jit(Records(Error()).each)
_DEFAULT = 3.0
"""VQF's own time constant for the accelerometers, s."""
