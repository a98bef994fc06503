"""The vertical channel: height and climb from a barometer and an accelerometer with an offset."""

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple, TypeAlias

import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.typing import ArrayLike

from filters.declared import Channel, Param
from filters.integrators import (
    Chain,
    Upper,
    add,
    begin,
    full,
    integration,
    measure,
    move,
    steady_gain,
)
from filters.integrators import white_noise as noise
from filters.linear import LinearForm, Measured, Transition
from filters.validate import check_setup

Gravity: TypeAlias = Literal["removed", "included"]
G = 9.80665  # m/s^2, standard gravity
_HEIGHT = Channel("m", "estimated height, of the barometer; 0 before its first sample")
_CLIMB = Channel("m/s", "estimated speed upwards")
_BIAS = Channel("m/s^2", "estimated offset of the measured acceleration")


class VerticalNoise(NamedTuple):
    """Parameters of the vertical channel, ``()`` each."""

    q_acc: Annotated[
        Array,
        Param(
            "m^2/s^3",
            "spectral density of the acceleration's white noise: its variance times dt",
            typical=0.01,
            low=1e-8,
            high=1e3,
            smaller="trusts the accelerometer",
            larger="follows the barometer",
            sensor="accelerometer",
        ),
    ]
    q_bias: Annotated[
        Array,
        Param(
            "m^2/s^5",
            "by how much the variance of the offset grows in a second: a random walk",
            typical=1e-4,
            low=1e-12,
            high=1.0,
            smaller="keeps the offset once found",
            larger="lets it wander",
            sensor="accelerometer bias",
        ),
    ]
    R_baro: Annotated[
        Array,
        Param(
            "m^2",
            "variance of the barometer's height",
            typical=0.1,
            low=1e-6,
            high=1e4,
            smaller="follows the barometer",
            larger="smooths its noise more",
        ),
    ]
    climb0: Annotated[
        ArrayLike, Param("m/s", "deviation of the climb at the start, from 0", typical=1.0)
    ] = 1.0
    bias0: Annotated[
        ArrayLike, Param("m/s^2", "deviation of the offset at the start, from 0", typical=1.0)
    ] = 1.0


class VerticalSample(NamedTuple):
    """One sample, ``()`` each; NaN means missing: a missing acceleration keeps its last value."""

    acc: Annotated[Array, Channel("m/s^2", "acceleration upwards, with or without gravity")]
    baro: Annotated[Array, Channel("m", "height by the barometer")]


class VerticalState(NamedTuple):
    """Height, climb and the negative offset, and the last acceleration, m/s^2, ``()``."""

    chain: Chain
    acc: Array


class VerticalOutputs(NamedTuple):
    """Height, climb and offset ``()``, innovation and its variance ``(1,)``."""

    height: Annotated[Array, _HEIGHT]
    climb: Annotated[Array, _CLIMB]
    bias: Annotated[Array, _BIAS]
    innovation: Annotated[
        Array, Channel("m", "measured less predicted height; 0 where missing", kind="detail")
    ]
    variance: Annotated[
        Array, Channel("m^2", "of the innovation; 0 where it does not count", kind="detail")
    ]


