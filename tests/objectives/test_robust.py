"""The likelihood behind a gate: a density, that biases little and does not reward refusing."""

from collections import namedtuple

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.stats import multivariate_t, norm

from filters import Gated, LevelSample, LocalLevel, LocalLevelNoise
from filters.student import spread
from objectives import Data, HeavyTails, InnovationLikelihood, PartlyWrong, score

Seen = namedtuple("Seen", "offered predicted")


def amount(y, s, width=100.0, **more):
    likelihood = InnovationLikelihood(PartlyWrong((width,), **more))
    return likelihood.added(Seen(jnp.array([y]), jnp.array([s])), jnp.zeros(1))[0][0]


def test_it_is_the_density_of_scipy():
    y, s, share, width = 3.7, 2.0, 0.02, 50.0
    wanted = -np.log((1 - share) * norm.pdf(y, scale=s**0.5) + share / width)
    assert float(amount(y, s, width, share=share)) == pytest.approx(wanted, rel=1e-12)


def test_it_is_a_density():
    total = quad(lambda y: float(jnp.exp(-amount(y, 2.0))), -50, 50, points=[0], limit=200)[0]
    assert total == pytest.approx(1, abs=1e-8)


def test_numbers_that_are_missing_or_held_out_do_not_count():
    likelihood = InnovationLikelihood(PartlyWrong((10.0, 10.0, 10.0)))
    seen = Seen(jnp.array([1.0, 0.0, 1.0]), jnp.array([1.0, 0.0, 1.0]))
    amounts, counted = likelihood.added(seen, jnp.array([0.0, 0.0, jnp.nan]))
    assert counted.tolist() == [True, False, False]
    assert amounts[1:].tolist() == [0.0, 0.0]


def scale_of(y, width):
    """The variance that the likelihood finds most likely for numbers."""

    def mean(log_s):
        s = jnp.full_like(y, jnp.exp(log_s))
        likelihood = InnovationLikelihood(PartlyWrong((width,) * len(y)))
        return float(likelihood.added(Seen(y, s), jnp.zeros(len(y)))[0].mean())

    return np.exp(minimize_scalar(mean, bounds=(-3, 3), options={"xatol": 1e-6}).x)


def test_where_nothing_is_wrong_it_moves_a_variance_by_less_than_a_hundredth():
    y = norm.ppf((np.arange(20000) + 0.5) / 20000)  # as even as normal numbers can be
    plain = np.mean(y**2)
    # As narrow a range as numbers without an outlier give: the hardest case.
    assert abs(scale_of(jnp.asarray(y), 2 * np.abs(y).max()) / plain - 1) < 0.01


def test_a_twentieth_of_wrong_numbers_moves_it_by_a_few_hundredths():
    y = norm.ppf((np.arange(5000) + 0.5) / 5000)
    wrong = np.linspace(-200, 200, 263)
    found = scale_of(jnp.asarray(np.concatenate([y, wrong])), 400.0)
    assert abs(found - 1) < 0.05
    assert np.mean(np.concatenate([y, wrong]) ** 2) > 600


def test_to_refuse_everything_costs_more_than_to_refuse_what_is_wrong():
    draw = np.random.default_rng(0)
    z = np.cumsum(0.1 * draw.standard_normal(400)) + draw.standard_normal(400)
    z[::20] += 50 * draw.standard_normal(20)
    filter = Gated(LocalLevel(1.0), (((0, 0),),), 4.0)
    data = Data(LevelSample(jnp.asarray(z)), jnp.zeros((400, 1)))
    likelihood = InnovationLikelihood(PartlyWrong((200.0,)))

    def at(q, R):
        return float(score(filter, likelihood, LocalLevelNoise(jnp.array(q), jnp.array(R)), data))

    right = at(0.01, 1.0)
    assert right < at(1e-10, 1e-8) - 5  # refuses all
    assert right < at(0.01, 100.0) - 0.3  # refuses none


def test_its_deviation_is_that_of_the_gaussian_as_likely():
    likelihood = InnovationLikelihood(PartlyWrong((1.0,)))
    nats = -norm.logpdf(0.3 * norm.ppf((np.arange(100000) + 0.5) / 100000), scale=0.3).mean()
    assert float(likelihood.deviation(nats)) == pytest.approx(0.3, rel=1e-4)


def test_student_is_the_multivariate_distribution_of_scipy():
    y, s, nu = np.array([0.7, -4.0, 2.0]), np.array([0.5, 2.0, 3.0]), 4.0
    seen = Seen(jnp.array([*y, 0.0]), jnp.array([*s, 0.0]))
    amounts, counted = InnovationLikelihood(HeavyTails(nu)).added(seen, jnp.zeros(4))
    law = multivariate_t(np.zeros(3), spread(nu, 3) * np.diag(s), df=nu)
    assert counted.tolist() == [True, True, True, False]
    assert float(amounts.sum()) == pytest.approx(-law.logpdf(y), rel=1e-12)
    assert float(amounts[3]) == 0.0


def test_student_of_recordings_side_by_side_is_that_of_each():
    draw, law = np.random.default_rng(1), HeavyTails(4.0)
    y, s = draw.normal(size=(3, 2)), draw.uniform(0.5, 2.0, (3, 2))
    s[1, 0] = 0.0  # is missing
    together = law.added(Seen(jnp.array(y), jnp.array(s)), jnp.ones((3, 1), bool))
    apart = [
        law.added(Seen(jnp.array(a), jnp.array(b)), jnp.ones(1, bool))
        for a, b in zip(y, s, strict=True)
    ]
    for found, *wanted in zip(together, *apart, strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-14)


def test_student_of_many_degrees_is_normal():
    seen = Seen(jnp.array([1.3]), jnp.array([2.0]))
    amount = InnovationLikelihood(HeavyTails(1e7)).added(seen, jnp.zeros(1))[0][0]
    assert float(amount) == pytest.approx(-norm.logpdf(1.3, scale=2**0.5), rel=1e-6)
