"""Process noise from the residuals of a Kalman filter's own updates.

Chauhan, Patil, Sinha and Halder 2009, (18): Q grows with the square of the rate at which a
residual dx = K nu changes. A fuzzy law takes the rate from a possibilistic line through the last
residuals; a random law, its competitor, draws it; a constant Q is the third.
"""

from typing import Literal, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.fuzzy_line import newest_line

Law = Literal["constant", "fuzzy", "random"]


class ResidualNoise(NamedTuple):
    """Parameters of the laws, for n states.

    Attributes:
        Q: diagonal of the process noise's density, ``(n,)``: constant, or until a law has one.
        floor: the least value that a law may set, ``(n,)``: a constant residual has the rate 0.
        scale: of the random law: the rate for a draw of 1, ``(n,)``.
        h: of the fuzzy law's regression, 0 to below 1; it matters for a band's edge alone.
    """

    Q: Array
    floor: Array
    scale: Array
    h: Array


class Residuals(NamedTuple):
    """The last residuals, the newest at the end, ``(m, n)``, and how many there have been."""

    window: Array
    taken: Array


def no_residuals(samples: int, x0: Array) -> Residuals:
    """The window before the first update of a state ``(n,)``."""
    return Residuals(jnp.zeros((samples, *x0.shape), x0.dtype), jnp.zeros((), x0.dtype))


def remembered(residuals: Residuals, residual: Array, seen: Array) -> Residuals:
    """The window with one more residual, if there was an update."""
    grown = jnp.concatenate([residuals.window[1:], residual[None]])
    return Residuals(jnp.where(seen, grown, residuals.window), residuals.taken + seen)


def fuzzy_noise(
    residuals: Residuals, noise: ResidualNoise, dt: float, *, edge: bool | Array
) -> Array:
    """The square of the line's slope times dt; Q while there are fewer than two residuals.

    Args:
        residuals: as many as an even number of samples allows are used, from t = 0 on.
        noise: Q, floor and h.
        dt: time between updates, s.
        edge: whether the slope is abs(p1) + c1, that of the band's steeper edge, not p1; an array
            is the share of c1.
    """
    fit = newest_line(residuals.window, residuals.taken, dt, noise.h)
    spread = fit.spread[:, 1]
    beside = edge * spread if isinstance(edge, Array) else spread if edge else 0.0
    rate = jnp.abs(fit.center[:, 1]) + beside
    return jnp.where(residuals.taken >= 2, _floored(rate, noise, dt), noise.Q)


def random_noise(draw: Array, noise: ResidualNoise, dt: float) -> Array:
    """The same for a drawn rate; ``draw`` is uniform from 0 to 1, ``(n,)``."""
    return _floored(noise.scale * draw, noise, dt)


def _floored(rate: Array, noise: ResidualNoise, dt: float) -> Array:
    return jnp.maximum(rate**2 * dt, noise.floor)
