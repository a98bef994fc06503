"""A quantity and its derivatives, one integrating the next, from measurements of the quantity.

The Kalman filter of constant velocity, constant acceleration and the vertical channel, written out
in scalars, which XLA fuses into one piece of the time loop.

The start is diffuse and exact. While j numbers are known, the start leaves directions W in which
the error may have any size; the next measurement is taken with the gain that removes one of them,
K = w / w_0, instead of the optimal one. So x and P need no large number in place of infinity, which
would cost digits and depend on units. Source: Durbin and Koopman, Time Series Analysis by State
Space Methods, 2012, ch. 5. The covariance is carried over R, so that R is only a scale.
"""

from collections.abc import Iterable
from math import factorial
from typing import NamedTuple, TypeAlias

import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike

Vector: TypeAlias = tuple[Array, ...]
Upper: TypeAlias = tuple[tuple[ArrayLike, ...], ...]
"""The upper triangle of a symmetric matrix: row i holds its entries from the diagonal on."""


class Chain(NamedTuple):
    """The estimate of the filter; every number is ``()``.

    Attributes:
        x: the quantity and its derivatives, n numbers.
        P: covariance of their error over R, while W is left out of it.
        W: directions of the start that are still unknown, n numbers each; without the first, which
            is the quantity itself.
        known: how many directions are known, a whole number.
    """

    x: Vector
    P: Upper
    W: tuple[Vector, ...]
    known: Array


class Taken(NamedTuple):
    """Innovation and its variance over R; both 0 where the number is missing or taken to start."""

    innovation: Array
    variance: Array


def begin(still: Array, P: Upper, diffuse: int) -> Chain:
    """The estimate before the first measurement.

    Args:
        still: a zero of the type that every number shall have.
        P: covariance of the start over R where it is known.
        diffuse: how many of the n numbers may have any value, from the first on.
    """
    n = len(P)
    P = tuple(tuple(still + entry for entry in row) for row in P)
    W = tuple(tuple(still + (i == j) for i in range(n)) for j in range(1, diffuse))
    return Chain((still,) * n, P, W, still)


def unknown(n: int) -> Upper:
    """The covariance of a start of which nothing is known.

    >>> unknown(2)
    ((0.0, 0.0), (0.0,))
    """
    return tuple((0.0,) * (n - i) for i in range(n))


def white_noise(n: int, order: int, density: ArrayLike, dt: ArrayLike) -> Upper:
    """Covariance that white noise on a derivative adds in a step to n numbers.

    Args:
        n: how many numbers there are.
        order: of the derivative that is noise; the numbers from ``order`` on stay.
        density: of the noise, two-sided, unit^2 s.
        dt: sample time, s.

    >>> white_noise(2, 2, 6.0, 1.0)
    ((2.0, 3.0), (6.0,))
    """

    def entry(i: int, j: int) -> ArrayLike:
        a, b = order - 1 - i, order - 1 - j
        if min(a, b) < 0:
            return 0.0
        return density * dt ** (a + b + 1) / (factorial(a) * factorial(b) * (a + b + 1))

    return tuple(tuple(entry(i, j) for j in range(i, n)) for i in range(n))


def add(one: Upper, other: Upper) -> Upper:
    """The sum of two symmetric matrices."""
    rows = zip(one, other, strict=True)
    return tuple(tuple(a + b for a, b in zip(*row, strict=True)) for row in rows)


def full(P: Upper) -> Array:
    """The whole matrix, ``(n, n)``.

    >>> full(((1.0, 2.0), (3.0,))).tolist()
    [[1.0, 2.0], [2.0, 3.0]]
    """
    n = len(P)
    return jnp.stack([jnp.stack([jnp.asarray(_at(P, i, j)) for j in range(n)]) for i in range(n)])


def integration(n: int, dt: ArrayLike) -> Array:
    """The matrix by which n numbers, each the derivative of the one before, move on, ``(n, n)``.

    Args:
        n: how many numbers there are.
        dt: sample time, s.

    >>> integration(3, 2.0).tolist()
    [[1.0, 2.0, 2.0], [0.0, 1.0, 2.0], [0.0, 0.0, 1.0]]
    """
    step = jnp.asarray(dt)
    zero = jnp.zeros_like(step)
    rows = [
        [step ** (j - i) / factorial(j - i) if j >= i else zero for j in range(n)] for i in range(n)
    ]
    return jnp.stack([jnp.stack(row) for row in rows])


