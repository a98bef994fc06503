"""Measurement noise that varies: with the level, or with a channel."""

from functools import cache
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.added_parameters import WithParameters, require_channel, with_parameters
from filters.declared import Param, parameter_facts


class LevelState(NamedTuple):
    """The filter's own state, and the last estimated level, NaN before the first, ``()``."""

    inner: Any
    level: Array


class _LevelNoise(WithParameters):
    """A filter whose measurements' deviation grows with the level: sqrt(R) + slope abs(level).

    The level is the filter's own first output after the previous sample, and the measured one at
    the very first; of several axes it is the distance from the origin. Where samples bring
    ``sigma``, the deviation is sigma sqrt(R) + slope abs(level).
    """

    def init(self, params: Any) -> LevelState:
        """The filter's own start, without a level yet."""
        inner = self.inner().init(self.within(params))
        return LevelState(inner, jnp.full((), jnp.nan, jnp.result_type(params.R)))

    def step(self, params: Any, state: LevelState, inputs: Any) -> tuple[LevelState, Any]:
        """Take one sample with the deviation that belongs to the level."""
        parts = [v for n, v in inputs._asdict().items() if v is not None and n != "sigma"]
        measured = _length(jnp.stack(parts))
        level = jnp.where(jnp.isnan(state.level), measured, state.level)
        own = jnp.ones_like(level) if inputs.sigma is None else inputs.sigma
        grown = jnp.nan_to_num(level) * params.slope / jnp.sqrt(params.R)
        sigma = jnp.where(own > 0, own + grown, own)
        inner, output = self.inner().step(
            self.within(params), state.inner, inputs._replace(sigma=sigma)
        )
        begun = ~jnp.isnan(state.level) | (~jnp.isnan(measured) & (own > 0))
        now = _length(jnp.ravel(output[0]))
        return LevelState(inner, jnp.where(begun, now, state.level)), output


class _ChannelNoise(WithParameters):
    """A filter whose measurements' variance is R + share sigma^2, sigma the reported deviation."""

    absolute_noise = True

    def init(self, params: Any) -> Any:
        """The filter's own start."""
        return self.inner().init(self.within(params))

    def step(self, params: Any, state: Any, inputs: Any) -> tuple[Any, Any]:
        """Take one sample, with a floor under its reported deviation."""
        if inputs.sigma is None:
            raise ValueError(
                "the noise is to follow the channel sigma, and there is none; map it, as in --map "
                "sigma=COLUMN"
            )
        given = inputs.sigma > 0
        square = jnp.where(given, inputs.sigma, 1.0) ** 2
        sigma = jnp.where(given, jnp.sqrt(1 + params.share * square / params.R), inputs.sigma)
        return self.inner().step(self.within(params), state, inputs._replace(sigma=sigma))  # type: ignore[no-any-return]


@cache
def level_noise(base: type[Any]) -> type[Any]:
    """A filter whose measurements' deviation grows with the level, as a class with one more number.

    Its parameters are those of the filter and ``slope``: the deviation of a measurement is
    sqrt(R) + slope abs(level), so that slope has no unit.

    Args:
        base: class of a filter that takes ``sigma``.

    Raises:
        ValueError: for one that does not.

    >>> from filters import LevelSample, LocalLevel, run
    >>> noisier = level_noise(LocalLevel)
    >>> params = noisier.params(jnp.array(0.0), jnp.array(1.0), slope=jnp.array(0.1))
    >>> record = LevelSample(jnp.array([10.0, 10.0, 10.0]))
    >>> run(noisier(dt=1.0), params, record)[1].variance[:, 0].tolist()  # 2^2 + 2^2 / k
    [0.0, 8.0, 6.0]
    """
    require_channel(base, "sigma", "its noise cannot follow the level")
    slope = Param(
        "",
        "how much a measurement's deviation grows with the level, per unit of it",
        typical=0.01,
        low=1e-6,
        high=10.0,
        smaller="the noise is the same at all levels",
        larger="high levels are smoothed more than low ones",
    )
    return with_parameters(base, _LevelNoise, {"slope": (Array, slope)}, (level_noise, ()))


@cache
def channel_noise(base: type[Any]) -> type[Any]:
    """A filter whose measurements' variance is R + share sigma^2, as a class with one more number.

    sigma is the channel of that name: a receiver's accuracy, a dilution of precision.

    Args:
        base: class of a filter that takes ``sigma``.

    Raises:
        ValueError: for one that does not.

    >>> from filters import LevelSample, LocalLevel, run
    >>> careful = channel_noise(LocalLevel)
    >>> params = careful.params(jnp.array(0.0), jnp.array(1.0), share=jnp.array(0.5))
    >>> record = LevelSample(jnp.zeros(2), sigma=jnp.array([2.0, 4.0]))
    >>> run(careful(dt=1.0), params, record)[1].variance[1].tolist()  # 1 + 0.5 (2^2 + 4^2) + 1
    [12.0]
    """
    require_channel(base, "sigma", "its noise cannot follow a channel")
    share = Param(
        "",
        "what the deviation that a measurement tells counts, squared",
        typical=1.0,
        low=1e-6,
        high=1e6,
        smaller="all measurements count alike",
        larger="those that tell a large deviation count less",
    )
    facts = {"share": (Array, share), "R": (Array, _floor(base))}
    return with_parameters(base, _ChannelNoise, facts, (channel_noise, ()))


def _floor(base: type[Any]) -> Param:
    return parameter_facts(base)["R"]._replace(
        meaning="variance of a measurement whose told deviation is small"
    )


def _length(parts: Array) -> Array:
    """The norm of a vector, or the absolute value of one number. The derivative at 0 is 0."""
    if len(parts) == 1:
        return jnp.abs(parts[0])
    square = (parts**2).sum()
    none = square == 0
    return jnp.where(none, 0.0, jnp.sqrt(jnp.where(none, 1.0, square)))
