"""The functions of the battery: of points z ``(..., 2)`` and numbers p, by jax.numpy or numpy."""

from types import ModuleType
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

T = np.linspace(0.0, 10.0, 60)
"""Times of the fitted records."""


# --- flat: what does not matter -----------------------------------------------------------------


def ridge(xp: ModuleType, z: Any, p: Any) -> Any:
    """Only z0 + s z1 matters, and e times the other direction: exactly flat where e is 0."""
    c, k, s, m, e, n = p
    along, across = z[..., 0] + s * z[..., 1] - m, z[..., 1] - s * z[..., 0] - n
    return c * (1 + k * along**2 + e * across**2)


def bent(xp: ModuleType, z: Any, p: Any) -> Any:
    """A flat valley along a curve: a straight step leaves it."""
    c, k, w = p
    return c * (1 + k * (z[..., 1] - xp.sin(w * z[..., 0])) ** 2)


# --- kinked -------------------------------------------------------------------------------------


def corner(xp: ModuleType, z: Any, p: Any) -> Any:
    """Absolute values of both coordinates."""
    c, v, w, m, n = p
    return c + v * xp.abs(z[..., 0] - m) + w * xp.abs(z[..., 1] - n)


def largest(xp: ModuleType, z: Any, p: Any) -> Any:
    """The largest of two turned absolute values."""
    c, m, n, a, b = p
    x, y = z[..., 0] - m, z[..., 1] - n
    return c + xp.maximum(xp.abs(x + a * y), xp.abs(b * x - y))


def crease(xp: ModuleType, z: Any, p: Any) -> Any:
    """A turned crease whose bottom is a parabola."""
    c, w, s, e, m, n = p
    return c + w * xp.abs(z[..., 0] - m + s * (z[..., 1] - n)) + e * (z[..., 1] - n) ** 2


def deviations(xp: ModuleType, z: Any, p: Any) -> Any:
    """Mean absolute error of a line through points (least absolute deviations)."""
    t, y = np.linspace(-1.0, 1.0, len(p)), p
    return xp.abs(y - z[..., :1] - z[..., 1:] * t).mean(axis=-1)


def worst(xp: ModuleType, z: Any, p: Any) -> Any:
    """The largest error of an exponential, and an absolute one."""
    c, rate, n = p
    error = xp.exp(-xp.exp(z[..., :1]) * T) - xp.exp(-rate * T)
    return c + xp.abs(error).max(axis=-1) + 0.1 * xp.abs(xp.exp(z[..., 1]) - n)


# --- staircases ---------------------------------------------------------------------------------


def rounded(xp: ModuleType, z: Any, p: Any) -> Any:
    """A bowl, rounded to steps."""
    c, step, k, m, n = p
    bowl = k * ((z[..., 0] - m) ** 2 + (z[..., 1] - n) ** 2)
    return c + step * xp.round(bowl / step)


def counted(xp: ModuleType, z: Any, p: Any) -> Any:
    """A settling time, counted in samples, against the size of the gain."""
    step, slope, n = p
    rate = xp.exp(z[..., :1])
    late = (xp.exp(-rate * T) > 0.05).sum(axis=-1)
    return 1 + step * late + slope * rate[..., 0] + 0.01 * (xp.exp(z[..., 1]) - n) ** 2


def floors(xp: ModuleType, z: Any, p: Any) -> Any:
    """Whole steps away from a point, along both coordinates."""
    c, v, w, m, n = p
    x, y = xp.abs(z[..., 0] - m), xp.abs(z[..., 1] - n)
    return c + xp.floor(v * x) + xp.floor(w * y)


def confused(xp: ModuleType, z: Any, p: Any) -> Any:
    """The share of samples that a threshold puts on the wrong side, and a smooth share."""
    c, k, n, x = p[0], p[1], p[2], p[3:]
    true = np.arange(len(p) - 3) % 2 == 0
    wrong = ((x > xp.exp(z[..., :1])) != true).astype(float).mean(axis=-1)
    return c + wrong + k * (z[..., 1] - n) ** 2


