"""The dual simplex method of the time loop against HiGHS."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import linprog

from filters.linear_program import optimum

ROWS, FREE, SPREADS, LANES = 9, 2, 2, 48
# Without the compiler's optimisation, which changes no formula and takes most of the time.
solve = jax.jit(optimum, compiler_options={"xla_backend_optimization_level": 0})


def programs(seed):
    """Random ones, some without a solution, some whose p is not determined, some with c = 0."""
    rng = np.random.default_rng(seed)
    A = rng.uniform(-1, 1, (ROWS, FREE + SPREADS, LANES))
    b, c = rng.uniform(-1, 1, (ROWS, LANES)), rng.uniform(0, 1, (SPREADS, LANES))
    A[:, FREE:, ::2] = np.abs(A[:, FREE:, ::2])  # enough s then meets every side
    A[:, 1, 5::7] = 2 * A[:, 0, 5::7]
    c[0, 3::8] = 0.0
    return A, b, c


def highs(A, b, c):
    cost = np.concatenate([np.zeros(FREE), c])
    bounds = [(None, None)] * FREE + [(0, None)] * SPREADS
    return linprog(cost, -A, -b, bounds=bounds, method="highs")


@pytest.mark.parametrize("seed", range(4))
def test_random_programs_are_those_of_highs(seed):
    A, b, c = programs(seed)
    z, multiplier = (np.asarray(part) for part in solve(A, b, c))
    ended = {"solved": 0, "without a solution": 0, "not determined": 0}
    for i in range(LANES):
        wanted = highs(A[..., i], b[:, i], c[:, i])
        if np.linalg.matrix_rank(A[:, :FREE, i]) < FREE:
            ended["not determined"] += 1
            assert np.isnan(multiplier[i])
        elif wanted.status == 2:
            ended["without a solution"] += 1
            assert np.isnan(multiplier[i])
        else:
            ended["solved"] += 1
            assert multiplier[i] > -1e-12
            assert c[:, i] @ z[FREE:, i] == pytest.approx(wanted.fun, abs=1e-9)
            assert (A[..., i] @ z[:, i] - b[:, i]).min() > -1e-10
            if multiplier[i] > 1e-9:
                np.testing.assert_allclose(z[:, i], wanted.x, atol=1e-8)
    assert min(ended.values()) > 0


def test_programs_side_by_side_do_not_know_of_each_other():
    A, b, c = programs(0)
    z = np.asarray(solve(A, b, c).z)
    turned = np.asarray(solve(A[..., ::-1], b[:, ::-1], c[:, ::-1]).z)[:, ::-1]
    np.testing.assert_array_equal(z, turned)


def test_a_derivative_by_all_that_is_given():
    """By differences, of the programs whose optimum is unique."""
    A, b, c = programs(1)
    sure = np.asarray(solve(A, b, c).multiplier) > 1e-3
    rng = np.random.default_rng(0)
    dA, db = rng.normal(size=A.shape), rng.normal(size=b.shape)
    along = jax.jvp(lambda A, b: optimum(A, b, jnp.asarray(c)).z, (A, b), (dA, db))[1]
    step = 1e-7
    ahead, behind = (np.asarray(solve(A + s * dA, b + s * db, c).z) for s in (step, -step))
    assert sure.sum() > LANES / 4
    np.testing.assert_allclose(
        np.asarray(along)[:, sure], ((ahead - behind) / (2 * step))[:, sure], rtol=1e-4, atol=1e-4
    )
