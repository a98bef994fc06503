"""The measurements of one sample as one step of a covariance, with its derivative by hand.

Taken one after another, each measurement passes over the covariance four times. Its rows P h are
all that gains, innovations and variances need: these are worked out in the span of the rows, and
then the covariance is corrected once, for all of them.
"""

from functools import partial
from typing import Any, TypeAlias

import jax
import jax.numpy as jnp
from jax import Array

from filters.covariance_step import by, given, none

Numbers: TypeAlias = list[Array]
Together: TypeAlias = tuple[Array, Array, Array, Array, Array]


@jax.custom_jvp
def corrected_together(x: Array, P: Array, H: Array, r: Array, z: Array) -> Together:
    """State, covariance, innovations, variances and gains of m scalar measurements in turn.

    The same as :func:`filters.covariance_step.corrected` m times, but for rounding: with the gain K
    of all of them, A = P - K H P and P+ = A - (A H' - K R) K', Joseph's form.

    Args:
        x: predicted state, ``(n,)``.
        P: its covariance, ``(n, n)``, symmetric.
        H: measurement rows, ``(m, n)``.
        r: their variances, ``(m,)``.
        z: measurements, ``(m,)``; NaN means missing.

    Returns:
        x ``(n,)``, P ``(n, n)``, innovations ``(m,)``, variances ``(m,)``, gains ``(m, n)``.
    """
    return corrected_kept(x, P, H, r, z)[0]


def corrected_kept(
    x: Array, P: Array, H: Array, r: Array, z: Array
) -> tuple[Together, tuple[Array, Array, Array]]:
    """The same, and what the way back needs: K, the combinations of rows L^-1, and 1 / s."""
    m = len(H)
    G = _rows(H, P)
    missing = list(jnp.isnan(z))
    within = [[(H[i] * G[j]).sum() for j in range(i, m)] for i in range(m)]
    within = [[within[min(i, j)][abs(i - j)] for j in range(m)] for i in range(m)]
    variances, weights, lower = _in_turn(within, list(r), missing)
    apart = [jnp.where(missing[i], 0.0, z[i] - (H[i] * x).sum()) for i in range(m)]
    y = [jnp.where(missing[i], 0.0, _mixed(apart, lower[i])) for i in range(m)]
    scaled = [[weights[i] * share for share in lower[i]] for i in range(m)]
    k = jnp.stack([_mixed(G, scaled[i]) for i in range(m)])
    inverse = [[_dot(lower, scaled, i, j) for j in range(m)] for i in range(m)]
    K = jnp.stack([_mixed(G, inverse[i]) for i in range(m)])
    for i in range(m):
        x = x + K[i] * apart[i]
    for i in range(m):
        root = _mixed(G, lower[i]) * jnp.where(missing[i], 0.0, 1 / jnp.sqrt(variances[i]))
        P = P - outer(root, root)
    P = P - _lost(_rows(H, P), K, r)
    variance = jnp.where(jnp.stack(missing), 0.0, jnp.stack(variances))
    none = jnp.zeros(())
    filled = [jnp.stack([*row, *[none] * (m - len(row))]) for row in lower]
    return (x, P, jnp.stack(y), variance, k), (K, jnp.stack(filled), jnp.stack(weights))


def _in_turn(
    within: list[Numbers], r: Numbers, missing: Numbers
) -> tuple[Numbers, Numbers, list[Numbers]]:
    """Variances, weights 1 / s and combinations of rows of the scalar updates, from H P H'.

    Each corrects in Joseph's form what the ones after it see, so that a measurement that repeats an
    earlier, precise one keeps the digits of its variance.
    """
    m = len(r)
    lower = [[jnp.ones(()) if i == j else jnp.zeros(()) for j in range(i + 1)] for i in range(m)]
    variances: Numbers = []
    weights: Numbers = []
    for i in range(m):
        variances.append(within[i][i] + r[i])
        weights.append(jnp.where(missing[i], 0.0, 1 / variances[i]))
        share = [within[i][j] * weights[i] for j in range(m)]
        lost = [(within[i][j] - share[j] * within[i][i] - r[i] * share[j]) / 2 for j in range(m)]
        within = [[_left(within, share, lost, i, j, q) for q in range(m)] for j in range(m)]
        for j in range(i + 1, m):
            mixed = [lower[j][q] - share[j] * lower[i][q] for q in range(i + 1)]
            lower[j] = [*mixed, *lower[j][i + 1 :]]
    return variances, weights, lower