@dataclass(frozen=True)
class Vertical:
    """The accelerometer moves height and climb, the barometer corrects them and its offset.

    The acceleration of a sample holds until the next one. The filter begins with the first height,
    which does not count (variance 0), at rest and without offset but for ``climb0`` and ``bias0``.
    Source: the three-state loop of Ha, Kim and Choi 1981 with a Kalman filter's gains and white
    noise on the acceleration.

    Attributes:
        dt: sample time, s.
        gravity: whether 9.80665 m/s^2 have been removed from the acceleration; where it is
            included, it is taken off here.

    >>> from filters import run
    >>> noise = VerticalNoise(*map(jnp.array, (0.01, 1e-4, 0.1)))
    >>> record = VerticalSample(acc=jnp.array([0.5, jnp.nan]), baro=jnp.array([300.0, jnp.nan]))
    >>> outputs = run(Vertical(dt=0.5), noise, record)[1]
    >>> outputs.height.tolist(), outputs.climb.tolist()
    ([300.0, 300.0625], [0.0, 0.25])
    """

    dt: float
    gravity: Gravity = "removed"

    params, inputs, outputs = VerticalNoise, VerticalSample, VerticalOutputs
    states, derived = (
        {"height": _HEIGHT, "climb": _CLIMB, "bias": _BIAS},
        {
            "Q": Channel("m^2 .. m^2/s^4", "covariance that enters in a sample, (3, 3)"),
            "K": Channel("1, 1/s, 1/s^2", "steady gains, a height with every sample, (3,)"),
            "L": Channel("1, 1/s, 1/s^2", "the same moved on by a sample, F K, (3,)"),
        },
    )

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: VerticalNoise) -> VerticalState:
        """At rest, at any height."""
        still = jnp.zeros((), jnp.result_type(*params))
        climb, bias = (jnp.square(d) / params.R_baro for d in (params.climb0, params.bias0))
        return VerticalState(begin(still, ((0.0, 0.0, 0.0), (climb, 0.0), (bias,)), 1), still)

    def step(
        self, params: VerticalNoise, state: VerticalState, inputs: VerticalSample
    ) -> tuple[VerticalState, VerticalOutputs]:
        """Move by the last acceleration, take the height, and keep the new acceleration."""
        chain = move(state.chain, self._noise(params, params.R_baro), self.dt)
        push = jnp.where(chain.known > 0, state.acc, 0.0) * self.dt
        height, climb, other = chain.x
        chain = chain._replace(x=(height + push * self.dt / 2, climb + push, other))
        chain, taken = measure(chain, inputs.baro, 1.0, 1)
        acc = jnp.where(jnp.isnan(inputs.acc), state.acc, inputs.acc - self._pull())
        height, climb, other = chain.x
        variance = (params.R_baro * taken.variance)[None]
        outputs = VerticalOutputs(height, climb, -other, taken.innovation[None], variance)
        return VerticalState(chain, acc), outputs

    def linear(self, params: VerticalNoise) -> LinearForm:
        """The model whose Kalman filter this is: height, climb and the negative offset."""
        Q, dt = full(self._noise(params, 1.0)), jnp.asarray(self.dt)
        push = jnp.stack([dt**2 / 2, dt, jnp.zeros_like(dt)])[:, None]
        step = Transition(integration(3, dt), jnp.eye(3), Q, push)
        return LinearForm(step, jnp.eye(1, 3), jnp.reshape(params.R_baro, (1,)))

    def measured(self, inputs: VerticalSample) -> Measured:
        """The heights of a whole record, ``(N, 1)``, and the acceleration before each."""
        acc = np.asarray(inputs.acc)
        last = np.maximum.accumulate(np.where(np.isnan(acc), -1, np.arange(len(acc))))
        held = np.where(last < 0, 0.0, acc[last] - self._pull())
        before = np.concatenate([np.zeros(1), held[:-1]])
        return Measured(np.asarray(inputs.baro)[:, None], before[:, None])

    def derive(self, params: VerticalNoise) -> dict[str, Array]:
        """The covariance per sample and the steady gains, from the Riccati equation."""
        K = steady_gain(full(self._noise(params, params.R_baro)), self.dt)
        Q = full(self._noise(params, 1.0))
        turned = jnp.array([1.0, 1.0, -1.0], Q.dtype)
        ahead = integration(3, jnp.asarray(self.dt)) @ K
        return {"Q": Q * jnp.outer(turned, turned), "K": K * turned, "L": ahead * turned}

    def _pull(self) -> float:
        return G if self.gravity == "included" else 0.0

    def _noise(self, params: VerticalNoise, unit: float | Array) -> Upper:
        white = noise(3, 2, params.q_acc / unit, self.dt)
        return add(white, noise(3, 3, params.q_bias / unit, self.dt))
