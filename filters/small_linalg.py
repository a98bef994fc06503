"""Products and solves of small matrices, written out so that XLA fuses them and batches are cheap.

A batch of ``jnp.linalg.solve`` calls LAPACK once a matrix, from a loop that XLA does not compile,
and a batch of matrix products or of sums over three entries is not vectorised. Sums of whole rows
and columns are: a thousand 3 x 3 products take a tenth of the time.
"""

from collections.abc import Callable
from functools import reduce
from typing import Any, ParamSpec, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

Arguments = ParamSpec("Arguments")
Tree = TypeVar("Tree")

LARGEST = 8  # above it what is written out compiles slowly, and the libraries are worth their call


def traced_once(function: Callable[Arguments, Array]) -> Callable[Arguments, Array]:
    """The function, traced once for its arguments' shapes however often it stands in a formula.

    What is compiled is the same; a formula of many small products is traced in half of the time.
    """
    kept: Callable[Arguments, Array] = jax.jit(function)
    return kept


def matmul(A: Array, B: Array) -> Array:
    """``A @ B`` for the small matrices of a filter's step.

    XLA fuses a written-out sum into the loop around it; it does not fuse a matrix product.
    For a filter of two states the whole pass takes a fifth less time; where one of 15 multiplies by
    vectors so, a gradient takes a third. Batches of formulas that
    stand in no loop take :func:`product`, whose sums of columns times rows are vectorised.

    Args:
        A: ``(n, k)`` or ``(k,)``.
        B: ``(k, p)`` or ``(k,)``.

    >>> matmul(jnp.array([[1.0, 2.0]]), jnp.array([3.0, 4.0])).tolist()
    [11.0]
    """
    if A.shape[-1] > LARGEST and A.ndim == B.ndim == 2:
        return A @ B
    lone = A.ndim == 1
    wide = (A[None] if lone else A).reshape((-1, A.shape[-1]) + (1,) * (B.ndim - 1))
    product = (wide * B[None]).sum(axis=1)
    return product[0] if lone else product


def contracted(A: Array, B: Array) -> Array:
    """``A' B`` for the small matrices of a filter's step.

    Where the first axes are contracted XLA makes vector code of a product within a time loop, of 7
    to 20 rows; of ``A @ B`` it makes a loop over single numbers.

    Args:
        A: ``(k, n)``.
        B: ``(k, p)`` or ``(k,)``.

    >>> contracted(jnp.array([[1.0, 3.0], [2.0, 4.0]]), jnp.array([1.0, 1.0])).tolist()
    [3.0, 7.0]
    """
    if B.ndim == 1:
        return (A * B[:, None]).sum(axis=0)
    return jax.lax.dot_general(A, B, (((0,), (0,)), ((), ())))


def turned(A: Array) -> Array:
    """``A'``; of a larger matrix as an array of its own, so that no product reads it across."""
    kept: Array = A.T if len(A) <= LARGEST else jax.lax.optimization_barrier(A.T)
    return kept


def unfolded(params: Tree, inputs: Any) -> Tree:
    """Parameters of which XLA cannot know that their larger matrices are constants.

    Loops over a known matrix are unrolled into single numbers; over any other, of 9 rows and more,
    they become vector code.

    Args:
        params: any pytree.
        inputs: any pytree that is known only when the code runs: of it one number is looked at.
    """
    numbers = [leaf for leaf in jax.tree.leaves(inputs) if _real(leaf) and leaf.size]
    if not numbers:
        return params
    number = numbers[0][(0,) * numbers[0].ndim]
    always = (number > 0) | (number <= 0) | jnp.isnan(number)

    def one(leaf: Any) -> Any:
        if not _real(leaf) or leaf.ndim != 2 or min(leaf.shape) <= LARGEST:
            return leaf
        return jnp.where(always, leaf, jnp.zeros((), leaf.dtype))

    found: Tree = jax.tree.map(one, params)
    return found


def _real(leaf: Any) -> bool:
    return isinstance(leaf, jax.Array | np.ndarray) and jnp.issubdtype(leaf.dtype, jnp.floating)


def congruence(F: Array, across: Array, P: Array) -> Array:
    """``F P F'`` for a symmetric P: written out where it is small, else in vector code.

    Args:
        F: ``(n, n)``.
        across: ``turned(F)``, not read where n is small.
        P: ``(n, n)``, symmetric.
    """
    if F.shape[0] <= LARGEST:
        return matmul(matmul(F, P), F.T)
    return contracted(across, contracted(P, across))