def _left(within: list[Numbers], share: Numbers, lost: Numbers, i: int, j: int, q: int) -> Array:
    """An entry of H P H' after the measurement i."""
    first, last = min(j, q), max(j, q)
    if first <= i:
        return within[first][last]
    left = within[first][last] - share[first] * within[i][last]
    return left - (lost[first] * share[last] + share[first] * lost[last])


@partial(corrected_together.defjvp, symbolic_zeros=True)
def _corrected_together_jvp(at: Any, along: Any) -> tuple[Any, Any]:
    """The derivatives of the scalar updates, one after another."""
    (x, P, H, r, z), (dx, dP, dH, dr, dz) = at, along
    found = corrected_together(x, P, H, r, z)
    _, _, y, s, k = found
    dx, dP, dr, dz = given(dx, x), given(dP, P), given(dr, r), given(dz, z)
    across = None if none(dH) else dH @ P
    parts = []
    for i, h in enumerate(H):
        seen = s[i] != 0
        weight = jnp.where(seen, 1 / jnp.where(seen, s[i], 1.0), 0.0)
        dg, dy, ds = by(dP, h), dz[i] - (h * dx).sum(), dr[i]
        if across is not None:
            dg, dy = dg + across[i], dy - (dH[i] * x).sum()
            for j in range(i):  # P before this one is P - sum s k k'
                dg = dg - k[j] * (s[j] * (k[j] * dH[i]).sum())
            ds = ds + s[i] * (k[i] * dH[i]).sum()
        ds, dy = ds + (h * dg).sum(), jnp.where(seen, dy, 0.0)
        dk = weight * (dg - k[i] * ds)
        # d(g g' / s) = Z k' + k Z' with Z = dg - k ds / 2.
        half = outer(dg - k[i] * (ds / 2), k[i])
        dP = dP - (half + half.T)
        dx, x = dx + k[i] * dy + dk * y[i], x + k[i] * y[i]
        parts.append((dy, jnp.where(seen, ds, 0.0), dk))
    return found, (dx, dP, *(jnp.stack(part) for part in zip(*parts, strict=True)))


def _rows(H: Array, P: Array) -> Array:
    """H P for a symmetric P, of few rows: written out they become vector code, a product not."""
    across: Array = jax.lax.optimization_barrier(H.T)
    return (across[:, :, None] * P[:, None, :]).sum(axis=0)


def _lost(seen: Array, K: Array, r: Array) -> Array:
    """What rounding leaves of (A H' - K R) K', its symmetric part."""
    lost = jnp.zeros(())
    for j, gain in enumerate(K):
        half = (seen[j] - r[j] * gain) / 2
        lost = lost + (outer(half, gain) + outer(gain, half))
    return lost


def _mixed(rows: Any, shares: Numbers) -> Array:
    total: Array = rows[0] * shares[0]
    for j in range(1, len(shares)):
        total = total + rows[j] * shares[j]
    return total


def _dot(lower: list[Numbers], scaled: list[Numbers], i: int, j: int) -> Array:
    """An entry of lower' scaled."""
    first = max(i, j)
    total = lower[first][i] * scaled[first][j]
    for q in range(first + 1, len(lower)):
        total = total + lower[q][i] * scaled[q][j]
    return total


def outer(a: Array, b: Array) -> Array:
    """a b'."""
    return a[:, None] * b[None, :]
