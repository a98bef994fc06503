"""Tracking with constant gains: alpha-beta and alpha-beta-gamma."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.declared import Channel, Param
from filters.validate import check_setup

_ALPHA = Param(
    "",
    "share of the difference that the position takes in a sample",
    typical=0.5,
    low=0.0,
    high=1.0,
    smaller="smooths more",
    larger="follows the measurements closer",
    per_sample=True,
)
_BETA = Param(
    "",
    "share of it that the velocity takes, over dt",
    typical=0.1,
    low=0.0,
    high=2.0,
    smaller="lags more when the velocity changes",
    larger="follows faster and overshoots",
    per_sample=True,
)
_Z = {"z": Channel("unit", "measured position")}
_POSITION = Channel("unit", "estimated position; 0 before the first measurement")
_VELOCITY = Channel("unit/s", "estimated velocity")
_ACCELERATION = Channel("unit/s^2", "estimated acceleration")
_INNOVATION = Channel("unit", "measured less predicted; 0 where missing", kind="detail")
_INDEX = Channel("", "tracking index: the ratio q dt^3 / R of like gains, as a square root")


class AlphaBetaGains(NamedTuple):
    """The two gains, ``()`` each; all that 0 < alpha < 1 and 0 < beta < 2 allow are stable."""

    alpha: Annotated[Array, _ALPHA]
    beta: Annotated[Array, _BETA]


class AlphaBetaGammaGains(NamedTuple):
    """The three gains, ``()`` each; stable where gamma < 4 alpha beta / (2 - alpha) too."""

    alpha: Annotated[Array, _ALPHA]
    beta: Annotated[Array, _BETA]
    gamma: Annotated[
        Array,
        Param(
            "",
            "share of it that the acceleration takes, over 2 dt^2",
            typical=0.02,
            low=0.0,
            high=2.0,
            smaller="lags more when the acceleration changes",
            larger="follows faster; unstable from 4 alpha beta / (2 - alpha) on",
            per_sample=True,
        ),
    ]


class Track(NamedTuple):
    """Position, its derivatives ``(n - 1,)``, and whether it has begun, 1 or 0."""

    position: Array
    derivatives: Array
    begun: Array


class AlphaBetaOutputs(NamedTuple):
    """Position and velocity ``()``, and the innovation ``(1,)``."""

    position: Annotated[Array, _POSITION]
    velocity: Annotated[Array, _VELOCITY]
    innovation: Annotated[Array, _INNOVATION]


class AlphaBetaGammaOutputs(NamedTuple):
    """Position, velocity and acceleration ``()``, and the innovation ``(1,)``."""

    position: Annotated[Array, _POSITION]
    velocity: Annotated[Array, _VELOCITY]
    acceleration: Annotated[Array, _ACCELERATION]
    innovation: Annotated[Array, _INNOVATION]


@dataclass(frozen=True)
class AlphaBeta:
    """Constant velocity with constant gains: K = (alpha, beta / dt).

    Stable where 0 < alpha < 2 and 0 < beta < 4 - 2 alpha; with alpha above 1 it overshoots what is
    measured. It begins at rest with the first measurement. It has no variance, so it is tuned by
    an error and not by a likelihood. Source: Bar-Shalom, Li and Kirubarajan 2001, 6.5.

    Attributes:
        dt: sample time, s.

    >>> from filters import run
    >>> gains = AlphaBetaGains(jnp.array(0.5), jnp.array(0.25))
    >>> run(AlphaBeta(dt=1.0), gains, jnp.array([2.0, 4.0]))[1].velocity.tolist()
    [0.0, 0.5]
    """

    dt: float

    params, inputs, outputs = AlphaBetaGains, _Z, AlphaBetaOutputs
    states, derived = (
        {"position": _POSITION, "velocity": _VELOCITY},
        {
            "K": Channel("1, 1/s", "gains on position and velocity, (2,)"),
            "tracking_index": _INDEX,
        },
    )

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: AlphaBetaGains) -> Track:
        """Not begun."""
        return _nothing(params, 1)

    def step(
        self, params: AlphaBetaGains, state: Track, inputs: Array
    ) -> tuple[Track, AlphaBetaOutputs]:
        """Move on, and take the gains' shares of the difference."""
        velocity = state.derivatives[0]
        ahead = state.position + self.dt * velocity
        y, first = _innovation(state, ahead, inputs)
        after = Track(
            ahead + params.alpha * y + first,
            (velocity + params.beta / self.dt * y)[None],
            jnp.maximum(state.begun, ~jnp.isnan(inputs)),
        )
        return after, AlphaBetaOutputs(after.position, after.derivatives[0], y[None])

    def derive(self, params: AlphaBetaGains) -> dict[str, Array]:
        """The gains with their units, and beta / sqrt(1 - alpha), Kalata's tracking index.

        It is sqrt(q dt^3 / R) of :class:`filters.ConstantVelocity` where beta fits alpha.
        """
        index = params.beta / jnp.sqrt(1 - params.alpha)
        return {"K": jnp.stack([params.alpha, params.beta / self.dt]), "tracking_index": index}


