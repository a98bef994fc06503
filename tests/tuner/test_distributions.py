"""Distributions and spectra against SciPy's modules that take long to import."""

import numpy as np
import pytest
import scipy.signal
from scipy import stats

from tuner import distributions
from tuner.run.spectrum_figure import density

X, DEGREES = np.array([0.01, 0.7, 3.0, 40.0]), np.array([1.0, 3.0, 30.0, 4.5])
SAME = {"rtol": 1e-12}


def test_distributions_are_those_of_scipy() -> None:
    for ours, theirs in (
        (distributions.chi_square_below(X, DEGREES), stats.chi2.cdf(X, DEGREES)),
        (distributions.chi_square_above(X, DEGREES), stats.chi2.sf(X, DEGREES)),
        (distributions.student_above(X, DEGREES), stats.t.sf(X, DEGREES)),
        (distributions.normal_above(X), stats.norm.sf(X)),
        (distributions.kolmogorov_above(X), stats.kstwobign.sf(X)),
    ):
        np.testing.assert_allclose(ours, theirs, **SAME)
    for share in (0.025, 0.5, 0.975):
        np.testing.assert_allclose(
            distributions.chi_square_at(share, DEGREES), stats.chi2.ppf(share, DEGREES), **SAME
        )
        np.testing.assert_allclose(
            distributions.student_at(share, 9), stats.t.ppf(share, 9), atol=1e-12
        )


@pytest.mark.parametrize("count", [-1, 0, 3, 9, 10])
def test_chance_of_more_is_the_binomial_one(count: int) -> None:
    np.testing.assert_allclose(
        distributions.more_than(count, 10, 0.2), stats.binom.sf(count, 10, 0.2), **SAME
    )


def test_ranks_and_tails_are_those_of_scipy() -> None:
    values = np.random.default_rng(1).standard_t(4, 200).round(1)
    assert distributions.ranks(values).tolist() == stats.rankdata(values).tolist()
    theirs = stats.kurtosistest(values, alternative="greater").pvalue
    np.testing.assert_allclose(distributions.heavy_tails(values), theirs, **SAME)


@pytest.mark.parametrize("length", [64, 65])
def test_density_is_that_of_welch(length: int) -> None:
    values = np.random.default_rng(2).standard_normal(1000).cumsum()
    _, theirs = scipy.signal.welch(values, 20.0, nperseg=length)
    np.testing.assert_allclose(density(values, 20.0, length), theirs, rtol=1e-9)
