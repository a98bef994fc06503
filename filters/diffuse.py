"""A start of which nothing is known, exactly: no large number stands for infinity.

While some directions W of the state may have any error, a measurement that sees one of them is
taken with the gain that removes it, K = w / (h w), and does not count; all others are taken as
usual. In the limit of an infinite covariance W W' this is the Kalman filter. Source: Durbin and
Koopman, Time Series Analysis by State Space Methods, 2012, ch. 5, univariate treatment, with the
directions in place of their covariance, of which each measurement removes a column.
"""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias, TypeVar

import jax
import jax.numpy as jnp
from jax import Array

from filters.kalman import Estimate, Innovation, predict, update, update_rows
from filters.small_linalg import matmul


class DiffuseEstimate(NamedTuple):
    """The estimate of a Kalman filter while some directions of its state are unknown.

    Attributes:
        x: state estimate, ``(n,)`` or ``(n, s)``.
        P: covariance of its error, while W is left out of it, ``(n, n)``.
        W: directions in which the error may have any size, ``(n, d)``; columns of 0 once known.
        size: magnitude of the numbers whose sums W's entries are, ``(n, d)``: what is far
            below them is rounding.
    """

    x: Array
    P: Array
    W: Array
    size: Array


AnyEstimate: TypeAlias = Estimate | DiffuseEstimate
AnyKind = TypeVar("AnyKind", Estimate, DiffuseEstimate, AnyEstimate)


def begin(x0: Array, P0: Array, diffuse: Sequence[int]) -> AnyEstimate:
    """The start, with states of which nothing is known.

    Args:
        x0: the start, ``(n,)`` or ``(n, s)``; any value will do for diffuse states.
        P0: its covariance, ``(n, n)``; rows and columns of diffuse states do not matter.
        diffuse: the states of which nothing is known, by number.

    Raises:
        ValueError: for numbers of states that do not exist.

    >>> begin(jnp.zeros(2), jnp.eye(2), [1]).W.tolist()
    [[0.0], [1.0]]
    """
    if not diffuse:
        return Estimate(x0, P0)
    n = P0.shape[0]
    if len(set(diffuse)) < len(diffuse) or not all(0 <= i < n for i in diffuse):
        raise ValueError(
            f"diffuse states {tuple(diffuse)} of a model with {n}: name each once, from 0 to "
            f"{n - 1}"
        )
    W = jnp.eye(n, dtype=P0.dtype)[:, jnp.array(diffuse)]
    known = jnp.ones(n, P0.dtype).at[jnp.array(diffuse)].set(0.0)
    return DiffuseEstimate(x0, P0 * jnp.outer(known, known), W, jnp.abs(W))


def advance(estimate: AnyKind, F: Array, noise: Array) -> AnyKind:
    """:func:`filters.predict` for either kind of estimate."""
    ahead = predict(Estimate(estimate.x, estimate.P), F, noise)
    if isinstance(estimate, Estimate):
        return ahead
    size = jnp.maximum(estimate.size, matmul(jnp.abs(F), jnp.abs(estimate.W)))
    kept = jnp.where(jnp.any(estimate.W != 0, axis=0), size, 0.0)
    return DiffuseEstimate(*ahead, matmul(F, estimate.W), jax.lax.stop_gradient(kept))


def take(estimate: AnyKind, h: Array, r: Array, z: Array) -> tuple[AnyKind, Innovation]:
    """:func:`filters.update` for either kind of estimate.

    Args:
        estimate: the predicted estimate.
        h: measurement row, ``(n,)``.
        r: measurement variance, ``()``.
        z: measurement, ``()`` or ``(s,)``; NaN means missing.

    Returns:
        The estimate, and the innovation: value and variance are 0 where the measurement removes a
        direction, as they then say nothing.

    >>> start = begin(jnp.zeros(1), jnp.eye(1), [0])
    >>> after, innovation = take(start, jnp.ones(1), jnp.array(2.0), jnp.array(5.0))
    >>> after.x.tolist(), after.P.tolist(), innovation.variance.item()
    ([5.0], [[2.0]], 0.0)
    """
    plain, innovation = update(Estimate(estimate.x, estimate.P), h, r, z)
    if isinstance(estimate, Estimate):
        return plain, innovation
    x, P, W, size = estimate
    seen = matmul(h, W)
    scale = jax.lax.stop_gradient(matmul(jnp.abs(h), size))
    share = jnp.abs(seen) / jnp.where(scale > 0, scale, 1.0)
    column = jnp.argmax(share)
    starts = (share[column] > 1e3 * jnp.finfo(P.dtype).eps) & ~jnp.isnan(z).any()
    k = W[:, column] / jnp.where(starts, seen[column], 1.0)
    g = matmul(P, h)
    removed = jnp.outer(k, seen)
    left = jnp.where(jnp.arange(W.shape[1]) == column, 0.0, W - removed)
    across = jnp.outer(k, g)  # Joseph's form, for a gain that is not the optimal one
    begun = DiffuseEstimate(
        x + jnp.multiply.outer(k, jnp.where(starts, z - matmul(h, x), 0.0)),
        P - across - across.T + jnp.outer(k, k) * (matmul(h, g) + r),
        left,
        jnp.where(left == 0, 0.0, jnp.maximum(size, jnp.abs(removed))),
    )
    either = DiffuseEstimate(*plain, W, size)
    found = DiffuseEstimate(*(jnp.where(starts, a, b) for a, b in zip(begun, either, strict=True)))
    value, variance, gain = innovation
    return found._replace(size=jax.lax.stop_gradient(found.size)), Innovation(
        jnp.where(starts, 0.0, value), jnp.where(starts, 0.0, variance), jnp.where(starts, k, gain)
    )


def take_rows(estimate: AnyKind, H: Array, r: Array, z: Array) -> tuple[AnyKind, Innovation]:
    """:func:`take` of m measurements in turn, their innovations stacked.

    Args:
        estimate: the predicted estimate.
        H: measurement rows, ``(m, n)``.
        r: measurement variances, ``(m,)``.
        z: measurements, ``(m,)`` or ``(m, s)``; NaN means missing.
    """
    if isinstance(estimate, Estimate):
        return update_rows(estimate, H, r, z)
    innovations = []
    for i in range(len(H)):
        estimate, innovation = take(estimate, H[i], r[i], z[i])
        innovations.append(innovation)
    return estimate, Innovation(*map(jnp.stack, zip(*innovations, strict=True)))
