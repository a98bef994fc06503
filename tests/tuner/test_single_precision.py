"""Single precision: where it hurts, what is said, and what is refused."""

import re
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
import pytest

from filters import FixedGainFilter, FixedGains, GyroscopeFilter, KownackiNoise, gyroscope_steady
from tuner.certificate.single_precision import HARMLESS, single_precision

DT, N = 1e-4, 20001
T = np.arange(N) * DT
RECORD = 0.2 * (T >= 0.5) + 1e-3 * np.sin(2 * np.pi * 50 * T)


@dataclass(frozen=True)
class Integrator:
    """A sum, in the precision of its parameter: the error grows with time."""

    def init(self, params):
        return jnp.zeros((), params.dtype)

    def step(self, params, state, inputs):
        state = state + inputs
        return state, state


@dataclass(frozen=True)
class Upcast:
    """A filter that falls back to double precision."""

    def init(self, params):
        return jnp.zeros(())

    def step(self, params, state, inputs):
        return state, inputs.astype(jnp.float64)


@dataclass(frozen=True)
class Overflow:
    """A square that single precision cannot hold."""

    def init(self, params):
        return ()

    def step(self, params, state, inputs):
        return state, params * inputs * inputs


def test_deviation_is_that_of_the_two_runs():
    check = single_precision("sum", Integrator(), np.array(0.0), RECORD, scale=0.2)
    small, whole = np.float32(0.0), 0.0
    deviation = []
    for sample in RECORD:
        small, whole = small + np.float32(sample), whole + sample
        deviation.append(abs(float(small) - whole))
    assert check.largest == max(deviation)
    assert check.sample == int(np.argmax(deviation))
    assert check.rms == pytest.approx(np.sqrt(np.mean(np.square(deviation))), rel=1e-12)
    assert check.share == check.largest / 0.2
    assert check.form == "sum"


def test_deviation_grows_with_the_length_of_the_record():
    shares = [
        single_precision("sum", Integrator(), np.array(0.1), RECORD[: N // 4 * k], scale=1.0).share
        for k in (1, 2, 4)
    ]
    assert shares[0] < shares[1] < shares[2]


def test_slow_gains_lose_more_than_fast_ones():
    """In the covariance recursion the loss is largest where Q/R is small."""

    def share(q_over_r):
        noise = KownackiNoise.of(R=1e-6, Q=1e-6 * q_over_r)
        return single_precision("full", GyroscopeFilter(DT), noise, RECORD, scale=0.2).share

    slow, fast = share(1e-3), share(1e3)
    assert slow > 3 * fast
    # Eight digits less a few lost in the recursion of 20001 samples.
    assert fast < 1e-3


def test_fixed_gains_survive():
    gains = gyroscope_steady(1027.47, DT).gains
    fixed = FixedGains(np.array(gains.K1), np.array(gains.K2))
    check = single_precision("fixed gain", FixedGainFilter(DT), fixed, RECORD, scale=0.2)
    assert check.share < 1e-4  # 2^-24 over the gain K1 = 3e-3 is 2e-5
    assert check.warning == ""


def test_the_limit_of_the_warning():
    largest = single_precision("sum", Integrator(), np.array(0.1), RECORD, scale=1.0).largest
    for factor, warned in ((1.01, False), (0.99, True)):
        scale = largest / HARMLESS * factor
        check = single_precision("sum", Integrator(), np.array(0.1), RECORD, scale=scale)
        assert bool(check.warning) == warned


def test_the_warning_says_how_much_where_and_what_to_do():
    scale = 1e-4
    check = single_precision("full covariance", Integrator(), np.array(0.1), RECORD, scale=scale)
    sentence = (
        f"in single precision the full covariance form strays by {100 * check.share:.3g} % of "
        f"0.0001 at sample {check.sample}; run it in double precision or use a fixed-gain form"
    )
    assert check.warning == sentence


def test_overflow_is_an_infinite_deviation():
    check = single_precision("square", Overflow(), np.array(1.0), np.array([1.0, 1e25]), scale=1.0)
    assert check.largest == np.inf
    assert check.sample == 1
    assert check.warning.startswith("in single precision the square form strays by inf %")


def test_not_a_number_counts_as_infinite():
    # 1e200 is infinite in single precision, and zero times that is not a number.
    check = single_precision("0", Overflow(), np.array(0.0), np.array([1.0, 1e100]), scale=1.0)
    assert (check.largest, check.share, check.rms, check.sample) == (np.inf, np.inf, np.inf, 1)
    assert check.warning != ""


def test_a_filter_that_upcasts_is_refused():
    sentence = "Upcast puts out float64 for float32 inputs"
    with pytest.raises(TypeError, match=f"^{re.escape(sentence)}$"):
        single_precision("any", Upcast(), np.array(1.0), RECORD, scale=1.0)


def test_several_signals():
    both = np.stack([RECORD, 10 * RECORD], axis=1)
    gains = FixedGains(np.array(0.1), np.array(0.0))
    check = single_precision("fixed gain", FixedGainFilter(DT, (2,)), gains, both, scale=0.2)
    alone = single_precision("fixed gain", FixedGainFilter(DT), gains, 10 * RECORD, scale=0.2)
    assert 0 <= check.sample < N
    # The larger signal strays the most, by as much as alone but for fused operations.
    assert check.largest == pytest.approx(alone.largest, rel=0.5)
