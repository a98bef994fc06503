"""VQF by its own implementation, where it is installed."""

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from studies.broad.contest import Inclination
from studies.broad.trials import Trial
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


def vqf(trials: Sequence[Trial]) -> Peer | None:
    """VQF (Laidig and Seel, Information Fusion 91, 2023), six axes; None where it is missing."""
    try:
        import vqf as package
    except ImportError:
        return None

    def errors(tau: float) -> np.ndarray:
        found = []
        for trial in trials:
            filter = package.VQF(1 / trial.rate_hz, tauAcc=tau)
            rate, acceleration = (np.ascontiguousarray(x) for x in (trial.rate, trial.acceleration))
            q = filter.updateBatch(rate, acceleration)["quat6D"]
            found.append(float(Inclination()(jnp.asarray(q), jnp.asarray(trial.truth))))
        return np.array(found)

    default = errors(_DEFAULT)
    best = nelder_mead(
        lambda z: float(errors(float(np.exp(z[0]))).mean()),
        np.log([[_DEFAULT], [1.3 * _DEFAULT]]),
        xtol=0.02,
        ftol=np.inf,
        limit=15,
    )
    tau = float(np.exp(best.z[0]))
    return Peer(default, errors(tau), tau)


_DEFAULT = 3.0
"""VQF's own time constant for the accelerometers, s."""
