"""JAX functions evaluated by NumPy, against the same compiled."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from jax import Array

from filters import ConstantAcceleration, ConstantAccelerationNoise
from objectives import care, dare
from objectives.in_numpy import Method, evaluate, in_numpy
from objectives.in_numpy.evaluate import KNOWN

A = np.random.default_rng(0).standard_normal((4, 4)) / 2
C = np.eye(2, 4)
FOUR = np.arange(4)
LAST = np.array([[0, 1], [3, 2]])


def _shapes(a: Array) -> Any:
    wide = jnp.concatenate([a[::-1], jnp.pad(a, ((1, 0), (2, 1)))[:, :4]])
    return (
        wide.reshape(3, 3, 4).transpose(2, 0, 1),
        jnp.kron(a, a[:2]),
        jnp.stack([jnp.tril(a), jnp.roll(a, 1, 0)], axis=1),
        jnp.split(a, [1, 3]),
        jnp.unstack(a, axis=1),
        jnp.broadcast_to(a[:, None], (4, 2, 4)),
        jax.lax.pad(a, 7.0, [(-1, 2, 1), (2, -1, 0)]),
        jax.lax.pad(a[:, :1], 7.0, [(-2, -3, 2), (1, 0, 3)]),
    )


def _sums(a: Array) -> Any:
    told = (a.sum(0), a.prod(1), a.max(), a.min(1), a.std(), jnp.median(a), jnp.cumsum(a, 1))
    order = (jnp.argmax(a, 1), jnp.argmin(a), jnp.sort(a, 0), jnp.argsort(a, 1), (a > 0).any(0))
    return (*told, *order, jnp.cumprod(a[::-1]), jax.lax.cummax(a, 1, reverse=True))


def _numbers(a: Array) -> Any:
    size = abs(a)
    roots = (jnp.sqrt(size), size**0.3, a**3, a**-2, jnp.cbrt(a), jax.lax.rsqrt(size))
    curves = (jnp.exp(a), jnp.expm1(a), jnp.log(size), jnp.log1p(size), jax.nn.sigmoid(9 * a))
    angles = (jnp.sin(a), jnp.cos(a), jnp.tan(a), jnp.arctan2(a, a.T), jnp.tanh(a), jnp.hypot(a, 1))
    whole = (jnp.round(9 * a), jnp.floor(9 * a), jnp.sign(a), (99 * a).astype(int) // 7, a % 0.3)
    special = (jax.scipy.special.gammaln(size), jax.scipy.special.erf(a), jnp.clip(a, -0.1, 0.2))
    truth = ((a > 0) & (a < 0.5) | ~jnp.isfinite(a), jnp.where(a > 0, a, -1.0), jnp.nan_to_num(a))
    return (*roots, *curves, *angles, *whole, *special, *truth)


def _places(a: Array) -> Any:
    read = (
        a[LAST],
        a[LAST, LAST.T],
        jnp.take(a, 9, axis=0),
        jax.vmap(lambda row, i: row[i])(a, FOUR),
    )
    computed = jnp.argmax(a[0])
    own = jax.lax.dynamic_update_slice(a, a[:2, :2], (computed, 1))
    written = (a.at[LAST].set(2.0), a.at[1].add(a[0]), a.at[LAST, 1].multiply(3.0), own)
    return (*read, a[computed], *written, jnp.searchsorted(jnp.sort(a[0]), a[1]))


def _products(a: Array) -> Any:
    many = jnp.stack([a, a.T])
    solved = (jnp.linalg.solve(a, C.T), jnp.linalg.inv(many), jnp.linalg.det(a))
    factor = jnp.linalg.cholesky(a @ a.T + jnp.eye(4))
    triangle = jax.scipy.linalg.solve_triangular(factor, a, lower=True, trans=1)
    poles, directions = jnp.linalg.eig(a)
    modes = (jnp.linalg.eigvals(many), poles.real, poles.imag, directions)
    products = (jnp.einsum("kij,kjl->lki", many, many), jnp.diag(a))
    return (*solved, factor, triangle, *modes, *products)


def _loops(a: Array) -> Any:
    def sums(total: Array, row: Array) -> tuple[Array, Array]:
        return total + row, total @ row

    def until(number: Array) -> Array:
        return jax.lax.while_loop(lambda n: n < 5, lambda n: 2 * n + 1, number)

    forth, back = (jax.lax.scan(sums, a[0], a, reverse=reverse) for reverse in (False, True))
    chosen = jax.lax.switch(jnp.argmax(a[0]), [jnp.sin, jnp.cos, jnp.exp, jnp.tan], a)
    return forth, back, jax.vmap(until)(a[0]), jax.lax.optimization_barrier((chosen, a))


def _slopes(a: Array) -> Any:
    def whole(a: Array) -> Array:
        return jnp.sum(jnp.log(abs(jnp.linalg.solve(a, C.T)))) + jnp.sum(jnp.exp(a @ a))

    def of_rows(a: Array) -> Array:
        first, *_ = a
        return jax.lax.scan(lambda x, row: (jnp.sin(x * row), x @ row), first, a)[1].sum()

    return (
        jax.grad(whole)(a),
        jax.grad(of_rows)(a),
        jax.jvp(whole, (a,), (a,)),
        jax.hessian(lambda a: (a**3).sum())(a),
    )


@pytest.mark.parametrize(
    "function",
    [_shapes, _sums, _numbers, _places, _products, _loops, _slopes],
    ids=lambda function: function.__name__[1:],
)
def test_numbers_are_those_of_the_compiled_function(function: Callable[[Array], Any]) -> None:
    ours, theirs = _without_compiling(function, A), jax.jit(function)(A)
    assert jax.tree.structure(ours) == jax.tree.structure(theirs)
    for mine, other in zip(jax.tree.leaves(ours), jax.tree.leaves(theirs), strict=True):
        assert isinstance(mine, np.ndarray)
        assert (mine.shape, mine.dtype) == (other.shape, other.dtype)
        # Rounding alone, of the largest number there.
        np.testing.assert_allclose(mine, other, rtol=1e-12, atol=1e-13)


def test_riccati_equations_are_solved_as_by_scipy() -> None:
    W, V = A @ A.T, np.eye(2)
    discrete, continuous = (_without_compiling(solve, A, C, W, V) for solve in (dare, care))
    np.testing.assert_allclose(
        discrete, scipy.linalg.solve_discrete_are(A.T, C.T, W, V), rtol=1e-10
    )
    np.testing.assert_allclose(
        continuous, scipy.linalg.solve_continuous_are(A.T, C.T, W, V), rtol=1e-10
    )


def _without_compiling(function: Callable[..., Any], *arguments: Any) -> Any:
    """As :func:`in_numpy`, where nothing may be left to the compiler."""
    traced = jax.jit(function).trace(*arguments)
    assert _operations(traced.jaxpr.jaxpr) <= KNOWN.keys()
    return in_numpy(function, *arguments)


def _operations(jaxpr: Any) -> set[str]:
    found = {equation.primitive.name for equation in jaxpr.eqns}
    for equation in jaxpr.eqns:
        inside = jax.tree.leaves(
            list(equation.params.values()), is_leaf=lambda part: hasattr(part, "jaxpr")
        )
        found |= {
            name
            for part in inside
            if hasattr(getattr(part, "jaxpr", part), "eqns")
            for name in _operations(getattr(part, "jaxpr", part))
        }
    return found


def test_an_operation_that_numpy_has_not_is_compiled() -> None:
    found = in_numpy(lambda a: jnp.linalg.eigh(a + a.T)[0], A)
    np.testing.assert_allclose(found, np.linalg.eigvalsh(A + A.T), atol=1e-13)
    np.testing.assert_allclose(in_numpy(jnp.fft.rfft, A), np.fft.rfft(A), atol=1e-13)


def test_a_function_that_asks_for_its_numbers_is_called_as_it_is() -> None:
    assert in_numpy(lambda a: {"k": float(a) if a > 1 else 0.0}, np.array(2.0))["k"] == 2.0


def test_equal_methods_are_traced_once() -> None:
    times = []

    class Counted(ConstantAcceleration):
        def derive(self, params: ConstantAccelerationNoise) -> dict[str, Array]:
            times.append(self)
            return {"ratio": params.q / params.R}

    for R in (1.0, 2.0):
        noise = ConstantAccelerationNoise(np.array(4.0), np.array(R))
        found = in_numpy(Method(Counted(0.5), "derive"), noise)
        assert found["ratio"] == 4.0 / R
    assert len(times) == 1


def test_names_keep_their_order() -> None:
    assert [*in_numpy(lambda a: {"Q": a, "K": a + 1}, np.array(2.0))] == ["Q", "K"]
    asked = in_numpy(lambda a: {"Q": float(a), "K": 1.0}, np.array(2.0))
    assert [*asked] == ["Q", "K"]


def test_missing_numbers_stay_missing() -> None:
    gone = np.array([1.0, np.nan, np.inf])
    found = in_numpy(lambda a: (jnp.where(jnp.isnan(a), 0.0, a), jnp.maximum(a, 0), a.sum()), gone)
    assert found[0].tolist() == [1.0, 0.0, np.inf]
    assert np.isnan(found[1][1])
    assert np.isnan(found[2])


def test_a_matrix_without_a_factor_has_none() -> None:
    assert np.isnan(in_numpy(jnp.linalg.cholesky, -np.eye(2))[np.tril_indices(2)]).all()
    assert np.isnan(in_numpy(jnp.linalg.eigvals, np.full((2, 2), np.nan))).all()


def test_what_is_called_often_is_compiled(monkeypatch):
    def root(a):
        return {"root": jnp.sqrt(a), "a": a}

    monkeypatch.setattr(evaluate, "OFTEN", 4)
    monkeypatch.setattr(evaluate, "AS_MANY", 0)
    compiled = evaluate._jitted(root)[0]
    for calls in range(1, 7):
        assert [*in_numpy(root, np.array(4.0)).items()] == [("root", 2.0), ("a", 4.0)]
        assert compiled._cache_size() == (calls > 4)
