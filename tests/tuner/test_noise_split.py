"""R and Q from a record at rest: variances on either side of a frequency."""

import re

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.strategies import seeds
from tuner.data.noise_split import NoiseSplit, split_noise


@given(seeds(), st.integers(16, 501), st.floats(1.0, 1e4), st.floats(0.01, 0.99), st.floats(-9, 9))
def test_ideal_parts_add_up_to_the_variance(rng, n, rate, share, offset):
    lowest, highest = rate / n, rate / 2
    cutoff = lowest + share * (highest - lowest)
    assume(lowest < cutoff < highest)
    record = offset + rng.normal(size=n)
    R, Q = split_noise(record, rate, cutoff)
    # Parseval; a transform of 501 samples rounds to some 1e-15 of an offset of 9 squared.
    assert pytest.approx(np.var(record), rel=1e-10) == R + Q
    assert R >= 0
    assert Q >= 0


@given(seeds(), st.integers(30, 200))
def test_every_line_is_on_one_side(rng, n):
    """An even and an odd number of samples, a sine on each of their lines: Parseval by hand."""
    k = int(rng.integers(1, (n + 1) // 2))
    record = np.sin(2 * np.pi * k * np.arange(n) / n + 0.3)
    cutoff = 0.3 * n  # lines are k Hz at a rate of n Hz
    assume(cutoff > 1)
    R, Q = split_noise(record, float(n), cutoff)
    slow, fast = (0.5, 0.0) if k < cutoff else (0.0, 0.5)
    assert pytest.approx((fast, slow), abs=1e-12) == (R, Q)


def test_the_highest_line_counts_once():
    record = np.array([1.0, -1.0] * 20)
    assert split_noise(record, 40.0, 10.0) == NoiseSplit(pytest.approx(1.0), pytest.approx(0.0))


def test_the_line_at_the_cutoff_is_fast():
    n = 100
    record = np.sin(2 * np.pi * 5 * np.arange(n) / n)
    assert pytest.approx(0.5) == split_noise(record, float(n), 5.0).R
    assert pytest.approx(0.5) == split_noise(record, float(n), 5.0 + 1e-9).Q


def test_scaling_and_offset():
    record = np.random.default_rng(1).normal(size=400)
    R, Q = split_noise(record, 100.0)
    for method in ("ideal", "butterworth"):
        one = split_noise(record, 100.0, method=method)
        other = split_noise(3.0 * record + 50.0, 100.0, method=method)
        np.testing.assert_allclose(other, 9.0 * np.array(one), rtol=1e-9)
    assert R > Q > 0


def test_white_noise_splits_by_bandwidth():
    record = np.random.default_rng(2).normal(size=100_000)
    R, Q = split_noise(record, 1000.0, cutoff_hz=50.0)
    # A tenth of the band holds a tenth of the variance, from 10 000 draws: 1.4 % standard error.
    assert pytest.approx(0.1, rel=0.05) == Q
    assert pytest.approx(0.9, rel=0.02) == R


def test_butterworth_is_near_the_ideal_split():
    record = np.random.default_rng(3).normal(size=20_000)
    t = np.arange(20_000) / 1000
    record += 2.0 * np.sin(2 * np.pi * 0.2 * t)
    ideal = split_noise(record, 1000.0, 10.0)
    smooth = split_noise(record, 1000.0, 10.0, "butterworth")
    # Both let a little of the other side through: of white noise 10 Hz are 2 %, and the filters'
    # slopes make a quarter more or less of that.
    assert pytest.approx(ideal.R, rel=0.02) == smooth.R
    assert pytest.approx(ideal.Q, rel=0.02) == smooth.Q
    assert smooth != ideal


def test_butterworth_halves_twice_at_its_cutoff():
    t = np.arange(50_000) / 1000
    record = np.sin(2 * np.pi * 10 * t)
    # -3 dB forwards and -3 dB back are half the amplitude, a quarter of the variance 1/2.
    found = split_noise(record, 1000.0, 10.0, "butterworth")
    np.testing.assert_allclose(found, [0.125, 0.125], rtol=0.01)  # transients at both ends


@pytest.mark.parametrize("cutoff", [0.0, -1.0, 0.05, 0.1, 50.0, 60.0, np.nan, np.inf])
@pytest.mark.parametrize("method", ["ideal", "butterworth"])
def test_cutoffs_that_split_nothing(cutoff, method):
    record = np.random.default_rng(0).normal(size=1000)
    sentence = (
        f"a record of 1000 samples at 100 Hz cannot be split at {cutoff:g} Hz; choose a cutoff "
        "between 0.1 and 50 Hz"
    )
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        split_noise(record, 100.0, cutoff, method)


def test_unknown_method():
    with pytest.raises(ValueError, match=r"^unknown split 'butter'; did you mean butterworth\?"):
        split_noise(np.arange(1000.0), 100.0, 1.0, "butter")
