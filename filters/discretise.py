"""From a continuous model to one step of a discrete one, at one sample time or at many."""

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters.exponential import expm
from filters.linear import Transition

_MOST_DOUBLINGS = 20  # enough for a step a million times as long as the fastest time constant


def van_loan(A: Array, G: Array, S: Array, dt: Array) -> Transition:
    """Discretise dx = A x dt + G dw exactly, white noise w of spectral density S.

    F = expm(A dt) and Q = integral of expm(A t) G S G' expm(A t)' over one step, by one matrix
    exponential of twice the size. Source: Van Loan, IEEE Trans. Automatic Control 23(3), 1978.
    That exponential holds expm(-A dt), which explodes where a mode dies out within the step, so it
    is taken over a part of the step that is short for A, and the part is doubled: F F, Q + F Q F'.

    Args:
        A: continuous dynamics, ``(n, n)``, 1/s.
        G: where the noise enters, ``(n, p)``.
        S: two-sided spectral density of the noise, ``(p, p)``, unit^2 s: not a variance.
        dt: sample time in s, ``()``.

    Returns:
        A :class:`Transition` with ``G = I`` and ``Q`` the covariance that enters per sample.

    >>> step = van_loan(jnp.zeros((1, 1)), jnp.eye(1), 2.0 * jnp.eye(1), 0.5)
    >>> float(step.Q[0, 0])
    1.0
    """
    n = A.shape[0]
    length = jax.lax.stop_gradient(jnp.abs(A).sum(axis=1).max() * dt)
    doublings = jnp.clip(jnp.ceil(jnp.log2(length)), 0, _MOST_DOUBLINGS)
    part = dt / 2**doublings
    noise = G @ S @ G.T * part
    size = jax.lax.stop_gradient(jnp.abs(noise).max())
    unit = jnp.where(size > 0, size, 1.0)  # the unit of S must not cost digits of F
    block = jnp.block([[-A * part, noise / unit], [jnp.zeros((n, n)), A.T * part]])
    exponential = expm(block)
    F = exponential[n:, n:].T

    def double(i: Array, step: tuple[Array, Array]) -> tuple[Array, Array]:
        F, Q = step
        more = i < doublings
        return jnp.where(more, F @ F, F), jnp.where(more, Q + F @ Q @ F.T, Q)

    start = F, unit * (F @ exponential[:n, n:])
    F, Q = jax.lax.fori_loop(0, _MOST_DOUBLINGS, double, start)
    return Transition(F=F, G=jnp.eye(n), Q=(Q + Q.T) / 2)


def transitions(A: Array, G: Array, S: Array, dt: np.ndarray) -> Transition:
    """One exact transition per sample, for a record whose sample times vary.

    Each distinct sample time is discretised once, outside the time loop.

    Args:
        A, G, S: the continuous model, as for :func:`van_loan`.
        dt: the time that leads to each sample, ``(N,)``, s, known before tracing.

    Returns:
        A :class:`Transition` whose arrays have time first, ``(N, n, n)``.

    Raises:
        ValueError: where a sample time is negative or not finite.

    >>> A, G = jnp.array([[0.0, 1.0], [0.0, 0.0]]), jnp.array([[0.0], [1.0]])
    >>> transitions(A, G, jnp.eye(1), np.array([0.5, 2.0])).F[:, 0, 1].round(12).tolist()
    [0.5, 2.0]
    """
    steps = np.asarray(dt, dtype=np.float64)
    wrong = np.flatnonzero(~(np.isfinite(steps) & (steps >= 0)))
    if wrong.size:
        raise ValueError(
            f"dt has {wrong.size} entries that are negative or not finite, the first "
            f"{steps[wrong[0]]} at sample {wrong[0]}; time must not run backwards"
        )
    distinct, which = np.unique(steps, return_inverse=True)
    table = _at_each(A, G, S, jnp.asarray(distinct))
    return Transition(F=table.F[which], G=table.G[which], Q=table.Q[which])


_at_each = jax.jit(jax.vmap(van_loan, in_axes=(None, None, None, 0)))
