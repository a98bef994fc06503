"""The local level: a number that wanders, measured with noise; a Kalman filter of one state."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters.declared import Channel, Param
from filters.linear import LinearForm, Measured, Transition
from filters.validate import check_setup

_LEVEL = Channel("unit", "estimated level; 0 before the first measurement")


class LocalLevelNoise(NamedTuple):
    """Parameters of the local level, ``()`` each."""

    q: Annotated[
        Array,
        Param(
            "unit^2/s",
            "by how much the level's variance grows in a second: a random walk",
            typical=1.0,
            low=1e-10,
            high=1e10,
            smaller="smooths more and lags more",
            larger="follows faster",
        ),
    ]
    R: Annotated[
        Array,
        Param(
            "unit^2",
            "variance of a measurement; where sigma is given, a factor without unit on sigma^2",
            typical=1.0,
            low=1e-10,
            high=1e10,
            smaller="follows the measurements closer",
            larger="smooths more and lags more",
        ),
    ]


class LevelSample(NamedTuple):
    """A measurement, ``()``; NaN means missing.

    Attributes:
        z: the measurement.
        sigma: its own deviation, in its unit, or None; where it is not positive z is missing.
    """

    z: Annotated[Array, Channel("unit", "measured level")]
    sigma: Annotated[Array | None, Channel("unit", "deviation of this measurement")] = None


class LevelState(NamedTuple):
    """The level, the variance of its error over R, and whether it is known at all, 1 or 0."""

    level: Array
    p: Array
    known: Array


class LocalLevelOutputs(NamedTuple):
    """The level ``()``, innovation and its variance ``(1,)``."""

    level: Annotated[Array, _LEVEL]
    innovation: Annotated[
        Array, Channel("unit", "measured less predicted; 0 where missing", kind="detail")
    ]
    variance: Annotated[
        Array, Channel("unit^2", "of the innovation; 0 where it does not count", kind="detail")
    ]


@dataclass(frozen=True)
class LocalLevel:
    """The Kalman filter of a random walk: exponential smoothing with the gain that fits the noise.

    It begins with its first measurement, which is its level from then on and does not count
    (variance 0): a diffuse start, exactly. Source: Harvey, Forecasting, Structural Time Series
    Models and the Kalman Filter, 1989, 4.1.2.

    Attributes:
        dt: sample time, s.

    >>> from filters import run
    >>> record = LevelSample(jnp.array([8.0, jnp.nan, 9.0]))
    >>> run(LocalLevel(dt=1.0), LocalLevelNoise(jnp.array(0.5), jnp.array(1.0)), record)[1].level
    Array([8.        , 8.        , 8.66666667], dtype=float64)
    """

    dt: float

    params, inputs, outputs = LocalLevelNoise, LevelSample, LocalLevelOutputs
    states, derived = (
        {"level": _LEVEL},
        {
            "Q": Channel("unit^2", "variance that the level gains in a sample"),
            "K": Channel("", "steady gain on a measurement"),
        },
    )

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: LocalLevelNoise) -> LevelState:
        """The start, of which nothing is known."""
        nothing = jnp.zeros((), jnp.result_type(params.q, params.R))
        return LevelState(nothing, nothing, nothing)

    def step(
        self, params: LocalLevelNoise, state: LevelState, inputs: LevelSample
    ) -> tuple[LevelState, LocalLevelOutputs]:
        """Let the variance grow, and go the gain's share of the way to the measurement."""
        known = state.known > 0
        sigma = jnp.ones_like(inputs.z) if inputs.sigma is None else inputs.sigma
        seen = ~jnp.isnan(inputs.z) & (sigma > 0)
        r = jnp.where(seen, sigma, 1.0) ** 2
        p = state.p + params.q * self.dt / params.R
        K = jnp.where(known, p / (p + r), 1.0)
        y = jnp.where(seen, inputs.z - state.level, 0.0)
        level = state.level + K * y
        counts = seen & known
        variance = jnp.where(counts, params.R * (p + r), 0.0)
        state = LevelState(level, jnp.where(seen, K * r, p), jnp.maximum(state.known, seen))
        return state, LocalLevelOutputs(level, jnp.where(counts, y, 0.0)[None], variance[None])

    def linear(self, params: LocalLevelNoise) -> LinearForm:
        """The random walk whose Kalman filter this is."""
        one = jnp.ones((1, 1))
        step = Transition(one, one, jnp.reshape(params.q * self.dt, (1, 1)))
        return LinearForm(step, one, jnp.reshape(params.R, (1,)))

    def measured(self, inputs: LevelSample) -> Measured:
        """The measurements of a whole record, ``(N, 1)``, with their deviations."""
        sigma = None if inputs.sigma is None else np.asarray(inputs.sigma)[:, None]
        return Measured(np.asarray(inputs.z)[:, None], sigma=sigma)

    def derive(self, params: LocalLevelNoise) -> dict[str, Array]:
        """Q = q dt, and the steady gain, K^2 / (1 - K) = Q/R solved without cancellation.

        >>> round(float(LocalLevel(dt=0.5).derive(LocalLevelNoise(1.0, 1.0))["K"]), 12)
        0.5
        """
        Q = jnp.asarray(params.q * self.dt)
        root = jnp.sqrt(Q / params.R)
        return {"Q": Q, "K": 2 * root / (root + jnp.sqrt(Q / params.R + 4))}
