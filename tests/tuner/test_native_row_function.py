"""A function of rows in C, against JAX's."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from tests.tuner.code.compiled import needed
from tuner.native import row_function
from tuner.native.row_function import RowFunction

ROWS = np.random.default_rng(0).normal(size=(5, 3))


def curved(x):
    return jnp.stack([jnp.exp(x[0]) * x[1], jnp.where(x[2] > 0, jnp.sin(x[2]), x[1] ** 3), 2.0])


def slopes(x):
    return jax.jacfwd(curved)(x).ravel()


@pytest.mark.parametrize("function", [curved, slopes])
def test_rows_equal_jax_s(function, tmp_path):
    needed("cc")
    found = RowFunction(function, 3, tmp_path / "code")(ROWS)
    np.testing.assert_allclose(found, np.array([function(x) for x in ROWS]), rtol=1e-14)
    assert list((tmp_path / "code").glob("*.so"))


@pytest.mark.parametrize("function", [jnp.sort, lambda x: jnp.tile(jnp.exp(x), 30)])
def test_without_c_jax_computes_it(function, tmp_path, monkeypatch):
    monkeypatch.setattr(row_function, "MOST", 2)
    wanted = np.array([function(x) for x in ROWS])
    for rows in (ROWS, ROWS[:1]):
        found = RowFunction(function, 3, tmp_path / "code")(rows)
        np.testing.assert_allclose(found, wanted[: len(rows)], rtol=1e-14)
    assert not (tmp_path / "code").exists()
