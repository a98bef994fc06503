"""The Kalman scheme: steady gains, stored gains, and their cost with a wrong model."""

from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import GainTable, TableCovariance
from objectives import Data, LinearSystem, VarianceRatio, steady_kalman
from studies.ha1981 import paper
from studies.ha1981.channel import (
    ERRORS,
    MEASURED,
    QUICKLY,
    Channel,
    History,
    kalman_history,
    lengthened,
    model_of,
    replayed,
    times,
    variance,
)
from tuner.problem.parameters import Limited, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers.known import Known

LONGEST = 1e6
"""Samples of the longest history that is searched."""
TARGETS = ("bias", "velocity", "altitude")
"""The quantities corrected by the three gains."""
OF_GAINS = ("1/s^2", "1/s", "")
"""Their units."""
REPLAY = 2.5
"""The other sampling period, s, at which stored gains are replayed."""


def steady_system(channel: Channel, Ts: float) -> LinearSystem:
    """The channel at a sampling period without its bias, which is not driven and needs no gain."""
    move = channel.model(Ts).transition
    F, Q = (np.asarray(part)[1:, 1:] for part in (move.F, move.Q))
    return LinearSystem(F, MEASURED[:, 1:], Q, [[channel.q_b]], dt=Ts, states=ERRORS[1:])


def steady_gains(channel: Channel, Ts: float) -> np.ndarray:
    """K2 and K3 in the steady state, by the Riccati equation, ``(2,)``."""
    return steady_kalman(steady_system(channel, Ts)).gain[:, 0]


def steady(channel: Channel, Ts: float) -> Problem:
    """K2 and K3 for the least steady variance of the velocity error, before a measurement."""
    guess = paper.steady_gains(channel.q_a, channel.q_b, Ts)
    return Problem(
        name="kalman_steady",
        space=Space.of(
            K2=Limited(0.5 * guess.K2, 0.0, 2 / Ts, unit="1/s", scale=guess.K2),
            K3=Limited(0.5 * guess.K3, 0.0, 1.0, scale=guess.K3),
        ),
        filter=None,
        build=_steady_gain,
        objective=VelocityVariance(steady_system(channel, Ts)),
    )


def _steady_gain(values: dict[str, Array]) -> Array:
    """K on a measurement, ``(2, 1)``."""
    return jnp.stack([values["K2"], values["K3"]])[:, None]


@dataclass(frozen=True, eq=False)
class VelocityVariance:
    """Steady variance of dV before a measurement, under a gain that stays as it is."""

    system: LinearSystem

    def __call__(self, K: Array, _: None) -> Array:
        """The variance, (unit/s)^2; NaN where the gain is unstable."""
        return self.system.steady(jnp.asarray(self.system.A) @ K)[0, 0]


def riccati_gains(channel: Channel, Ts: float) -> Known:
    """The steady problem's solution by the Riccati equation."""
    K2, K3 = steady_gains(channel, Ts)
    return Known("riccati", lambda _: {"K2": K2, "K3": K3}, "the Riccati equation's solution")


def printed_gains(channel: Channel, Ts: float) -> Known:
    """The steady problem's solution by the paper's closed forms."""
    found = paper.steady_gains(channel.q_a, channel.q_b, Ts)
    return Known("closed form", lambda _: {"K2": found.K2, "K3": found.K3}, "the paper's formulas")


