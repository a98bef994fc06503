"""The two steps of a covariance with their ways back by hand, for a gradient that goes backwards.

They take the place of :mod:`filters.covariance_step` and :mod:`filters.together_step` in a time
loop that is differentiated backwards alone. What the transposed derivatives would take one after
another is taken in products here: for m measurements one of their gains with the weights of P.
"""

from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from filters.covariance_step import corrected, corrected_weighted, given, none, predicted
from filters.invariant import Swap
from filters.small_linalg import LARGEST, congruence, contracted, matmul
from filters.together_step import Together, corrected_kept, corrected_together, outer


@jax.custom_vjp
def _predicted(F: Array, across: Array, P: Array, W: Array) -> Array:
    return predicted(F, across, P, W)


def _predicted_forwards(F: Any, across: Any, P: Any, W: Any) -> tuple[Array, Any]:
    found = predicted(F.value, across.value, P.value, W.value)
    kept = P.value if F.perturbed or across.perturbed else None
    return found, (F.value, across.value, kept)


def _predicted_backwards(kept: Any, B: Any) -> Any:
    F, across, P = kept
    # What is not symmetric in B has no effect on a symmetric P.
    B = given(B, F)
    by_F = None if P is None else _times(B + B.T, _times(F, P))
    return by_F, None, congruence(across, F, B), B


_predicted.defvjp(_predicted_forwards, _predicted_backwards, symbolic_zeros=True)


@jax.custom_vjp
def _together(x: Array, P: Array, H: Array, r: Array, z: Array) -> Together:
    return corrected_together(x, P, H, r, z)


def _together_forwards(x: Any, P: Any, H: Any, r: Any, z: Any) -> tuple[Together, Any]:
    found, (K, lower, w) = corrected_kept(x.value, P.value, H.value, r.value, z.value)
    _, _, y, _, k = found
    before = (x.value, P.value) if H.perturbed else None
    return found, (H.value, K, lower, y, w, k, jnp.isnan(z.value), before)


def _together_backwards(kept: Any, weights: Any) -> Any:
    """With S = L D L', N = S^-1, w = D^-1: y = L^-1 v, x+ = x + G' N v, P+ = P - G' N G."""
    H, K, lower, y, w, k, missing, before = kept
    X, B, by_y, by_s, by_k = weights
    X, B = given(X, H[0]), given(B, jnp.zeros(2 * H.shape[1:]))
    by_y, by_s = (jnp.where(missing, 0.0, given(part, w)) for part in (by_y, by_s))
    wy = w * y
    a = (lower * wy[:, None]).sum(axis=0)
    twice = B + B.T
    KB = _times(K, twice)
    b = (K * X).sum(axis=1)
    within = jnp.diag(by_s) - jnp.tril(by_y[:, None] * wy[None, :], -1)
    by_G = a[:, None] * X - KB
    if not none(by_k):
        by_g = w[:, None] * by_k
        within = within - jnp.tril(matmul(by_g, k.T))
        by_G = by_G + matmul(lower.T, by_g)
    by_S = matmul(matmul(lower.T, within), lower) - b[:, None] * a[None, :]
    by_S = by_S + matmul(KB, K.T) / 2
    by_S = (by_S + by_S.T) / 2
    by_G = by_G + matmul(by_S, H)
    by_v = b + matmul(lower.T, by_y)
    by_P = twice
    for h, g in zip(H, by_G, strict=True):
        by_P = by_P + (outer(h, g) + outer(g, h))
    by_H = None
    if before is not None:
        x, P = before
        G = _times(H, P)
        by_H = matmul(by_S, G) + _times(by_G, P) - by_v[:, None] * x
    return X - matmul(by_v, H), by_P / 2, by_H, jnp.diagonal(by_S), by_v


_together.defvjp(_together_forwards, _together_backwards, symbolic_zeros=True)


@jax.custom_vjp
def _alone(x: Array, P: Array, h: Array, r: Array, z: Array) -> Together:
    return corrected(x, P, h, r, z)


def _alone_forwards(x: Any, P: Any, h: Any, r: Any, z: Any) -> tuple[Together, Any]:
    found, w = corrected_weighted(x.value, P.value, h.value, r.value, z.value)
    _, _, y, _, k = found
    before = (x.value, P.value) if h.perturbed else None
    return found, (h.value, y, w, k, jnp.any(jnp.isnan(z.value)), before)


def _alone_backwards(kept: Any, weights: Any) -> Any:
    h, y, w, k, missing, before = kept
    X, B, *rest = weights
    one = [part if none(part) else part[None] for part in rest]
    many = h[None], k[None], jnp.ones((1, 1)), y[None], w[None], k[None], missing[None], before
    X, B, by_h, by_r, by_z = _together_backwards(many, (X, B, *one))
    return X, B, None if by_h is None else by_h[0], by_r[0], by_z[0]


_alone.defvjp(_alone_forwards, _alone_backwards, symbolic_zeros=True)


STEPS: dict[str, Swap] = {
    "predicted": (_predicted, (2, 2, 2, 2)),
    "corrected": (_alone, (1, 2, 1, 0, 0)),
    "corrected_together": (_together, (1, 2, 2, 1, 1)),
}
"""The functions that have a way back, by the names of those whose place they take."""


def _times(A: Array, B: Array) -> Array:
    """A B for a symmetric A or few rows."""
    if len(B) <= LARGEST:
        return matmul(A, B)
    return contracted(jax.lax.optimization_barrier(A.T), B)
