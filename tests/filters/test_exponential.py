"""The matrix exponential and its derivative against SciPy's."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg

from filters.exponential import expm


@pytest.mark.parametrize("size", [0.0, 1e-8, 0.1, 1.0, 30.0, 1000.0])
def test_scipys_at_all_sizes(size):
    A = np.random.default_rng(1).normal(size=(5, 5))
    A = size * (A - 3 * np.eye(5)) / np.abs(A).sum()
    found, wanted = np.asarray(expm(jnp.asarray(A))), scipy.linalg.expm(A)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())


@pytest.mark.parametrize("size", [0.3, 20.0])
def test_its_derivative_is_frechets_forwards_and_backwards(size):
    A, E = size * np.random.default_rng(2).normal(size=(2, 4, 4)) / 4
    wanted = scipy.linalg.expm_frechet(A, E, compute_expm=False)
    _, forwards = jax.jvp(expm, (jnp.asarray(A),), (jnp.asarray(E),))
    scale = np.abs(wanted).max()
    np.testing.assert_allclose(forwards, wanted, rtol=0, atol=1e-11 * scale)
    backwards = jax.grad(lambda at: expm(at).sum())(jnp.asarray(A))
    assert float((backwards * E).sum()) == pytest.approx(wanted.sum(), abs=1e-11 * scale)


def test_what_is_too_large_is_not_a_number():
    assert np.isnan(expm(jnp.array([[-1e6]]))).all()
    assert float(expm(jnp.array([[-3e5]]))[0, 0]) == 0.0


def test_single_precision_stays_single():
    found = expm(jnp.full((2, 2), 0.5, jnp.float32))
    assert found.dtype == jnp.float32
    np.testing.assert_allclose(found, scipy.linalg.expm(np.full((2, 2), 0.5)), rtol=1e-6)