def move(chain: Chain, Q: Upper, dt: ArrayLike) -> Chain:
    """Integrate over one step; nothing moves before the first measurement.

    Args:
        chain: after the last measurement.
        Q: covariance of the noise that enters, over R.
        dt: sample time, s.
    """
    n = len(chain.x)
    begun = chain.known > 0
    dt = jnp.where(begun, dt, 0.0)
    F = [dt**k / factorial(k) for k in range(n)]

    def moved(x: Vector) -> Vector:
        return tuple(_sum(F[j - i] * x[j] for j in range(i, n)) for i in range(n))

    columns = [moved(tuple(_at(chain.P, i, j) for i in range(n))) for j in range(n)]
    rows = [moved(tuple(columns[j][i] for j in range(n))) for i in range(n)]
    P = tuple(
        tuple(rows[i][j] + jnp.where(begun, Q[i][j - i], 0.0) for j in range(i, n))
        for i in range(n)
    )
    return Chain(moved(chain.x), P, tuple(moved(w) for w in chain.W), chain.known)


def measure(chain: Chain, z: Array, sigma: ArrayLike, diffuse: int) -> tuple[Chain, Taken]:
    """Take one measurement of the quantity.

    Args:
        chain: at the time of the measurement.
        z: the measurement; NaN is missing.
        sigma: its deviation, in a unit in which R is its variance at 1; missing where not positive.
        diffuse: as in :func:`begin`.
    """
    x, P, W, known = chain
    n = len(x)
    seen = ~jnp.isnan(z) & (jnp.asarray(sigma) > 0)
    r = jnp.where(seen, sigma, 1.0) ** 2
    s = P[0][0] + r
    K = [jnp.asarray(p / s) for p in P[0]]
    starts = known < min(diffuse, 1)
    K = [jnp.where(starts, float(i == 0), k) for i, k in enumerate(K)]
    for j, w in enumerate(W, start=1):
        now = (known == j) & (w[0] > 0)  # not at the very time of the last one
        K = [jnp.where(now, a / jnp.where(now, w[0], 1.0), k) for a, k in zip(w, K, strict=True)]
        starts = starts | now
    K = [jnp.where(seen, k, 0.0) for k in K]
    y = jnp.where(seen, z - x[0], 0.0)
    first = tuple(jnp.where(seen, k * r, p) for k, p in zip(K, P[0], strict=True))
    others = tuple(  # Joseph's form, for gains that need not be optimal
        tuple(_at(P, i, j) - K[i] * P[0][j] - K[j] * P[0][i] + K[i] * K[j] * s for j in range(i, n))
        for i in range(1, n)
    )
    left = tuple(tuple(a - k * w[0] for a, k in zip(w, K, strict=True)) for w in W)
    counts = seen & ~starts
    taken = Taken(jnp.where(counts, y, 0.0), jnp.where(counts, s, 0.0))
    x = tuple(a + k * y for a, k in zip(x, K, strict=True))
    return Chain(x, (first, *others), left, known + (seen & starts)), taken


def steady_gain(Q: Array, dt: ArrayLike) -> Array:
    """The gain that the filter settles to where every sample is measured with variance 1, ``(n,)``.

    The Riccati equation of the predicted covariance by structured doubling (Chu, Fan, Lin and Wang,
    International Journal of Control 77(8), 2004): k rounds are 2^k samples. Time is in samples
    meanwhile, so that the numbers have like sizes.

    Args:
        Q: covariance that enters in a sample, over R, ``(n, n)``.
        dt: sample time, s.

    >>> steady_gain(jnp.array([[0.5]]), 0.1).round(6).tolist()  # K^2 / (1 - K) = Q/R
    [0.5]
    """
    n = len(Q)
    unit = jnp.asarray(dt, Q.dtype) ** jnp.arange(n)
    powers = [[1 / factorial(j - i) if j >= i else 0.0 for j in range(n)] for i in range(n)]
    A = jnp.array(powers, Q.dtype).T
    G = jnp.zeros_like(Q).at[0, 0].set(1.0)
    H = Q * jnp.outer(unit, unit)
    one = jnp.eye(n, dtype=Q.dtype)
    for _ in range(_ROUNDS):
        half = jnp.linalg.solve(one + G @ H, jnp.concatenate([A, G], axis=1))
        A, G, H = A @ half[:, :n], G + A @ half[:, n:] @ A.T, H + A.T @ H @ half[:, :n]
        G, H = (G + G.T) / 2, (H + H.T) / 2
    return H[:, 0] / (1 + H[0, 0]) / unit


_ROUNDS = 40  # 2^40 samples: no filter is slower


def _at(P: Upper, i: int, j: int) -> Array:
    return jnp.asarray(P[min(i, j)][abs(i - j)])


def _sum(terms: Iterable[Array]) -> Array:
    first, *others = terms
    for term in others:
        first = first + term
    return first
