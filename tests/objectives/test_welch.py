"""The spectrum against scipy.signal.welch, its integral against Parseval."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.signal
from hypothesis import example, given, settings
from hypothesis import strategies as st

from objectives import Welch, window
from tests.oracles import central_difference
from tests.strategies import seeds

WINDOWS = ["boxcar", "hann", "hamming", "blackman", "blackmanharris"]
DT = 0.01


def scipys(welch: Welch, x):
    taper = scipy.signal.get_window(welch.window, welch.segment, fftbins=not welch.symmetric)
    return scipy.signal.welch(
        x,
        fs=1 / DT,
        window=taper,
        nperseg=welch.segment,
        noverlap=welch.overlap,
        nfft=welch.nfft,
        detrend=False if welch.detrend == "none" else welch.detrend,
        scaling=welch.scaling,
        average=welch.average,
    )


def same_spectrum(welch, x):
    frequencies, expected = scipys(welch, x)
    np.testing.assert_allclose(welch.frequencies(DT), frequencies, rtol=1e-15)
    # Two FFTs of the same numbers: 1e-14 of the largest bin, where a smaller one cancels; and the
    # square of what is left of x by a detrend that takes everything.
    floor = 1e-14 * expected.max() + (1e-14 * np.abs(x).max()) ** 2
    actual = jax.jit(lambda record: welch.psd(record, DT))(x)
    np.testing.assert_allclose(actual, expected, rtol=1e-10, atol=floor)


@st.composite
def welches(draw):
    """Every option, with odd and even lengths."""
    segment, nfft = draw(st.sampled_from([(16, 16), (16, 21), (15, 15), (15, 32)]))
    return Welch(
        segment=segment,
        overlap=draw(st.sampled_from([0, 5, 14])),
        nfft=nfft,
        window=draw(st.sampled_from(WINDOWS)),
        symmetric=draw(st.booleans()),
        detrend=draw(st.sampled_from(["none", "constant", "linear"])),
        scaling=draw(st.sampled_from(["density", "spectrum"])),
        average=draw(st.sampled_from(["mean", "median"])),
    )


@settings(max_examples=16)  # of 5 x 2 x 3 x 2 x 2 options and 12 lengths; each is compiled
@given(welch=welches(), samples=st.sampled_from([32, 61]), rng=seeds())
@example(Welch(1, 0, 1, detrend="linear"), 32, np.random.default_rng(1))
@example(Welch(2, 1, 2, detrend="linear"), 32, np.random.default_rng(1))
@example(Welch(16, 0, 16, average="median"), 16, np.random.default_rng(1))  # one segment
def test_equals_scipy(welch, samples, rng):
    x = rng.normal(size=samples) + 3.0 + np.arange(samples)  # with something to detrend
    same_spectrum(welch, x)


def test_equals_scipy_for_more_segments_than_are_written_out():
    x = np.random.default_rng(1).normal(size=400)
    for average in ("mean", "median"):
        same_spectrum(Welch(16, 8, 16, average=average), x)


def test_equals_scipy_as_matlab_would_call_it():
    x = np.random.default_rng(2).normal(size=5000)
    welch = Welch.matlab(5000)
    same_spectrum(welch, x)


@pytest.mark.parametrize("name", WINDOWS)
@pytest.mark.parametrize("symmetric", [True, False])
@pytest.mark.parametrize("length", [1, 2, 7, 8])
def test_window_equals_scipy(name, symmetric, length):
    expected = scipy.signal.get_window(name, length, fftbins=not symmetric)
    np.testing.assert_allclose(window(name, length, symmetric=symmetric), expected, atol=2e-16)


@pytest.mark.parametrize(
    ("samples", "segment", "overlap", "nfft"),
    [
        (36, 8, 4, 256),
        (1152, 256, 128, 256),
        (1157, 257, 128, 512),
        (20001, 4444, 2222, 8192),
        (100001, 22222, 11111, 32768),
    ],
)
def test_matlabs_defaults(samples, segment, overlap, nfft):
    expected = Welch(segment, overlap, nfft, window="hamming", symmetric=True, detrend="none")
    assert Welch.matlab(samples) == expected


@given(welch=welches(), samples=st.sampled_from([32, 61]), rng=seeds())
def test_power_weights_integrate_the_spectrum_by_parseval(welch, samples, rng):
    plain = Welch(welch.segment, welch.overlap, welch.nfft, welch.window, welch.symmetric)
    x = rng.normal(size=samples)
    resolution = 1 / (plain.nfft * DT)
    integral = scipys(plain, x)[1].sum() * resolution
    # sums of 100 positive numbers
    assert plain.power_weights(samples) @ x**2 == pytest.approx(integral, rel=1e-13)


@pytest.mark.parametrize(
    "option", [{"detrend": "constant"}, {"average": "median"}, {"scaling": "spectrum"}], ids=str
)
def test_power_weights_refuse_where_parseval_does_not_hold(option):
    with pytest.raises(ValueError, match="only without detrend, with the mean and as a density"):
        Welch(16, 8, 16, **option).power_weights(64)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"overlap": 16}, "overlap 16, segment 16, nfft 16"),
        ({"overlap": -1}, "overlap -1"),
        ({"nfft": 15}, "nfft 15"),
        ({"segment": 0, "overlap": 0}, "segment 0"),
        ({"window": "haming"}, "window .*blackman, .*got 'haming'"),
        ({"detrend": "mean"}, "detrend is one of none, constant, linear, got 'mean'"),
        ({"scaling": "power"}, "scaling is one of density, spectrum, got 'power'"),
        ({"average": "max"}, "average is one of mean, median, got 'max'"),
    ],
    ids=str,
)
def test_unknown_options_are_errors_that_name_the_known_ones(options, message):
    with pytest.raises(ValueError, match=message):
        Welch(**{"segment": 16, "overlap": 8, "nfft": 16, **options})


def test_unknown_window_is_an_error():
    with pytest.raises(ValueError, match="unknown window 'kaiser'; there are blackman, "):
        window("kaiser", 8, symmetric=True)


def test_short_records_are_errors():
    with pytest.raises(ValueError, match="15 samples, fewer than one Welch segment of 16"):
        Welch(16, 8, 16).psd(jnp.zeros(15), DT)
    with pytest.raises(ValueError, match="15 samples, fewer than one Welch segment of 16"):
        Welch(16, 8, 16).power_weights(15)
    with pytest.raises(ValueError, match=r"35 samples, too few .* at least 36"):
        Welch.matlab(35)


@pytest.mark.parametrize(("average", "detrend"), [("mean", "none"), ("median", "linear")])
def test_gradient_equals_central_differences(average, detrend):
    welch = Welch(8, 4, 8, average=average, detrend=detrend)
    x = np.random.default_rng(3).normal(size=20)

    @jax.jit
    def total(x):
        return (welch.psd(x, DT) * jnp.arange(1.0, 6.0)).sum()

    difference = central_difference(total, x, 1e-6)
    # The spectrum is quadratic, so that only the rounding 1e-16 / h is left; the median's order
    # of segments does not change within h.
    np.testing.assert_allclose(jax.jit(jax.grad(total))(x), difference, rtol=0, atol=1e-9)