def product(*factors: Array) -> Array:
    """The matrices' product from left to right, as sums of columns times rows.

    Args:
        factors: ``(n, k)``, ``(k, p)``, ... in the order of the product.

    >>> product(jnp.eye(2), jnp.array([[1.0], [2.0]]), jnp.array([[3.0]])).ravel().tolist()
    [3.0, 6.0]
    """
    return reduce(_pair, factors)


def solve(A: Array, B: Array) -> Array:
    """``A^-1 B`` by Gauss-Jordan elimination with scaled partial pivoting.

    A pivot is chosen by its share of its row's largest entry, so the units of the equations do not
    decide. Differentiable in both modes; above 8 unknowns it is ``jnp.linalg.solve``.

    Args:
        A: ``(n, n)``, regular.
        B: right-hand sides, ``(n, p)``.

    Returns:
        ``(n, p)``; not finite where a pivot vanishes: A is singular, and exactly so.

    >>> solve(jnp.array([[0.0, 2.0], [1.0, 0.0]]), jnp.array([[4.0], [3.0]])).ravel().tolist()
    [3.0, 2.0]
    """
    if A.shape[0] > LARGEST:
        X: Array = jnp.linalg.solve(A, B)
        return X
    X = jax.lax.custom_linear_solve(
        lambda X: product(A, X),
        B,
        solve=lambda _, B: _gauss_jordan(A, B),
        transpose_solve=lambda _, B: _gauss_jordan(A.T, B),
    )
    return X


@traced_once
def _pair(A: Array, B: Array) -> Array:
    if A.shape[1] > LARGEST:
        return A @ B
    return reduce(jnp.add, [A[:, k : k + 1] * B[k : k + 1] for k in range(A.shape[1])])


@traced_once
def _gauss_jordan(A: Array, B: Array) -> Array:
    n = A.shape[0]
    size = reduce(jnp.maximum, [jnp.abs(A[:, j : j + 1]) for j in range(n)])
    work = jnp.concatenate([A, B], axis=1) / jnp.where(size > 0, size, 1.0)
    done: Array = jax.lax.fori_loop(0, n, _eliminate, work)
    return done[:, n:]


def _eliminate(k: Array, work: Array) -> Array:
    """Bring the largest entry of column k to row k, and clear the column with it."""
    own = jax.lax.dynamic_index_in_dim(work, k, 0, keepdims=False)
    column = jax.lax.dynamic_index_in_dim(work, k, 1, keepdims=False)
    best, row, chosen = jnp.asarray(-1.0, work.dtype), own, k
    for i in range(len(work)):
        larger = (i >= k) & (jnp.abs(column[i]) > best)
        best = jnp.where(larger, jnp.abs(column[i]), best)
        row = jnp.where(larger, work[i], row)
        chosen = jnp.where(larger, i, chosen)
    rows = jnp.arange(len(work))
    row = row / jax.lax.dynamic_index_in_dim(row, k, 0, keepdims=False)
    factor = jnp.where(rows == chosen, column[k], column)
    swapped = jnp.where((rows == chosen)[:, None], own, work)
    return jnp.where((rows == k)[:, None], row, swapped - factor[:, None] * row)


def semidefinite_root(P: Array) -> Array:
    """The lower triangular root of a covariance, ``P = root root'``, also where it is singular.

    Cholesky's factorisation, with a column of zeros where rounding alone is left of a variance.

    Args:
        P: ``(n, n)``, symmetric, positive semi-definite.

    Returns:
        ``(n, n)``. Its derivatives are finite everywhere; where a column is 0 they are 0 as well.

    >>> semidefinite_root(jnp.array([[4.0, 2.0], [2.0, 1.0]])).tolist()
    [[2.0, 0.0], [1.0, 0.0]]
    """
    n = P.shape[0]
    rows = jnp.arange(n)
    least = 8 * n * jnp.finfo(P.dtype).eps * jnp.diagonal(P)

    def column(j: Array, work: tuple[Array, Array]) -> tuple[Array, Array]:
        left, root = work
        own = jax.lax.dynamic_index_in_dim(left, j, 1, keepdims=False)
        pivot = jax.lax.dynamic_index_in_dim(own, j, 0, keepdims=False)
        there = pivot > jax.lax.dynamic_index_in_dim(least, j, 0, keepdims=False)
        over = jnp.where(there, 1 / jnp.sqrt(jnp.where(there, pivot, 1.0)), 0.0)
        found = jnp.where(rows >= j, own, 0.0) * over
        root = jax.lax.dynamic_update_index_in_dim(root, found, j, 1)
        return left - jnp.outer(found, found), root

    found: Array = jax.lax.fori_loop(0, n, column, (P, jnp.zeros_like(P)))[1]
    return found
