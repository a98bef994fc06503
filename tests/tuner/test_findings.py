import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tuner.data.findings import find, resolution, saturation

N = 20_000
NOISE = np.random.default_rng(5).normal(size=N)
TURN = np.sin(np.linspace(0.0, 40.0, N))


def quantised(values, step):
    return np.round(values / step) * step


def test_numbers_of_a_channel():
    found = find(np.array([1.0, -2.0, np.nan, 4.0, 1.0]))
    assert (found.mean, found.minimum, found.maximum) == (1.0, -2.0, 4.0)
    assert found.std == pytest.approx(np.sqrt(4.5))
    assert (found.constant, found.missing) == (False, 1)
    assert find(np.full(9, 0.1)).constant


@pytest.mark.parametrize("step", [0.05, 1 / 16.4, 0.25, 1.0, 3.0])
def test_resolution_of_a_quantised_channel(step):
    assert resolution(quantised(NOISE, step)) == pytest.approx(step, rel=1e-9)


def test_resolution_of_few_values():
    assert resolution(np.array([0.0, 3.0, 0.0, 0.0])) == 3.0
    assert resolution(np.array([1.0, 2.0])) == 1.0
    assert resolution(np.full(10, 2.5)) is None


def test_continuous_channels_have_no_resolution():
    assert resolution(NOISE) is None
    assert resolution(quantised(NOISE, 1e-5)) is None
    assert resolution(np.r_[np.zeros(N), 1.0, 1.0 + 1e-9]) is None


def test_a_start_at_rest_does_not_hide_that_a_channel_is_continuous():
    assert resolution(np.r_[np.zeros(30_000), NOISE, -NOISE, NOISE + 1.0]) is None


@pytest.mark.parametrize("limit", [0.5, 0.9, 0.95])
@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize("step", [None, 0.01])
def test_clipped_signals_are_saturated(limit, noise, step):
    signal = TURN + noise * NOISE
    signal = signal if step is None else quantised(signal, step)
    clipped = np.clip(signal, -2.0, limit)
    count = saturation(clipped)
    assert 0.7 * np.sum(clipped == limit) < count <= np.sum(clipped == limit)
    assert saturation(-clipped) == count
    assert saturation(np.clip(signal, -limit, limit)) > 1.5 * count


@pytest.mark.parametrize("step", [1e-6, 0.01, 0.1, 0.3, 1.0, 2.0, 5.0])
@pytest.mark.parametrize("signal", ["noise", "turn", "slow", "both", "ramp"])
def test_whole_signals_are_not_saturated(step, signal):
    values = {
        "noise": NOISE,
        "turn": 3.3 * TURN,
        "slow": 3.3 * np.sin(np.linspace(0.0, 3.0, N)),
        "both": 10.0 * TURN + NOISE,
        "ramp": np.linspace(-7.0, 7.0, N),
    }[signal]
    assert saturation(values) == 0
    assert saturation(quantised(values, step)) == 0


def test_rest_and_flags_are_not_saturation():
    rest = np.r_[np.zeros(N), np.abs(NOISE)]
    assert saturation(rest) == 0
    assert saturation((NOISE > 1.0).astype(float)) == 0
    assert saturation(np.repeat(NOISE, 10)) == 0


@settings(max_examples=50, deadline=None)
@given(st.lists(st.integers(-3, 3), min_size=2, max_size=60))
def test_saturation_is_a_count_that_knows_no_sign_or_scale(values):
    array = np.array(values, dtype=float)
    count = saturation(array)
    assert 0 <= count <= len(array)
    assert saturation(-array) == saturation(0.25 * array) == count
