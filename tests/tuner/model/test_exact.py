"""Exact steps against matrix exponentials of another kind; and examples in docstrings."""

import doctest
import importlib
import pkgutil

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

import tuner.model
from filters import van_loan
from tuner.model.exact import exact

compiled = jax.jit(exact)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("size", [1e-3, 1.0, 30.0, 1e5])
def test_a_step_is_van_loans(seed, size):
    """Short and long for the model; where it is long, its modes die out."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(3, 3))
    A = size * (A - (np.abs(np.linalg.eigvals(A)).max() + 0.1) * np.eye(3))
    B = rng.normal(size=(3, 2))
    step, other = compiled(A, B @ B.T, 0.7), van_loan(A, B, jnp.eye(2), jnp.array(0.7))
    scale = np.abs(other.Q).max()
    np.testing.assert_allclose(step.F, other.F, rtol=0, atol=1e-12)
    np.testing.assert_allclose(step.Q, other.Q, rtol=0, atol=1e-11 * scale)
    beside = np.zeros((6, 6))
    beside[:3, :3], beside[:3, 3:] = A, np.eye(3)
    if size < 1e3:
        pushed = scipy.linalg.expm(0.7 * beside)[:3, 3:]
        np.testing.assert_allclose(step.push, pushed, rtol=0, atol=1e-11 * np.abs(pushed).max())


def test_where_a_power_is_zero_the_series_ends():
    A, S = np.diag([1.0, 1.0, 1.0], 1), np.diag([0.0, 0.0, 0.0, 2.0])
    ended, whole = exact(jnp.asarray(A), jnp.asarray(S), 0.3, nilpotent=4), compiled(A, S, 0.3)
    for one, other in zip(ended, whole, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-13, atol=0)
    assert np.linalg.eigvalsh(ended.Q)[0] > 0


@given(st.integers(0, 10**6), st.floats(1e-6, 1e3))
@settings(max_examples=40, deadline=None)
def test_two_steps_are_one_of_their_length(seed, dt):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(2, 2)) - 3 * np.eye(2)
    B = rng.normal(size=(2, 1))
    half, whole = compiled(A, B @ B.T, dt / 2), compiled(A, B @ B.T, dt)
    np.testing.assert_allclose(half.F @ half.F, whole.F, rtol=0, atol=1e-12)
    twice = half.Q + half.F @ half.Q @ half.F.T
    np.testing.assert_allclose(twice, whole.Q, rtol=0, atol=1e-12 * np.abs(whole.Q).max())


@pytest.mark.parametrize("name", [each.name for each in pkgutil.iter_modules(tuner.model.__path__)])
def test_examples_in_docstrings(name):
    assert doctest.testmod(importlib.import_module(f"tuner.model.{name}")).failed == 0
