"""The paper's vertical channel with its numbers, and its error dynamics."""

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import (
    ConventionalLoop,
    Flow,
    GainCovariance,
    KalmanCovariance,
    LinearModel,
    LoopGains,
    RiccatiCovariance,
    Uncertainty,
    loop_error,
    riccati_flow,
    run,
    van_loan,
    vertical_channel,
)
from objectives import LinearSystem
from objectives.in_numpy import in_numpy
from studies.ha1981 import paper
from studies.ha1981.settings import Settings
from tuner.limits import check_amount

ERRORS = tuple(ConventionalLoop.states)
"""(A_B, dV, dh), the state."""
ENTERS = np.array([[0.0], [1.0], [0.0]])
"""G of (11): W_a is an acceleration."""
MEASURED = np.array([[0.0, 0.0, 1.0]])
"""H of (11): the altitude error is measured."""


@dataclass(frozen=True)
class Channel:
    """The channel's numbers in one system of units.

    Attributes:
        unit: of length.
        bound: of the bias's variance, (unit/s^2)^2.
        q_a: spectral density of W_a, (unit/s^2)^2 s.
        q_b: variance of the altitude's noise, unit^2.
        sigma2_ab: variance of the bias at t = 0, (unit/s^2)^2.
        sigma2_hr: variance of the given altitude, unit^2.
        k_gh: gravity's gradient, 1/s^2.
    """

    unit: str
    bound: float
    q_a: float
    q_b: float
    sigma2_ab: float
    sigma2_hr: float
    k_gh: float

    @classmethod
    def of(cls, s: Settings) -> "Channel":
        """The channel in the requested unit, with the paper's values as defaults."""
        square = 1.0 if s.unit == "ft" else paper.FOOT**2

        def given(value: float | None, printed: float) -> float:
            return printed * square if value is None else value

        return cls(
            unit=s.unit,
            bound=given(s.bound, paper.BOUND),
            q_a=given(s.q_a, paper.Q_A),
            q_b=given(s.q_b, paper.Q_B),
            sigma2_ab=given(s.sigma2_ab, paper.SIGMA2_AB),
            sigma2_hr=given(s.sigma2_hr, paper.SIGMA2_HR),
            k_gh=s.k_gh,
        )

    @property
    def eta(self) -> float:
        """The bound over q_a, 1/s: the only number that the conventional design depends on."""
        return self.bound / self.q_a

    @property
    def floor(self) -> float:
        """The bias's variance due to errors of the given altitude: Kgh^2 sigma_hr^2 in (5)."""
        return self.k_gh**2 * self.sigma2_hr

    @property
    def squared(self) -> str:
        """The unit of a bias's variance."""
        return f"({self.unit}/s^2)^2"

    def system(self, density: float) -> LinearSystem:
        """(11) in continuous time, with a spectral density of the altitude's noise, unit^2 s."""
        A, W = vertical_channel(self.k_gh), ENTERS @ ENTERS.T * self.q_a
        return LinearSystem(A, MEASURED, W, [[density]], states=ERRORS)

    def model(self, Ts: float) -> LinearModel:
        """(11) and (12): exact Phi, Q of white noise (Van Loan); the one printed has no Ts."""
        made: LinearModel = model_of(self.numbers, Ts)
        return made

    @property
    def numbers(self) -> tuple[float, ...]:
        """The numbers that a model is made of: q_a, q_b, sigma^2_AB, sigma^2_hr and k_gh."""
        return self.q_a, self.q_b, self.sigma2_ab, self.sigma2_hr, self.k_gh

    def loop(self, gains: "Gains", dt: float) -> LinearModel:
        """(10) in error coordinates over one step; nothing is measured."""
        start = (self.sigma2_ab, 0.0, 0.0, self.sigma2_hr)
        made: LinearModel = in_numpy(_loop, gains.loop(self.k_gh), self.k_gh, self.q_a, start, dt)
        return made


@dataclass(frozen=True)
class Gains:
    """Gains of the conventional loop, with K2' = K2 - Kgh as the theory has it.

    Attributes:
        K1: 1/s.
        K2p: K2', 1/s^2.
        K3: 1/s^3.
    """

    K1: float
    K2p: float
    K3: float

    def loop(self, k_gh: float) -> LoopGains:
        """The gains as they are programmed."""
        return LoopGains(self.K1, self.K2p + k_gh, self.K3)

    def scaled(self, factor: float) -> "Gains":
        """All poles times a factor; the variance is then multiplied by it as well."""
        return Gains(self.K1 * factor, self.K2p * factor**2, self.K3 * factor**3)

    def at(self, eta: float) -> "Gains":
        """The same form, scaled until the noise's share of (5) is eta q_a."""
        return self.scaled(eta / float(noise_share(self.K1, self.K2p, self.K3)))

    @property
    def error(self) -> np.ndarray:
        """The loop's dynamics without the given altitude's error, ``(3, 3)``."""
        return np.asarray(in_numpy(loop_error, self.loop(0.0), 0.0))[:3, :3]


