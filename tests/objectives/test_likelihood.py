"""The likelihood of innovations against SciPy's normal distribution."""

from typing import NamedTuple

import jax
import numpy as np
import pytest
from scipy.stats import norm

from filters import LinearKalman, LinearModel, Sample, Transition, run
from objectives import Data, InnovationLikelihood, contributions, score

ONE = np.eye(1)


class Outputs(NamedTuple):
    innovation: np.ndarray
    variance: np.ndarray


def folded(y, s, truth):
    fold = InnovationLikelihood()
    total = fold.init()
    for row in zip(y, s, truth, strict=True):
        total, kept = fold.update(total, Outputs(*row[:2]), row[2])
        assert kept is None
    return float(fold.value(total, None))


def test_it_is_the_density_of_what_was_measured():
    rng = np.random.default_rng(1)
    y, s = rng.standard_normal((40, 3)), rng.uniform(0.1, 4.0, (40, 3))
    truth = np.where(rng.random((40, 3)) < 0.3, np.nan, 1.0)
    seen = ~np.isnan(truth)
    mean = -norm.logpdf(y[seen], scale=np.sqrt(s[seen])).mean()
    assert folded(y, s, truth) == pytest.approx(mean, rel=1e-12)


def deviation(y, s, truth):
    return float(InnovationLikelihood().deviation(folded(y, s, truth)))


def test_a_constant_right_variance_comes_back_as_a_deviation():
    y = np.tile([[0.3], [-0.3]], (10, 1))
    assert deviation(y, np.full((20, 1), 0.09), y) == pytest.approx(0.3, rel=1e-12)
    assert deviation(y, np.full((20, 1), 0.18), y) > 0.3
    assert deviation(y, np.full((20, 1), 0.045), y) > 0.3


def test_it_stays_a_number_where_the_density_is_none():
    y = np.full((3, 1), 1e6)
    assert folded(y, np.full((3, 1), 1e-6), y) == pytest.approx(0.5e18, rel=1e-12)
    assert deviation(y, np.full((3, 1), 1e-6), y) == np.inf


def test_what_samples_add_makes_up_the_mean():
    rng = np.random.default_rng(4)
    z = rng.standard_normal((50, 1))
    z[::5] = np.nan
    model = LinearModel(Transition(ONE, ONE, ONE), ONE, np.ones(1), ONE, np.zeros(1))
    data = Data(Sample(z), z)
    nats, counts = contributions(LinearKalman(), InnovationLikelihood(), model, data)
    assert nats.shape == counts.shape == (50, 1)
    assert (np.asarray(nats)[::5] == 0).all()
    mean = float(nats.sum() / counts.sum())
    assert mean == pytest.approx(float(score(LinearKalman(), InnovationLikelihood(), model, data)))


def test_missing_numbers_do_not_count_whatever_their_variance():
    y, s = np.array([[0.3, 0.0], [-0.3, 0.0]]), np.array([[0.09, np.nan], [0.09, -1.0]])
    truth = np.array([[1.0, np.nan], [1.0, np.nan]])
    assert deviation(y, s, truth) == pytest.approx(0.3, rel=1e-12)
    assert np.isnan(folded(y, s, np.full((2, 2), np.nan)))


def test_a_variance_of_zero_does_not_count_and_one_truth_stands_for_all():
    rng = np.random.default_rng(3)
    y, s = rng.standard_normal((40, 3)), rng.uniform(0.1, 4.0, (40, 3))
    gone = rng.random((40, 3)) < 0.3
    told = folded(y, s, np.where(gone, np.nan, 0.0))
    # what a filter returns where nothing was measured
    left = folded(np.where(gone, 0.0, y), np.where(gone, 0.0, s), np.zeros(40))
    assert left == pytest.approx(told, rel=1e-15)
    assert np.isnan(folded(y, 0 * s, np.zeros(40)))


def test_its_gradient_is_finite_beside_a_variance_of_zero():
    fold, y = InnovationLikelihood(), np.array([0.3, 0.0])

    def at(s):
        return fold.value(fold.update(fold.init(), Outputs(y, s), np.zeros(()))[0], None)

    slope = np.asarray(jax.grad(at)(np.array([0.04, 0.0])))
    assert slope[0] != 0
    assert slope[1] == 0


def test_it_is_least_near_the_noise_that_made_the_data():
    rng = np.random.default_rng(2)
    walk = np.cumsum(0.1 * rng.standard_normal(2000))
    z = (walk + rng.standard_normal(2000))[:, None]
    z[::7] = np.nan
    one = np.eye(1)

    @jax.jit
    def at(q):
        model = LinearModel(Transition(one, one, 0.01 * q * one), one, np.ones(1), one, np.zeros(1))
        return score(LinearKalman(), InnovationLikelihood(), model, Data(Sample(z), z))

    values = [float(at(q)) for q in (0.05, 0.3, 1.0, 3.0, 20.0)]
    assert int(np.argmin(values)) in (1, 2, 3)
    assert values[0] > values[2] < values[4]


def test_a_run_keeps_nothing_in_memory():
    z = np.zeros((5, 1))
    one = np.eye(1)
    model = LinearModel(Transition(one, one, one), one, np.ones(1), one, np.zeros(1))
    out = run(LinearKalman(), model, Sample(z))[1]
    by_hand = folded(np.asarray(out.innovation), np.asarray(out.variance), z)
    found = score(LinearKalman(), InnovationLikelihood(), model, Data(Sample(z), z))
    assert float(found) == pytest.approx(by_hand, rel=1e-12)
