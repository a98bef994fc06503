"""The conventional loop as design problems: fastest decay, least ISE, and in stages."""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import LoopGains, loop_error, van_loan
from objectives import Factors
from studies.ha1981.channel import Channel, Gains, noise_share
from tuner.certificate.solution import Solution
from tuner.problem.constraint import Constraint
from tuner.problem.parameters import Limited, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers.known import Known

WIDEST = 100.0
"""Largest ratio of the other poles' decay rates to the slowest one's."""


class Loop(NamedTuple):
    """A point of the design: decay rate of the slowest pole, and the gains (with K2')."""

    decay: Array
    K1: Array
    K2p: Array
    K3: Array


def fastest_decay(channel: Channel) -> Problem:
    """The paper's design: the slowest pole as fast as the bound on (5)'s noise share allows."""
    eta = channel.eta
    return Problem(
        name="conventional",
        space=Space.of(
            decay=Positive(
                eta, 1e-4 * eta, 1e4 * eta, unit="1/s", meaning="rate a of the slowest pole"
            ),
            spread=Limited(1.0, 0.0, WIDEST, meaning="r of the real pole, -a (1 + r)"),
            damping=Limited(
                1.0,
                0.0,
                WIDEST,
                meaning="d of the other two poles, (s + a)^2 + d a (s + a) + f a^2",
            ),
            stiffness=Limited(1.0, 0.0, WIDEST, meaning="f of the other two poles, as above"),
        ),
        filter=None,
        build=from_factors,
        objective=time_constant,
        constraints=(Constraint("variance", Share(channel.q_a), channel.bound, channel.squared),),
        derive=_gains,
    )


def from_factors(values: dict[str, Array]) -> Loop:
    """Gains from the factors of s^3 + K1 s^2 + K2' s + K3."""
    pairs = [(values["damping"], values["stiffness"])]
    _, K1, K2p, K3 = Factors(3).coefficients(values["decay"], values["spread"], pairs)
    return Loop(values["decay"], K1, K2p, K3)


def time_constant(loop: Loop, _: None) -> Array:
    """Time constant of the slowest pole, s."""
    return 1 / loop.decay


@dataclass(frozen=True)
class Share:
    """The noise's share of (5), which the paper's design bounds."""

    q_a: float

    def __call__(self, loop: Loop, _: None) -> Array:
        """The share, (unit/s^2)^2."""
        return self.q_a * jnp.asarray(noise_share(loop.K1, loop.K2p, loop.K3))


def _gains(values: dict[str, Array]) -> dict[str, Array]:
    return from_factors(values)._asdict()


def closed_form(channel: Channel) -> Known:
    """The solution after (9): a triple pole at -16 eta / 3."""
    found = {"decay": 16 * channel.eta / 3, "spread": 0.0, "damping": 0.0, "stiffness": 0.0}
    return Known("closed form", lambda _: found, "the solution after (9)")


def gains_of(solution: Solution) -> Gains:
    """The loop's gains at a solution."""
    return Gains(*(solution.derived[name] for name in ("K1", "K2p", "K3")))


def least_ise(channel: Channel) -> Problem:
    """Least integral of the squared error within the same bound: an infimum that is not reached."""
    eta = channel.eta
    start = Gains(1.0, 2.0, 1.0).at(eta)
    return Problem(
        name="ise",
        space=Space.of(
            K1=_positive(start.K1, "1/s"),
            K2p=_positive(start.K2p, "1/s^2"),
            K3=_positive(start.K3, "1/s^3"),
        ),
        filter=None,
        build=_as_loop,
        objective=ise_of_step,
        constraints=(Constraint("variance", Share(channel.q_a), channel.bound, channel.squared),),
    )


def _positive(init: float, unit: str) -> Positive:
    return Positive(init, 1e-3 * init, 1e3 * init, unit=unit)


def _as_loop(values: dict[str, Array]) -> Loop:
    return Loop(jnp.ones(()), values["K1"], values["K2p"], values["K3"])


def ise_of_step(loop: Loop, _: None) -> Array:
    """Integral of the unit step's squared error, s, by Parseval's theorem.

    Of (s^2 + K1 s + K2') / (s^3 + K1 s^2 + K2' s + K3), (7) less one step; Newton, Gould and
    Kaiser's table of integrals, n = 3. Infinite where the loop is unstable.
    """
    K1, K2p, K3 = loop.K1, loop.K2p, loop.K3
    margin = K1 * K2p - K3
    area = (K2p * K3 + (K1**2 - 2 * K2p) * K3 + K2p**2 * K1) / (2 * K3 * margin)
    return jnp.where(margin > 0, area, jnp.inf)


class Stages(NamedTuple):
    """Triple poles at -16 eta / 3, one after another.

    Attributes:
        etas: of each stage, 1/s.
        lengths: of each stage, s.
    """

    etas: tuple[Array, ...]
    lengths: tuple[Array, ...]


@dataclass(frozen=True)
class FinalVariance:
    """The bias's variance at the end of the last stage over the Kalman filter's limit q_a / t.

    It evaluates the end alone, which is meaningful only because the poles are tied together.
    """

    channel: Channel

    def __call__(self, stages: Stages, _: None) -> Array:
        """The ratio, at least about 1."""
        c = self.channel
        P = jnp.diag(jnp.array([c.sigma2_ab, 0.0, 0.0, c.sigma2_hr]))
        noise, density = jnp.array([[0.0], [0.0], [1.0], [0.0]]), jnp.array([[c.q_a]])
        for eta, length in zip(*stages, strict=True):
            gains = LoopGains(16 * eta, 256 * eta**2 / 3 + c.k_gh, 4096 * eta**3 / 27)
            step = van_loan(loop_error(gains, c.k_gh), noise, density, length)
            P = step.F @ P @ step.F.T + step.Q
        return P[0, 0] * sum(stages.lengths) / c.q_a


@dataclass(frozen=True)
class _Staged:
    """The map from the space's values to the stages."""

    end: float

    def __call__(self, values: dict[str, Array]) -> Stages:
        if "switch" not in values:
            return Stages((values["eta_1"],), (jnp.asarray(self.end),))
        first = values["switch"]
        return Stages((values["eta_1"], values["eta_2"]), (first, self.end - first))


def staged(channel: Channel, end: float, stages: int) -> Problem:
    """One or two triple poles, chosen for the variance at a given end."""
    eta = channel.eta
    parameters = {"eta_1": Positive(2 * eta, eta, 100 * eta, unit="1/s")}
    if stages == 2:
        parameters["eta_1"] = Positive(10 * eta, eta, 100 * eta, unit="1/s")
        parameters["eta_2"] = Positive(eta, 0.1 * eta, 10 * eta, unit="1/s")
        parameters["switch"] = Positive(end / 5, 1e-2 * end, 0.9 * end, unit="s")
    return Problem(
        name=f"staged_{stages}",
        space=Space.of(**parameters),
        filter=None,
        build=_Staged(end),
        objective=FinalVariance(channel),
    )


def poles(gains: Gains) -> np.ndarray:
    """The loop's poles, 1/s."""
    return np.linalg.eigvals(gains.error)