FORMS = {
    "triple pole": Gains(3.0, 3.0, 1.0),
    "ISE form": Gains(1.0, 2.0, 1.0),
    "Bessel": Gains(6.0, 15.0, 15.0),
    "Butterworth": Gains(2.0, 2.0, 1.0),
}
"""Standard forms s^3 + K1 s^2 + K2' s + K3, to be scaled to a bound."""


def noise_share(K1: Array | float, K2p: Array | float, K3: Array | float) -> Array | float:
    """The second term of (5) over q_a: the bias's variance due to W_a, 1/s."""
    return K1 * K3 / (2 * (K1 * K2p - K3))


class History(NamedTuple):
    """Covariances P(+) ``(N, n, n)`` and gains K ``(N, n, 1)`` over time."""

    P: np.ndarray
    K: np.ndarray


def times(seconds: float, Ts: float) -> np.ndarray:
    """The sampling times from 0 to an end, ``(N,)``, s."""
    check_amount(f"{seconds / Ts:.4g} steps", 512 * seconds / Ts, "take fewer seconds")
    return np.arange(int(np.floor(seconds / Ts + 1e-9)) + 1) * Ts


# Compiled for a few lengths only: a longer history costs less than another compilation, and a fast
# one would take longer to compile than all of them to run.
SHORTEST = 256
QUICKLY = {"xla_backend_optimization_level": 0}
_quickly = partial(jax.jit, compiler_options=QUICKLY)


def _counted(samples: int) -> np.ndarray:
    return np.zeros(max(SHORTEST, 2 ** (samples - 1).bit_length()))


def kalman_history(channel: Channel, Ts: float, seconds: float) -> History:
    """(14) to (17): P(+) and gains, the first measurement at t = 0; stacked along time."""
    samples = len(times(seconds, Ts))
    found = _kalman(channel.model(Ts), _counted(samples))
    return History(np.asarray(found.P)[:samples], np.asarray(found.K)[:samples])


def riccati_history(channel: Channel, dt: float, seconds: float) -> History:
    """The continuous filter with q_b as a spectral density; gains P H' / q_b."""
    system = channel.system(channel.q_b)
    samples = len(times(seconds, dt))
    parts = (system.A, system.C, system.W, system.V)
    found = _riccati(parts, dt, channel.model(1.0).P0, _counted(samples))
    P = np.asarray(found)[:samples]
    return History(P, P[:, :, 2:] / channel.q_b)


def replayed(truth: LinearModel, K: np.ndarray) -> np.ndarray:
    """(19): P11(+) when gains ``(N, 3, 1)`` are applied to a given truth, ``(N,)``."""
    return np.asarray(_variance(truth, lengthened(K)))[: len(K)]


def lengthened(K: np.ndarray) -> np.ndarray:
    """Gains with zeros after them, of one of the few lengths that are compiled."""
    missing = len(_counted(len(K))) - len(K)
    return np.pad(np.asarray(K), ((0, missing), (0, 0), (0, 0)))


def loop_history(channel: Channel, gains: Gains, dt: float, seconds: float) -> np.ndarray:
    """sigma_epsilon^2(t) of the conventional loop by (10), ``(N,)``."""
    samples = len(times(seconds, dt))
    return replayed(channel.loop(gains, dt), np.zeros((samples, 4, 1)))


@jax.jit
def model_of(numbers: tuple[Array, ...], Ts: Array) -> LinearModel:
    """The model of a channel's numbers, differentiable in them."""
    q_a, q_b, sigma2_ab, sigma2_hr, k_gh = numbers
    F, G = vertical_channel(k_gh), jnp.asarray(ENTERS)
    return LinearModel(
        transition=van_loan(F, G, jnp.reshape(q_a, (1, 1)), Ts),
        H=jnp.asarray(MEASURED),
        R=jnp.reshape(q_b, (1,)),
        P0=jnp.diag(jnp.stack([sigma2_ab, jnp.zeros(()), sigma2_hr])),
        x0=jnp.zeros(3),
    )


def _loop(
    gains: LoopGains, k_gh: Array, q_a: Array, start: tuple[Array, ...], dt: Array
) -> LinearModel:
    noise = jnp.array([[0.0], [0.0], [1.0], [0.0]])
    return LinearModel(
        transition=van_loan(loop_error(gains, k_gh), noise, jnp.reshape(q_a, (1, 1)), dt),
        H=jnp.zeros((1, 4)),
        R=jnp.ones(1),
        P0=jnp.diag(jnp.stack(start)),
        x0=jnp.zeros(4),
    )


@jax.jit
def _kalman(model: LinearModel, count: Array) -> Uncertainty:
    found: Uncertainty = run(KalmanCovariance(), model, count)[1]
    return found


def variance(model: LinearModel, K: Array) -> Array:
    """P11(+) of a model under gains, ``(N,)``."""
    found: Array = run(GainCovariance(), model, K)[1].P[:, 0, 0]
    return found


_variance = _quickly(variance)


@_quickly
def _riccati(parts: tuple[Array, ...], dt: Array, P0: Array, count: Array) -> Array:
    A, C, W, V = parts
    flow = Flow(riccati_flow(A, C, W, V, dt), P0)
    found: Array = run(RiccatiCovariance(), flow, count)[1]
    return found