# --- several wells ------------------------------------------------------------------------------


def double(xp: ModuleType, z: Any, p: Any) -> Any:
    """Two wells beside s, as deep as each other where t is 0; s is a saddle then."""
    c, h, s, w, t, n = p
    x = (z[..., 0] - s) / w
    return c + h * (x**2 - 1) ** 2 + t * x + (z[..., 1] - n) ** 2


def crossed(xp: ModuleType, z: Any, p: Any) -> Any:
    """Wells along a diagonal, a saddle at s that no axis shows."""
    c, e, m, n = p
    x, y = z[..., 0] - m, z[..., 1] - n
    return c + (x * y - 1) ** 2 + e * (x**2 + y**2)


def monkey(xp: ModuleType, z: Any, p: Any) -> Any:
    """A saddle with three ways down and no curvature."""
    c, h, angle, m, n = p
    x, y = z[..., 0] - m, z[..., 1] - n
    along, across = xp.cos(angle) * x + xp.sin(angle) * y, xp.cos(angle) * y - xp.sin(angle) * x
    return c + h * (along**3 - 3 * along * across**2 + (along**2 + across**2) ** 2)


def inflection(xp: ModuleType, z: Any, p: Any) -> Any:
    """Level and without curvature where it goes on falling."""
    c, h, m, n = p
    x = z[..., 0] - m
    return c + h * (x**3 + x**4) + (z[..., 1] - n) ** 2


def waves(xp: ModuleType, z: Any, p: Any) -> Any:
    """A bowl with waves on it (Rastrigin)."""
    c, k, h, w, m, n = p
    x, y = z[..., 0] - m, z[..., 1] - n
    bowl = k * (x**2 + y**2)
    return c + bowl + h * (2 - xp.cos(w * x) - xp.cos(w * y))


def wells(xp: ModuleType, z: Any, p: Any) -> Any:
    """Three wells in a plain that is all but level."""
    value = p[0]
    for h, m, n, s in (p[1:5], p[5:9], p[9:13]):
        square = (z[..., 0] - m) ** 2 + (z[..., 1] - n) ** 2
        value = value - h * xp.exp(-square / (2 * s**2))
    return value


# --- scales -------------------------------------------------------------------------------------


def turned(xp: ModuleType, z: Any, p: Any) -> Any:
    """Offset + c times a turned quadratic of two curvatures, at a scale of z."""
    offset, c, k, e, angle, m, n, size = p
    x, y = z[..., 0] / size - m, z[..., 1] / size - n
    along, across = xp.cos(angle) * x + xp.sin(angle) * y, xp.cos(angle) * y - xp.sin(angle) * x
    return offset + c * (k * along**2 + e * across**2)


def many(xp: ModuleType, z: Any, p: Any) -> Any:
    """A quadratic of five coordinates: curvatures of every size along turned directions."""
    c, k, condition, m = p[0], p[1], p[2], p[3:8]
    axis = np.array([1.0, -2.0, 0.5, 1.5, -1.0])
    turn = np.eye(5) - 2 * np.outer(axis, axis) / (axis @ axis)
    each = k * condition ** (-np.arange(5) / 4)
    return c * (1 + (each * ((z - m) @ turn) ** 2).sum(axis=-1))


def many_corners(xp: ModuleType, z: Any, p: Any) -> Any:
    """Absolute values of five sums of neighbours."""
    c, w, m = p[0], p[1:6], p[6:11]
    x = z - m
    return c + (w * xp.abs(x + 0.4 * xp.roll(x, 1, axis=-1))).sum(axis=-1)


def banana(xp: ModuleType, z: Any, p: Any) -> Any:
    """Rosenbrock's valley."""
    c, k, m = p
    x, y = z[..., 0], z[..., 1]
    return c * (1 + (m - x) ** 2 + k * (y - x**2) ** 2)


