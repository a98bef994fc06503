"""The atoms of every Kalman filter, in a stable form and without a linear solve.

XLA compiles a whole time loop natively only while the loop holds no LAPACK call, so
measurements are taken one scalar after another and a full measurement covariance is
split by a written-out LDL' factorisation.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.covariance_step import corrected, even, predicted
from filters.small_linalg import matmul, turned
from filters.together_step import corrected_together

TOGETHER = 9
"""States from which taking the measurements of a sample together is faster."""
MOST_ROWS = 3
"""Measurements that are taken together: the numbers of their span grow as its cube."""


class Estimate(NamedTuple):
    """The state of a Kalman filter.

    Attributes:
        x: state estimate, ``(n,)``; ``(n, s)`` where s signals pass through the same gains.
        P: covariance of its error, ``(n, n)``, symmetric.
    """

    x: Array
    P: Array


class Innovation(NamedTuple):
    """The result of an update with one scalar measurement.

    Attributes:
        value: measured minus predicted, 0 where the sample is missing; ``()`` or ``(s,)``.
        variance: its predicted variance h P h' + r, 0 where the sample is missing, ``()``.
        gain: the gain that was applied, 0 where the sample is missing, ``(n,)``.
    """

    value: Array
    variance: Array
    gain: Array


def predict(estimate: Estimate, F: Array, W: Array) -> Estimate:
    """Advance one sample: x = F x, P = F P F' + W.

    Args:
        estimate: the estimate after the last measurement.
        F: transition matrix, ``(n, n)``.
        W: covariance of the noise that enters in this step, ``(n, n)``.

    Raises:
        ValueError: for a covariance of another shape, which would be added to every entry.
    """
    if jnp.shape(W) != estimate.P.shape:
        needed = estimate.P.shape
        raise ValueError(
            f"the covariance of the noise has shape {jnp.shape(W)}, and {needed} is needed; of a "
            f"number q that is q * jnp.eye({needed[0]})"
        )
    P = predicted(F, turned(F), estimate.P, even(W))
    return Estimate(matmul(F, estimate.x), P)


def update(estimate: Estimate, h: Array, r: Array, z: Array) -> tuple[Estimate, Innovation]:
    """Take one scalar measurement z = h x + v, var v = r; NaN in z means it is missing.

    The covariance is updated in Joseph's form, written as two rank-one steps (Bierman,
    Factorization Methods for Discrete Sequential Estimation, 1977): with g = P h' and
    k = g / s, A = P - k g' and P+ = A - (A h' - r k) k'. It stays positive semi-definite and
    keeps its digits where P has rank one and r is 1e-12.

    Args:
        estimate: the predicted estimate.
        h: measurement row, ``(n,)``.
        r: measurement variance, ``()``, positive.
        z: measurement, ``()`` or ``(s,)`` for s signals; any NaN counts for all of them.

    >>> one = jnp.ones(1)
    >>> ahead = predict(Estimate(0 * one, jnp.eye(1)), jnp.eye(1), jnp.eye(1))  # variance 2
    >>> after, innovation = update(ahead, one, jnp.array(2.0), jnp.array(3.0))
    >>> after.x.tolist(), after.P.tolist(), innovation.variance.tolist()
    ([1.5], [[1.0]], 4.0)
    """
    x, P, value, variance, gain = corrected(*estimate, h, r, z)
    return Estimate(x, P), Innovation(value, variance, gain)


def update_rows(estimate: Estimate, H: Array, r: Array, z: Array) -> tuple[Estimate, Innovation]:
    """:func:`update` by m scalar measurements in turn, their innovations stacked.

    From nine states on they are worked out together: at 15 a pass takes a third less time so.

    Args:
        estimate: the predicted estimate.
        H: measurement rows, ``(m, n)``.
        r: their variances, ``(m,)``.
        z: measurements, ``(m,)`` or ``(m, s)`` for s signals; NaN means missing.

    >>> after, innovation = update_rows(
    ...     Estimate(jnp.zeros(2), jnp.eye(2)), jnp.eye(2), jnp.ones(2), jnp.array([3.0, jnp.nan])
    ... )
    >>> after.x.tolist(), after.P.tolist(), innovation.variance.tolist()
    ([1.5, 0.0], [[0.5, 0.0], [0.0, 1.0]], [2.0, 0.0])
    """
    if estimate.x.ndim > 1 or len(H) < 2 or len(estimate.x) < TOGETHER:
        return _one_by_one(estimate, H, r, z)
    innovations = []
    for i in range(0, len(H), MOST_ROWS):
        some = slice(i, i + MOST_ROWS)
        x, P, *innovation = corrected_together(*estimate, H[some], r[some], z[some])
        estimate = Estimate(x, P)
        innovations.append(innovation)
    return estimate, Innovation(*map(jnp.concatenate, zip(*innovations, strict=True)))


def _one_by_one(estimate: Estimate, H: Array, r: Array, z: Array) -> tuple[Estimate, Innovation]:
    innovations = []
    for i in range(len(H)):
        estimate, innovation = update(estimate, H[i], r[i], z[i])
        innovations.append(innovation)
    return estimate, Innovation(*map(jnp.stack, zip(*innovations, strict=True)))


def update_large(
    estimate: Estimate, h: Array | int, r: Array, z: Array
) -> tuple[Estimate, Innovation]:
    """:func:`update` by one signal, for filters of many states: at 15 a fifth of its time.

    Args:
        estimate: the predicted estimate.
        h: measurement row, ``(n,)``; or which state is measured, for a row of the unit matrix.
        r: measurement variance, ``()``, positive.
        z: measurement, ``()``; NaN means that it is missing.

    >>> after, innovation = update_large(Estimate(jnp.zeros(2), jnp.eye(2)), 1, 1.0, jnp.array(3.0))
    >>> after.x.tolist(), after.P.tolist(), innovation.variance.tolist()
    ([0.0, 1.5], [[1.0, 0.0], [0.0, 0.5]], 2.0)
    """
    x, P = estimate
    if isinstance(h, int):
        g, known, expected = P[h], P[h, h], x[h]
    else:
        g, expected = matmul(P, h), matmul(h, x)
        known = matmul(h, g)
    missing, s = jnp.isnan(z), known + r
    k = g * jnp.where(missing, 0.0, 1 / s)
    y = jnp.where(missing, 0.0, z - expected)
    # What rounding leaves of A h' - r k in update.
    lost = jax.lax.stop_gradient(jnp.where(missing, 0.0, g - k * known - r * k)) / 2
    P = _less(P, jnp.stack([k, lost, k]), jnp.stack([g, k, lost]))
    return Estimate(x + k * y, P), Innovation(y, jnp.where(missing, 0.0, s), k)


@jax.custom_jvp
def _less(P: Array, U: Array, V: Array) -> Array:
    """P - U' V, of ``(n, n)`` and ``(3, n)``.

    XLA writes sums out into all that uses P, so that the tenth update computes the nine before it
    anew in each of its parts; a product stays one. In derivatives, of many lanes, it is the other
    way round, and there products are slow.
    """
    return P - jax.lax.dot_general(U, V, (((0,), (0,)), ((), ())))


@_less.defjvp
def _less_jvp(
    at: tuple[Array, Array, Array], along: tuple[Array, Array, Array]
) -> tuple[Array, Array]:
    (P, U, V), (dP, dU, dV) = at, along
    # Only the first rows have derivatives that count: the others are rounding.
    return _less(P, U, V), dP - jnp.outer(dU[0], V[0]) - jnp.outer(U[0], dV[0])


def decorrelate(H: Array, R: Array, z: Array) -> tuple[Array, Array, Array]:
    """Rows, variances and measurements that can be taken one by one although R is full.

    R = L D L' with L unit lower triangular; L^-1 z = L^-1 H x + L^-1 v has the diagonal
    covariance D. A missing component (NaN) leaves the factorisation first, so it does not
    mix into the others.

    Args:
        H: measurement matrix, ``(m, n)``.
        R: measurement covariance, ``(m, m)``, symmetric positive definite.
        z: measurements, ``(m,)`` or ``(m, s)``.

    Returns:
        ``H'``, the diagonal of D, and ``z'`` (NaN where z is missing), of the same shapes.
    """
    m = R.shape[0]
    seen = ~jnp.isnan(z.reshape(m, -1)).any(axis=1)
    R = jnp.where(seen[:, None] & seen[None, :], R, jnp.eye(m, dtype=R.dtype))
    rows = [H[i] for i in range(m)]
    known = jnp.where(seen.reshape((m,) + (1,) * (z.ndim - 1)), z, 0.0)
    values = [known[i] for i in range(m)]
    variances: list[Array] = []
    L: list[list[Array]] = []
    zero = jnp.zeros((), R.dtype)
    for i in range(m):
        L.append([])
        for j in range(i):
            mixed = sum((L[i][p] * L[j][p] * variances[p] for p in range(j)), zero)
            L[i].append((R[i, j] - mixed) / variances[j])
            rows[i] = rows[i] - L[i][j] * rows[j]
            values[i] = values[i] - L[i][j] * values[j]
        own = sum((L[i][p] ** 2 * variances[p] for p in range(i)), zero)
        variances.append(R[i, i] - own)
    missing = ~seen.reshape((m,) + (1,) * (z.ndim - 1))
    return jnp.stack(rows), jnp.stack(variances), jnp.where(missing, jnp.nan, jnp.stack(values))
