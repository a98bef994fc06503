"""Records end to end and in lines are the records one by one."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import (
    Joined,
    Lanes,
    LinearKalman,
    LinearModel,
    Sample,
    Transition,
    joined,
    packed,
    run,
)
from objectives import Data, InnovationLikelihood, score, score_and_gradient

RNG = np.random.default_rng(4)
RECORDS = [Sample(jnp.asarray(RNG.normal(size=(k, 1)))) for k in (5, 11, 1, 7)]
POINT = np.array([0.2, -0.3])


def build(point):
    q, r = jnp.exp(point)
    step = Transition(jnp.array([[1.0, 0.1], [0.0, 0.9]]), jnp.eye(2), q * jnp.eye(2))
    return LinearModel(step, jnp.ones((1, 2)), r[None], jnp.eye(2), jnp.zeros(2))


def test_end_to_end_is_one_by_one():
    ran = jax.jit(run, static_argnums=0)
    together = ran(Joined(LinearKalman()), build(POINT), joined(RECORDS))[1]
    apart = [ran(LinearKalman(), build(POINT), record)[1] for record in RECORDS]
    for found, *wanted in zip(*map(jax.tree.leaves, (together, *apart)), strict=True):
        np.testing.assert_allclose(found, np.concatenate(wanted), rtol=0, atol=1e-14)


@pytest.mark.parametrize("way", ["forwards", "backwards"])
def test_in_lines_the_likelihood_is_the_same(way):
    likelihood, line = InnovationLikelihood(), packed(RECORDS, 3)
    assert line.begins.shape == (11, 3)
    data = Data(line, jnp.zeros(11))
    filter = Lanes(Joined(LinearKalman()), 3)
    value, slope = score_and_gradient(filter, likelihood, build, POINT, data, way=way)

    def alone(point):
        each = [
            (
                score(LinearKalman(), likelihood, build(point), Data(r, jnp.zeros(len(r.z)))),
                len(r.z),
            )
            for r in RECORDS
        ]
        return sum(mean * count for mean, count in each) / sum(count for _, count in each)

    wanted = jax.jit(jax.value_and_grad(alone))(POINT)
    np.testing.assert_allclose(value, wanted[0], rtol=1e-13)
    np.testing.assert_allclose(slope, wanted[1], rtol=0, atol=1e-12 * np.abs(wanted[1]).max())


def test_records_without_samples_and_too_many_lines_are_refused():
    with pytest.raises(ValueError, match="without samples"):
        joined([Sample(jnp.zeros((0, 1)))])
    with pytest.raises(ValueError, match="5 lines of 4 records: give from 1 to 4"):
        packed(RECORDS, 5)