# --- limits -------------------------------------------------------------------------------------


def sliding(xp: ModuleType, z: Any, p: Any) -> Any:
    """Slopes along both coordinates and parabolas."""
    c, g, k, m, h, e, n = p
    x, y = z[..., 0] - m, z[..., 1] - n
    return c + g * z[..., 0] + k * x**2 + h * z[..., 1] + e * y**2


def fading(xp: ModuleType, z: Any, p: Any) -> Any:
    """Falls towards a limit that no point reaches."""
    c, k, n = p
    return c + xp.exp(-z[..., 0]) + k * (z[..., 1] - n) ** 2


# --- level at the optimum, but determined -------------------------------------------------------


def power(xp: ModuleType, z: Any, p: Any) -> Any:
    """Even powers of turned coordinates."""
    c, first, second, angle, m, n, k = p
    x, y = z[..., 0] - m, z[..., 1] - n
    along, across = xp.cos(angle) * x + xp.sin(angle) * y, xp.cos(angle) * y - xp.sin(angle) * x
    return c * (1 + k * ((along**2) ** first + (across**2) ** second))


def round_quartic(xp: ModuleType, z: Any, p: Any) -> Any:
    """The square of a bowl."""
    c, k, m, n = p
    return c * (1 + k * ((z[..., 0] - m) ** 2 + (z[..., 1] - n) ** 2) ** 2)


# --- derivatives that mislead -------------------------------------------------------------------


def ripple(xp: ModuleType, z: Any, p: Any) -> Any:
    """A bowl with ripples too small for the value and too steep for the gradient."""
    c, size, pace, m, n = p
    bowl = (z[..., 0] - m) ** 2 + 0.5 * (z[..., 1] - n) ** 2
    waves = xp.sin(pace * z[..., 0]) * xp.sin(pace * z[..., 1])
    return c * (1 + bowl + size * waves)


def seam(xp: ModuleType, z: Any, p: Any) -> Any:
    """Two branches that meet without a step; in JAX by ``lax.cond``."""
    c, k, m, n = p
    x, y = z[..., 0] - m, z[..., 1] - n
    if xp is np:
        return c + np.where(x > 0, k * x**2, x**2) + y**2 + 0.3 * x * y
    bent = jax.lax.cond(x > 0, lambda: k * x**2, lambda: x**2)
    return c + bent + y**2 + 0.3 * x * y


def held(xp: ModuleType, z: Any, p: Any) -> Any:
    """A bowl of which the gradient leaves out one half (``stop_gradient``)."""
    c, m, n = p
    second = (z[..., 1] - n) ** 2
    if xp is jnp:
        second = jax.lax.stop_gradient(second)
    return c + (z[..., 0] - m) ** 2 + second


def cone(xp: ModuleType, z: Any, p: Any) -> Any:
    """A distance: at its end the gradient is not a number."""
    c, k, m, n = p
    return c + xp.sqrt((z[..., 0] - m) ** 2 + k * (z[..., 1] - n) ** 2)


# --- perfect fits -------------------------------------------------------------------------------


def squares(xp: ModuleType, z: Any, p: Any) -> Any:
    """Mean square of an exponential's error, and of another parameter's."""
    rate, n, c = p
    error = xp.exp(-xp.exp(z[..., :1]) * T) - xp.exp(-rate * T)
    return c * ((error**2).mean(axis=-1) + (xp.exp(z[..., 1]) - n) ** 2)


def line(xp: ModuleType, z: Any, p: Any) -> Any:
    """Mean square error of a line without noise."""
    m, n, c = p
    return c * ((z[..., :1] - m + (z[..., 1:] - n) * T / 10) ** 2).mean(axis=-1)


def root(xp: ModuleType, z: Any, p: Any) -> Any:
    """Root of the mean square error of a line without noise."""
    return xp.sqrt(line(xp, z, p))
