"""Quality of a linear design without any data: poles, settling, error and variance.

The error of an observer with gain L moves as x' = A x, A being the plant's dynamics less L C. All
functions are differentiable and can be batched with ``jax.vmap``.
"""

import jax
import jax.numpy as jnp
from jax import Array

from filters.exponential import expm
from objectives.linear_systems.lyapunov import lyapunov, stein

HORIZON = 40.0
"""Length of a response in time constants of the slowest pole: e^-40 is negligible."""
_DOUBLINGS = 11  # samples of a response, as a power of two; twice, coarse and fine


def decay_rate(A: Array) -> Array:
    """The smallest abs(Re pole), ``()``, 1/s; negative where A is unstable.

    Differentiable where the slowest pole is simple; a gradient at a multiple pole is not finite,
    for the poles leave it as roots of what changes. Search in :class:`Factors` there.

    Args:
        A: dynamics of the error, ``(n, n)``, 1/s.

    >>> float(decay_rate(jnp.diag(jnp.array([-3.0, -0.5]))))
    0.5
    """
    slowest: Array = jnp.linalg.eigvals(A).real.max()
    return -slowest


def spectral_radius(F: Array) -> Array:
    """The largest abs(eigenvalue) of a discrete error's transition, ``()``; below 1 if stable.

    >>> float(spectral_radius(jnp.array([[0.0, 1.0], [-0.25, 0.0]])).round(12))
    0.5
    """
    return jnp.abs(jnp.linalg.eigvals(F)).max()


def settling_time(A: Array, x0: Array, c: Array, band: float) -> Array:
    """The time from which c x(t) stays within a band around zero, ``()``, s; infinite if unstable.

    The last crossing is bracketed on a grid and refined by Newton's method; its derivative is that
    of the crossing. Where a ripple just touches the band, the time jumps: give such an objective
    to a solver that needs no gradient.

    Args:
        A: dynamics of the error, ``(n, n)``, 1/s.
        x0: the error at the start, ``(n,)``.
        c: which error counts, ``(n,)``; c x0 must not be 0.
        band: half-width, as a share of abs(c x0), 0.02 or 0.05 as a rule.

    >>> A = jnp.array([[-1.0]])
    >>> bool(abs(settling_time(A, jnp.ones(1), jnp.ones(1), 0.05) - jnp.log(20.0)) < 1e-12)
    True
    """
    level = band * jnp.abs(c @ x0)
    fixed, start = jax.lax.stop_gradient((A, x0))
    rate = decay_rate(fixed)
    fine = HORIZON / rate / 4.0**_DOUBLINGS
    F = expm(fixed * fine)
    coarse = F
    for _ in range(_DOUBLINGS):
        coarse = coarse @ coarse
    passed, x = _last_outside(coarse, start, c, level)
    more, x = _last_outside(F, x, c, level)
    over, slope, bend = jnp.abs(c @ x) - level, _outward(fixed, x, c), _outward(fixed, fixed @ x, c)
    # Within a step of 1e-5 time constants, two terms of Newton's series leave nothing.
    t = (passed * 2**_DOUBLINGS + more) * fine - over / slope * (1 + over * bend / slope**2 / 2)
    x = expm(A * jax.lax.stop_gradient(t)) @ x0
    t = jax.lax.stop_gradient(t) - (jnp.abs(c @ x) - level) / _outward(A, x, c)
    return jnp.where(rate > 0, t, jnp.inf)


def ise(A: Array, x0: Array, c: Array) -> Array:
    """Integral of (c x)^2 from x0 on, ``()``; NaN where A is unstable.

    It is x0' M x0 with A' M + M A + c' c = 0.

    Args:
        A: dynamics of the error, ``(n, n)``, 1/s.
        x0: the error at the start, ``(n,)``.
        c: which error counts, ``(n,)``.

    >>> float(ise(jnp.array([[-2.0]]), jnp.ones(1), jnp.ones(1)))
    0.25
    """
    return x0 @ lyapunov(A.T, jnp.outer(c, c)) @ x0


def steady_variance(A: Array, W: Array, c: Array, *, discrete: bool = False) -> Array:
    """Steady variance of c x, ``()``; NaN where A is unstable.

    Args:
        A: dynamics ``(n, n)``, 1/s; a transition where ``discrete``.
        W: spectral density of the noise, ``(n, n)``; its covariance per sample where ``discrete``.
        c: which error counts, ``(n,)``.
        discrete: whether x is a sequence, x' = A x + w.

    >>> float(steady_variance(jnp.array([[-2.0]]), jnp.array([[4.0]]), jnp.ones(1)))
    1.0
    """
    return c @ (stein(A, W) if discrete else lyapunov(A, W)) @ c


def _last_outside(F: Array, x: Array, c: Array, level: Array) -> tuple[Array, Array]:
    """The last sample outside the band among 2^k samples from x on, and the state there."""
    states = x[:, None]
    for _ in range(_DOUBLINGS):  # x, F x | F^2 x, F^3 x | ...
        states = jnp.concatenate([states, F @ states], axis=1)
        F = F @ F
    outside = jnp.abs(c @ states) > level
    last = outside.shape[0] - 1 - jnp.argmax(outside[::-1])
    return last, states[:, last]


def _outward(A: Array, x: Array, c: Array) -> Array:
    """Rate at which c x moves away from zero where dx/dt = A x."""
    slope: Array = jnp.sign(c @ x) * (c @ A @ x)
    return slope