@dataclass(frozen=True, eq=False)
class Storage:
    """Gains of the whole history, to be stored as a few that are held for a while.

    Attributes:
        channel: the channel.
        Ts: sampling period, s.
        optimal: covariances and gains of the Kalman filter, one a sample up to the bound.
        edges: first sample of every stored gain, and the number of samples; the first sample, in
            which the altitude alone is corrected, has its own.
    """

    channel: Channel
    Ts: float
    optimal: History
    edges: tuple[int, ...]

    @classmethod
    def of(cls, channel: Channel, Ts: float, segments: int) -> "Storage":
        """As many segments as asked for, each about twice as long as the one before."""
        end = reaches(channel, Ts)
        history = kalman_history(channel, Ts, end)
        samples = len(history.P)
        segments = min(segments, samples - 1)
        inner = np.geomspace(1, samples, segments + 1)
        edges = [0, 1]
        for edge in inner[1:]:
            edges.append(max(edges[-1] + 1, round(edge)))
        return cls(channel, Ts, history, (*edges[:-1], samples))

    @property
    def which(self) -> np.ndarray:
        """The number of the gain of every sample, ``(N,)``."""
        return np.repeat(np.arange(len(self.edges) - 1), np.diff(self.edges))

    @property
    def means(self) -> np.ndarray:
        """The mean gain of every segment, ``(M + 1, 3)``."""
        K = np.asarray(self.optimal.K)[:, :, 0]
        pairs = zip(self.edges, self.edges[1:], strict=False)
        return np.array([K[a:b].mean(axis=0) for a, b in pairs])

    def problem(self) -> Problem:
        """The stored gains whose variance stays nearest to the Kalman filter's."""
        means = self.means
        parameters = {
            f"K{i + 1}_{s}": Positive(
                means[s, i],
                1e-2 * means[s, i],
                1e2 * means[s, i],
                unit=OF_GAINS[i],
                meaning=f"on the {TARGETS[i]} of the stored gains' row {s}",
            )
            for s in range(1, len(means))
            for i in range(3)
        }
        reference = np.asarray(self.optimal.P)[:, 0, 0].copy()
        reference[0] = np.nan  # the bias is unknown before a second measurement
        return Problem(
            name="kalman_stored",
            space=Space.of(**parameters),
            filter=TableCovariance(),
            build=_Stored(self, len(means)),
            objective=VarianceRatio(state=0, samples=len(reference) - 1),
            data=Data(self.which, reference),
        )

    def table(self, values: dict[str, Array]) -> Array:
        """The gains as a table, ``(M + 1, 3, 1)``; the first is the Kalman filter's."""
        rows = [jnp.asarray(self.optimal.K[0, :, 0])]
        for s in range(1, len(self.edges) - 1):
            rows.append(jnp.stack([jnp.asarray(values[f"K{i}_{s}"]) for i in (1, 2, 3)]))
        return jnp.stack(rows)[:, :, None]


@dataclass(frozen=True, eq=False)
class _Stored:
    """The map from the space's values to a table of gains."""

    storage: Storage
    rows: int

    def __call__(self, values: dict[str, Array]) -> GainTable:
        storage = self.storage
        return GainTable(storage.channel.model(storage.Ts), storage.table(values))


def reaches(channel: Channel, Ts: float) -> float:
    """Time at which P11(+) first meets the bound, s: the end of the scheme's operation.

    Raises:
        ValueError: where it has not within a thousand times q_a over the bound, or a million
            samples.
    """
    limit = channel.q_a / channel.bound  # P11 tends to q_a / t
    for factor in (1.5, 10.0, 1000.0):
        if factor * limit / Ts > LONGEST:
            break
        P11 = np.asarray(kalman_history(channel, Ts, factor * limit + 2 * Ts).P)[:, 0, 0]
        below = np.flatnonzero(channel.bound >= P11)
        if below.size:
            return float(below[0] * Ts)
    raise ValueError(
        f"the Kalman scheme does not bring the bias's variance below {channel.bound:g} within "
        f"{min(1000 * limit, LONGEST * Ts):g} s; choose a wider bound"
    )


def sensitivities(channel: Channel, Ts: float, seconds: float) -> dict[str, np.ndarray]:
    """d ln P11(t) / d ln p by (19) with the gains held, for p = q_a, q_b, sigma^2_AB; ``(N,)``."""
    gains = kalman_history(channel, Ts, seconds).K
    slopes = np.asarray(_sensitivities(channel, Ts, lengthened(gains)))[: len(gains)]
    return {name: slopes[:, i] for i, name in enumerate(_UNCERTAIN)}


_UNCERTAIN = ("q_a", "q_b", "sigma2_ab")


@jax.jit(static_argnums=(0, 1), compiler_options=QUICKLY)
def _sensitivities(channel: Channel, Ts: float, gains: Array) -> Array:
    def logarithm(logs: Array) -> Array:
        numbers = {n: getattr(channel, n) * jnp.exp(logs[i]) for i, n in enumerate(_UNCERTAIN)}
        return jnp.log(variance(model_of(replace(channel, **numbers).numbers, Ts), gains))

    slopes: Array = jax.jacfwd(logarithm)(jnp.zeros(3))
    return slopes


def replay(channel: Channel, Ts: float, seconds: float, *, by: str) -> np.ndarray:
    """P11 where gains of Ts are applied every :data:`REPLAY` s, over that of its own design.

    Args:
        channel: the channel.
        Ts: sampling period of the gains, s.
        seconds: duration.
        by: "sample": the k-th gain at the k-th sample; "time": the gain of the same time.
    """
    own = kalman_history(channel, REPLAY, seconds)
    at = times(seconds, REPLAY)
    index = np.arange(len(at)) if by == "sample" else np.floor(at / Ts + 1e-9).astype(int)
    gains = kalman_history(channel, Ts, (index[-1] + 1) * Ts).K[index]
    ratio: np.ndarray = replayed(channel.model(REPLAY), gains) / own.P[:, 0, 0]
    return ratio
