"""The oracle of coverage: the density of a matrix, published numbers, and very long records."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from benchmarks.coverage.counting import share
from benchmarks.coverage.oracle import QUANTILE, contributions, covers, fit, limits, sandwich
from benchmarks.coverage.settings import SETTINGS
from benchmarks.coverage.simulated import (
    NILE,
    NOISES,
    local_levels,
    noise,
    pendulums,
    pseudo_true,
    tracks,
)
from tuner import Gradient


def test_contributions_are_the_density_of_the_differences_to_the_first():
    z = local_levels(np.random.default_rng(0), 1, 30, 0.3, 2.0)[0]
    k = np.arange(1, 30)
    covariance = 0.3 * np.minimum.outer(k, k) + 2.0 * (np.eye(29) + 1)
    expected = -multivariate_normal.logpdf(z[1:] - z[0], np.zeros(29), covariance)
    actual = contributions(z, np.float64(0.3), np.float64(2.0)).sum()
    np.testing.assert_allclose(actual, expected, rtol=1e-10)


def test_nile_is_the_published_one():
    # Durbin and Koopman 2012, 2.10: 15099 and 1469.1.
    at, found = limits(NILE)
    np.testing.assert_allclose(at, [1469.1, 15099], rtol=2e-4)
    newton = fit(NILE[None], np.log([[1000.0, 10000.0]]))
    np.testing.assert_allclose(np.exp(newton.at[0]), at, rtol=1e-4)
    edges = [covers(NILE[None], newton, np.log(edge))[0] for edge in 0.99 * found.T]
    assert [edge.tolist() for edge in edges] == [[False, False], [True, True]]


def test_without_wander_the_lower_limit_is_nothing():
    z = np.random.default_rng(3).standard_normal(60)
    _, found = limits(z)
    assert found[0, 0] == 0
    assert 0 < found[0, 1] < 1
    assert 0.5 < found[1, 0] < 1 < found[1, 1] < 3


@pytest.mark.parametrize("kind", NOISES)
def test_long_records_come_to_the_pseudo_true_values(kind):
    z = local_levels(np.random.default_rng(5), 30, 2000, 0.5, 1.0, kind)
    true = pseudo_true("level", 0.5, 1.0, kind)
    found = fit(z, np.tile(true, (30, 1))).at
    error = found.std(axis=0) / np.sqrt(30)
    assert (np.abs(found.mean(axis=0) - true) < 4 * error).all()
    assert (error < 0.04).all()


@pytest.mark.parametrize("setting", SETTINGS[1:3], ids=lambda setting: setting.name)
def test_simulated_records_are_what_the_filters_assume(setting):
    long = type(setting)(setting.filter, setting.noise, 3000, setting.q, setting.R)
    make = tracks if setting.filter == "track" else pendulums
    record = make(np.random.default_rng(1), 1, 3000, setting.q, setting.R)[0]
    solution = Gradient("l-bfgs-b", seed=0, starts=1)(long.problem(record))
    for name, true in setting.truth().items():
        # Four deviations of a likelihood of 3000 samples.
        assert float(solution.parameters[name].value) == pytest.approx(true, rel=0.4)


def test_noise_has_variance_one_and_its_colour():
    for kind, lag in (("white", 0.0), ("coloured", 0.6), ("student 6", 0.0)):
        drawn = noise(np.random.default_rng(2), (50, 4000), kind)
        assert drawn.var() == pytest.approx(1, abs=0.05)
        assert (drawn[:, 1:] * drawn[:, :-1]).mean() == pytest.approx(lag, abs=0.02)


def test_oracle_covers_and_its_robust_limits_do_where_the_others_fail():
    white = local_levels(np.random.default_rng(1), 300, 300, 0.5, 1.0)
    true = pseudo_true("level", 0.5, 1.0, "white")
    fitted = fit(white, np.tile(true, (300, 1)))
    # Of 300 records 95 % are held, give or take 1.3 %.
    assert (np.abs(covers(white, fitted, true).mean(axis=0) - 0.95) < 0.04).all()
    heavy = local_levels(np.random.default_rng(1), 300, 400, 0.5, 1.0, "student 4")
    fitted = fit(heavy, np.tile(true, (300, 1)))
    held = np.abs(fitted.at - true) <= sandwich(heavy, fitted, 5)
    assert covers(heavy, fitted, true)[:, 1].mean() < 0.88 < held[:, 1].mean()
    assert pytest.approx(3.841, abs=1e-3) == QUANTILE


def test_share_counts_what_is_missing_as_missed():
    assert share([None, (0.0, 1.0)], 0.5) == 0.5
