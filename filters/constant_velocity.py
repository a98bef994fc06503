"""Tracking by position: constant velocity and constant acceleration, along one to three axes."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal, NamedTuple, TypeAlias

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters.declared import Channel, Param
from filters.integrators import (
    Chain,
    Upper,
    begin,
    full,
    integration,
    measure,
    move,
    steady_gain,
    unknown,
)
from filters.integrators import white_noise as noise
from filters.linear import LinearForm, Measured, Transition
from filters.validate import check_setup

Axes: TypeAlias = Literal["x", "xy", "xyz"]

_R = Param(
    "unit^2",
    "variance of a measured position; where sigma is given, a factor without unit on sigma^2",
    typical=1.0,
    low=1e-10,
    high=1e10,
    smaller="follows the measurements closer",
    larger="smooths more and lags more",
)
_NAMES = ("x", "y", "z")
_POSITION = Channel("unit", "estimated position, of the axes given", axes=_NAMES)
_VELOCITY = Channel("unit/s", "estimated velocity; 0 before two measurements", axes=_NAMES)
_ACCELERATION = Channel("unit/s^2", "estimated acceleration; 0 before three", axes=_NAMES)
_INNOVATION = Channel("unit", "measured less predicted; 0 where missing", _NAMES, "detail")
_VARIANCE = Channel("unit^2", "of the innovation; 0 where it does not count", _NAMES, "detail")


class ConstantVelocityNoise(NamedTuple):
    """Parameters of constant velocity, ``()`` each; all axes share them."""

    q: Annotated[
        Array,
        Param(
            "unit^2/s^3",
            "spectral density of the acceleration, a white noise",
            typical=1.0,
            low=1e-10,
            high=1e10,
            smaller="trusts a straight course, lags in turns",
            larger="turns faster, and is less smooth",
        ),
    ]
    R: Annotated[Array, _R]


class ConstantAccelerationNoise(NamedTuple):
    """Parameters of constant acceleration, ``()`` each; all axes share them."""

    q: Annotated[
        Array,
        Param(
            "unit^2/s^5",
            "spectral density of the jerk, a white noise",
            typical=1.0,
            low=1e-10,
            high=1e10,
            smaller="trusts a constant acceleration",
            larger="follows changes of it faster, and is less smooth",
        ),
    ]
    R: Annotated[Array, _R]


class PositionSample(NamedTuple):
    """Measured positions, ``()`` each; NaN means missing.

    Attributes:
        x: along the first axis.
        y: along the second, or None.
        z: along the third, or None.
        sigma: the deviation of this sample's measurements, in their unit, or None; where it is not
            positive they are missing.
    """

    x: Annotated[Array, Channel("unit", "measured position, first axis")]
    y: Annotated[Array | None, Channel("unit", "measured position, second axis")] = None
    z: Annotated[Array | None, Channel("unit", "measured position, third axis")] = None
    sigma: Annotated[Array | None, Channel("unit", "deviation of this sample's positions")] = None


class ConstantVelocityOutputs(NamedTuple):
    """Position, velocity, innovation and its variance; of k axes ``(k,)`` each."""

    position: Annotated[Array, _POSITION]
    velocity: Annotated[Array, _VELOCITY]
    innovation: Annotated[Array, _INNOVATION]
    variance: Annotated[Array, _VARIANCE]


class ConstantAccelerationOutputs(NamedTuple):
    """Position and its derivatives, innovation and its variance; ``(k,)`` each."""

    position: Annotated[Array, _POSITION]
    velocity: Annotated[Array, _VELOCITY]
    acceleration: Annotated[Array, _ACCELERATION]
    innovation: Annotated[Array, _INNOVATION]
    variance: Annotated[Array, _VARIANCE]


@dataclass(frozen=True)
class ConstantVelocity:
    """The Kalman filter for a velocity that only white noise changes, of density q on every axis.

    From a step dt to the next x' = x + dt v, with noise of the covariance
    q [[dt^3/3, dt^2/2], [dt^2/2, dt]]: exact for every dt. Nothing is assumed of the start: two
    measurements of every axis are used up for it, and do not count (variance 0). Source:
    Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001,
    6.2.2.

    Attributes:
        dt: sample time, s.
        axes: which positions the samples hold.

    >>> from filters import run
    >>> straight = PositionSample(jnp.array([2.0, 5.0, jnp.nan, 11.0]))
    >>> noise = ConstantVelocityNoise(q=jnp.array(0.5), R=jnp.array(4.0))
    >>> outputs = run(ConstantVelocity(dt=1.0), noise, straight)[1]
    >>> outputs.position[:, 0].tolist(), outputs.velocity[:, 0].tolist()
    ([2.0, 5.0, 8.0, 11.0], [0.0, 3.0, 3.0, 3.0])
    """

    dt: float
    axes: Axes = "x"

    params, inputs, outputs = ConstantVelocityNoise, PositionSample, ConstantVelocityOutputs
    states, derived = (
        {"position": _POSITION, "velocity": _VELOCITY},
        {
            "Q": Channel(
                "unit^2, unit^2/s, unit^2/s^2", "covariance that enters in a sample, (2, 2)"
            ),
            "K": Channel("1, 1/s", "steady gains on position and velocity, (2,)"),
        },
    )

    def __post_init__(self) -> None:
        check_setup(self)

    def given(self, channels: frozenset[str]) -> "ConstantVelocity":
        """This filter for the axes whose channels are there."""
        return replace(self, axes=_axes(channels))

    def init(self, params: ConstantVelocityNoise) -> tuple[Chain, ...]:
        """The start, of which nothing is known."""
        return _nothing(self.axes, params, 2)

    def step(
        self, params: ConstantVelocityNoise, state: tuple[Chain, ...], inputs: PositionSample
    ) -> tuple[tuple[Chain, ...], ConstantVelocityOutputs]:
        """Move on, and take the positions."""
        Q = noise(2, 2, params.q / params.R, self.dt)
        state, found = _stepped(state, Q, params.R, self.dt, inputs)
        return state, ConstantVelocityOutputs(*found)

    def linear(self, params: ConstantVelocityNoise) -> LinearForm:
        """The model whose Kalman filter this is, one axis after the other."""
        return _linear(len(self.axes), full(noise(2, 2, params.q, self.dt)), params.R, self.dt)

    def measured(self, inputs: PositionSample) -> Measured:
        """The positions of a whole record, ``(N, k)``, with their deviations."""
        return _measured(inputs)

    def derive(self, params: ConstantVelocityNoise) -> dict[str, Array]:
        """The covariance per sample, and the steady gains in closed form.

        With L = q dt^3 / R the predicted error's spectrum is that of a second-order filter, whose
        values at frequency 0 and at half the sample rate give both gains.

        >>> ConstantVelocity(2.0).derive(ConstantVelocityNoise(6.0, 100.0))["K"].round(6).tolist()
        [0.691769, 0.192322]
        """
        root = jnp.sqrt(params.q * self.dt**3 / params.R)
        edge = jnp.sqrt(16 + root**2 / 3)
        c = (root + edge) / 2  # u + 1/u, where 1 - K1 = 1/u^2
        d = jnp.sqrt(root * (2 * root / 3 + edge) / 2)  # u - 1/u, nothing subtracted
        u = (c + d) / 2
        Q = full(noise(2, 2, params.q, self.dt))
        return {"Q": Q, "K": jnp.stack([d / u, root / u / self.dt])}


@dataclass(frozen=True)
class ConstantAcceleration:
    """The Kalman filter for an acceleration that only white noise changes, of density q per axis.

    As :class:`ConstantVelocity` with one more derivative: three measurements of every axis are
    used up for the start. Source: Bar-Shalom, Li and Kirubarajan 2001, 6.2.3.

    Attributes:
        dt: sample time, s.
        axes: which positions the samples hold.

    >>> from filters import run
    >>> thrown = PositionSample(jnp.array([0.0, 1.0, 4.0, 9.0, 16.0]))
    >>> noise = ConstantAccelerationNoise(q=jnp.array(0.5), R=jnp.array(4.0))
    >>> run(ConstantAcceleration(dt=1.0), noise, thrown)[1].acceleration[:, 0].tolist()
    [0.0, 0.0, 2.0, 2.0, 2.0]
    """

    dt: float
    axes: Axes = "x"

    params, inputs, outputs = ConstantAccelerationNoise, PositionSample, ConstantAccelerationOutputs
    states, derived = (
        {"position": _POSITION, "velocity": _VELOCITY, "acceleration": _ACCELERATION},
        {
            "Q": Channel("unit^2 .. unit^2/s^4", "covariance that enters in a sample, (3, 3)"),
            "K": Channel("1, 1/s, 1/s^2", "steady gains on position and its derivatives, (3,)"),
        },
    )

    def __post_init__(self) -> None:
        check_setup(self)

    def given(self, channels: frozenset[str]) -> "ConstantAcceleration":
        """This filter for the axes whose channels are there."""
        return replace(self, axes=_axes(channels))

    def init(self, params: ConstantAccelerationNoise) -> tuple[Chain, ...]:
        """The start, of which nothing is known."""
        return _nothing(self.axes, params, 3)

    def step(
        self, params: ConstantAccelerationNoise, state: tuple[Chain, ...], inputs: PositionSample
    ) -> tuple[tuple[Chain, ...], ConstantAccelerationOutputs]:
        """Move on, and take the positions."""
        Q = noise(3, 3, params.q / params.R, self.dt)
        state, found = _stepped(state, Q, params.R, self.dt, inputs)
        return state, ConstantAccelerationOutputs(*found)

    def linear(self, params: ConstantAccelerationNoise) -> LinearForm:
        """The model whose Kalman filter this is, one axis after the other."""
        return _linear(len(self.axes), full(noise(3, 3, params.q, self.dt)), params.R, self.dt)

    def measured(self, inputs: PositionSample) -> Measured:
        """The positions of a whole record, ``(N, k)``, with their deviations."""
        return _measured(inputs)

    def derive(self, params: ConstantAccelerationNoise) -> dict[str, Array]:
        """The covariance per sample, and the steady gains from the Riccati equation."""
        Q = full(noise(3, 3, jnp.asarray(params.q), self.dt))
        return {"Q": Q, "K": steady_gain(Q / params.R, self.dt)}


def _linear(axes: int, Q: Array, R: Array, dt: float) -> LinearForm:
    n, each = len(Q), jnp.eye(axes)
    step = Transition(jnp.kron(each, integration(n, dt)), jnp.eye(axes * n), jnp.kron(each, Q))
    return LinearForm(step, jnp.kron(each, jnp.eye(1, n)), jnp.broadcast_to(R, (axes,)))


def _measured(inputs: PositionSample) -> Measured:
    given = [part for part in (inputs.x, inputs.y, inputs.z) if part is not None]
    z = np.stack([np.asarray(part) for part in given], axis=-1)
    own = None if inputs.sigma is None else np.asarray(inputs.sigma)[:, None]
    sigma = None if own is None else np.broadcast_to(own, z.shape)
    return Measured(z, sigma=sigma)


def _axes(channels: frozenset[str]) -> Axes:
    words: dict[frozenset[str], Axes] = {
        frozenset("x"): "x",
        frozenset("xy"): "xy",
        frozenset("xyz"): "xyz",
    }
    found = channels & set("xyz")
    if found not in words:
        raise ValueError(
            f"positions are given along {', '.join(sorted(found)) or 'no axis'}; name the first "
            "one x, the second y and the third z"
        )
    return words[found]


def _nothing(
    axes: Axes, params: ConstantVelocityNoise | ConstantAccelerationNoise, n: int
) -> tuple[Chain, ...]:
    still = jnp.zeros((), jnp.result_type(params.q, params.R))
    return (begin(still, unknown(n), n),) * len(axes)


def _stepped(
    state: tuple[Chain, ...], Q: Upper, R: Array, dt: float, inputs: PositionSample
) -> tuple[tuple[Chain, ...], list[Array]]:
    """Every axis by itself: written out, which compiles to faster code than arrays of axes."""
    positions = _positions(state, inputs)
    sigma = 1.0 if inputs.sigma is None else inputs.sigma
    each = [
        measure(move(chain, Q, dt), z, sigma, len(chain.x))
        for chain, z in zip(state, positions, strict=True)
    ]
    chains = tuple(chain for chain, _ in each)
    known = [jnp.stack(numbers) for numbers in zip(*(chain.x for chain in chains), strict=True)]
    innovation = jnp.stack([taken.innovation for _, taken in each])
    variance = R * jnp.stack([taken.variance for _, taken in each])
    return chains, [*known, innovation, variance]


def _positions(state: tuple[Chain, ...], inputs: PositionSample) -> list[Array]:
    given = [part for part in (inputs.x, inputs.y, inputs.z) if part is not None]
    if len(given) != len(state):
        raise ValueError(
            f"the filter is made for {len(state)} axes and the samples bring {len(given)}; give it "
            "axes='x', 'xy' or 'xyz', as the samples have them"
        )
    return given
