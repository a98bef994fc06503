"""VQF by its own implementation, where it is installed."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from scipy.optimize import minimize_scalar

from filters.rotation import from_rotation_vector, multiply
from objectives import Records
from studies.broad.contest import Contest, Error
from tuner.solvers import nelder_mead

TAUS = np.geomspace(1.0, 8.0, 13)
"""Grid of time constants where a lead is tuned as well, s."""
LEADS = (0.0, 3e-3, 6e-3)
"""Three leads that determine the parabola of the squared error, s."""


class Peer(NamedTuple):
    """Errors of another program's filter on single trials, deg, ``(k,)``.

    Attributes:
        default: with its own parameters.
        tuned: with the accelerometers' time constant tuned on these very trials.
        tau: that time constant, s.
        ahead: with a lead tuned as well, as the room filter's is.
        ahead_at: time constant and lead of these, s.
        left_out: with both tuned on all trials but the one that is judged.
        alone: with both tuned on the very trial that is judged.
    """

    default: np.ndarray
    tuned: np.ndarray
    tau: float
    ahead: np.ndarray
    ahead_at: tuple[float, float]
    left_out: np.ndarray
    alone: np.ndarray


def vqf(contest: Contest) -> Peer | None:
    """VQF (Laidig and Seel, Information Fusion 91, 2023), six axes; None where it is missing."""
    try:
        import vqf  # noqa: F401
    except ImportError:
        return None
    return _peer(contest)


@cache  # used by several claims; of one contest, which is compared by identity
def _peer(contest: Contest) -> Peer:
    runs = _Runs(contest)
    best = nelder_mead(
        lambda z: float(runs.errors(float(np.exp(z[0]))).mean()),
        np.log([[_DEFAULT], [1.3 * _DEFAULT]]),
        xtol=0.02,
        ftol=np.inf,
        limit=15,
    )
    tau = float(np.exp(best.z[0]))
    every = range(len(contest.trials))
    at = runs.best(every)
    others = [runs.best([j for j in every if j != i] or [i]) for i in every]
    alone = [runs.best([i]) for i in every]
    return Peer(
        default=runs.errors(_DEFAULT),
        tuned=runs.errors(tau),
        tau=tau,
        ahead=runs.errors(*at),
        ahead_at=at,
        left_out=np.array([runs.errors(*others[i])[i] for i in every]),
        alone=np.array([runs.errors(*alone[i])[i] for i in every]),
    )


@dataclass(eq=False)
class _Runs:
    """VQF on all trials of a contest, each time constant run once."""

    contest: Contest
    _attitudes: dict[float, Array] = field(default_factory=dict)
    _parabolas: dict[float, np.ndarray] = field(default_factory=dict)

    def errors(self, tau: float, lead: float = 0.0) -> np.ndarray:
        """Errors by trial, deg; the attitude is extrapolated at the last sample's rate."""
        data = self.contest.data("mahony")
        q = self._of(tau)
        return np.asarray(_errors(q, data.inputs.gyr, jnp.asarray(lead), data.truth))

    def best(self, trials: Sequence[int]) -> tuple[float, float]:
        """Time constant and lead of the least mean error on some trials."""
        found = [(*self._lead(tau, list(trials)), tau) for tau in TAUS.tolist()]
        _, lead, tau = min(found)
        return tau, lead

    def _lead(self, tau: float, trials: list[int]) -> tuple[float, float]:
        """The least mean error, and its lead.

        A lead turns the vertical by a proportional vector, so the squared error is a parabola.
        """
        if tau not in self._parabolas:
            squares = np.array([self.errors(tau, lead) ** 2 for lead in LEADS])
            self._parabolas[tau] = np.polyfit(LEADS, squares, 2)
        chosen = self._parabolas[tau][:, trials]

        def mean(lead: float) -> float:
            return float(np.sqrt(np.maximum(np.polyval(chosen, lead), 0.0)).mean())

        found = minimize_scalar(mean, bounds=(-0.02, 0.02), method="bounded")
        return float(found.fun), float(found.x)

    def _of(self, tau: float) -> Array:
        if tau not in self._attitudes:
            self._attitudes[tau] = jnp.asarray(self._run(tau))
        return self._attitudes[tau]

    def _run(self, tau: float) -> np.ndarray:
        import vqf

        q = np.ones(self.contest.data("mahony").truth.shape)
        for i, trial in enumerate(self.contest.trials):
            parts = (trial.rate[: len(q)], trial.acceleration[: len(q)])
            rate, acceleration = (np.ascontiguousarray(part) for part in parts)
            filter = vqf.VQF(1 / self.contest.rate_hz, tauAcc=tau)
            q[: len(rate), i] = filter.updateBatch(rate, acceleration)["quat6D"]
        return q


@jax.jit
def _errors(q: Array, rate: Array, lead: Array, truth: Array) -> Array:
    """Errors by trial, deg, of attitudes ``(N, k, 4)`` extrapolated by a lead."""
    turned = jax.vmap(jax.vmap(multiply))(q, jax.vmap(jax.vmap(from_rotation_vector))(rate * lead))
    return Records(Error()).each(turned, truth)


_DEFAULT = 3.0
"""VQF's own time constant for the accelerometers, s."""