@dataclass(frozen=True)
class AlphaBetaGamma:
    """Constant acceleration with constant gains: K = (alpha, beta / dt, gamma / (2 dt^2)).

    Stable where 0 < alpha < 2, 0 < beta < 4 - 2 alpha and 0 < gamma < 4 alpha beta / (2 - alpha).
    Other authors write gamma for half or twice this one. It begins at rest with the first
    measurement. Source: Kalata, IEEE Trans. Aerospace and Electronic Systems 20(2), 1984; Tenne and
    Singh, same journal 38(3), 2002 (stability).

    Attributes:
        dt: sample time, s.

    >>> from filters import run
    >>> gains = AlphaBetaGammaGains(jnp.array(0.5), jnp.array(0.25), jnp.array(0.125))
    >>> run(AlphaBetaGamma(dt=1.0), gains, jnp.array([2.0, 4.0]))[1].acceleration.tolist()
    [0.0, 0.125]
    """

    dt: float

    params, inputs, outputs = AlphaBetaGammaGains, _Z, AlphaBetaGammaOutputs
    states, derived = (
        {"position": _POSITION, "velocity": _VELOCITY, "acceleration": _ACCELERATION},
        {"K": Channel("1, 1/s, 1/s^2", "gains on position and its derivatives, (3,)")},
    )

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: AlphaBetaGammaGains) -> Track:
        """Not begun."""
        return _nothing(params, 2)

    def step(
        self, params: AlphaBetaGammaGains, state: Track, inputs: Array
    ) -> tuple[Track, AlphaBetaGammaOutputs]:
        """Move on, and take the gains' shares of the difference."""
        velocity, acceleration = state.derivatives[0], state.derivatives[1]
        ahead = state.position + self.dt * velocity + self.dt**2 / 2 * acceleration
        y, first = _innovation(state, ahead, inputs)
        position = ahead + params.alpha * y + first
        velocity = velocity + self.dt * acceleration + params.beta / self.dt * y
        acceleration = acceleration + params.gamma / (2 * self.dt**2) * y
        begun = jnp.maximum(state.begun, ~jnp.isnan(inputs))
        after = Track(position, jnp.stack([velocity, acceleration]), begun)
        return after, AlphaBetaGammaOutputs(position, velocity, acceleration, y[None])

    def derive(self, params: AlphaBetaGammaGains) -> dict[str, Array]:
        """The gains with their units."""
        rates = [params.alpha, params.beta / self.dt, params.gamma / (2 * self.dt**2)]
        return {"K": jnp.stack(rates)}


def _nothing(params: AlphaBetaGains | AlphaBetaGammaGains, derivatives: int) -> Track:
    zero = jnp.zeros((), jnp.result_type(*params))
    return Track(zero, jnp.zeros(derivatives, zero.dtype), zero)


def _innovation(state: Track, ahead: Array, z: Array) -> tuple[Array, Array]:
    """The innovation and the first measurement, each 0 where there is none."""
    seen, begun = ~jnp.isnan(z), state.begun > 0
    y = jnp.where(seen & begun, z - ahead, 0.0)
    return y, jnp.where(seen & ~begun, z, 0.0)
