"""Kownacki's cost (10): the published numbers, and every part against plain NumPy and SciPy."""

from dataclasses import dataclass, replace
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.signal
from hypothesis import given
from hypothesis import strategies as st

from filters import AccelerometerFilter, GyroscopeFilter, KownackiNoise, run
from objectives import Crossing, Data, Folded, Reading, StepResponse, Welch
from tests.oracles import lag_below, lag_to_first_crossing
from tests.published import (
    ACC_2,
    GYRO_1,
    GYRO_2,
    STEP,
    T,
    as_printed,
    d1_noise,
    d1_step,
    step_signal,
)
from tests.strategies import seeds

compiled = jax.jit(run, static_argnums=0)
ACC, GYRO = AccelerometerFilter(T, (2,)), GyroscopeFilter(T, (2,))

N, ENTERS, DT = 64, 20, 0.1
WELCH = Welch(16, 8, 32)
SMALL = step_signal(N, ENTERS)


@dataclass(frozen=True)
class Replay:
    """A filter that outputs what it is given: the objective alone is left."""

    def init(self, params):
        return ()

    def step(self, params, state, inputs):
        return state, inputs


def parts(objective: StepResponse, outputs, step):
    """Both integrals of outputs (N, 2), the answers to the step and to the record."""
    data = Data(jnp.asarray(outputs), objective.truth(step))
    (_, total), kept = compiled(Folded(Replay(), objective), None, data)
    return objective.parts(total, kept)


@cache
def answers(filter, noise, step, record):
    """Outputs to both signals, with y_0 = 0 and updates from k = 1."""
    signals = np.stack([np.array(step), np.array(record)], axis=1)
    y = compiled(filter, KownackiNoise.of(*noise), jnp.asarray(signals[1:]))[1]
    return np.concatenate([np.zeros((1, 2)), y])


def d1(filter, noise):
    return answers(filter, noise, tuple(d1_step()), tuple(d1_noise()))


# --- published numbers ---------------------------------------------------------------------------

D1_TABLE = pytest.mark.parametrize(
    ("filter", "noise", "inertia", "end", "amplitude", "power"),
    [
        (ACC, ACC_2, "4.13567e-3", 20000, "1.02350e-4", "0.0242597"),
        (GYRO, GYRO_2, "6.03253e-4", 6322, "2.65502e-4", "0.0307189"),
        (GYRO, GYRO_1, "7.17293e-3", 14346, "9.16888e-5", "0.0224808"),
    ],
    ids=["acc 2", "gyro 2", "gyro 1"],
)


@D1_TABLE
def test_table_of_D1(filter, noise, inertia, end, amplitude, power):
    welch = Welch.matlab(20001)
    outputs = d1(filter, noise)
    literal = StepResponse(T, welch, Reading.R1, Crossing.FIRST)
    whole = parts(literal, outputs, d1_step())
    assert float(whole.inertia) == as_printed(inertia)
    assert float(whole.noise) == as_printed(power)
    alone = parts(replace(literal, reading=Reading.R6), outputs, d1_step())
    assert float(alone.inertia) == as_printed(inertia)
    assert float(alone.noise) == as_printed(amplitude)
    lag = (d1_step() - outputs.sum(axis=1))[5000:]
    assert lag_to_first_crossing(lag, T)[1] + 5000 == end


@pytest.mark.parametrize(
    ("filter", "noise", "inertia", "end"),
    [(ACC, ACC_2, "0.00417049", 100000), (GYRO, GYRO_2, "5.86295e-4", 51117)],
    ids=["acc 2", "gyro 2"],
)
def test_step_alone_as_published(filter, noise, inertia, end):
    step = step_signal(100_001, 50_000)
    outputs = answers(filter, noise, tuple(step), (0.0,) * len(step))
    objective = StepResponse(T, Welch.matlab(100_001), Reading.R6, Crossing.FIRST)
    cost = parts(objective, outputs, step)
    assert float(cost.inertia) == as_printed(inertia)
    assert float(cost.noise) == 0.0
    assert lag_to_first_crossing((step - outputs[:, 0])[50_000:], T)[1] + 50_000 == end


def test_the_hinge_differs_from_the_first_crossing_by_what_comes_after():
    """Notes: the same optimum; without noise and before any second crossing, the same number."""
    step = step_signal(100_001, 50_000)
    outputs = answers(ACC, ACC_2, tuple(step), (0.0,) * len(step))  # never crosses
    welch = Welch.matlab(100_001)
    hinge, first = (
        parts(StepResponse(T, welch, Reading.R1, crossing), outputs, step).inertia
        for crossing in Crossing
    )
    assert float(hinge) == pytest.approx(float(first), rel=1e-12)  # 50 000 terms in one order


# --- the first integral --------------------------------------------------------------------------


def small(reading=Reading.R2, crossing=Crossing.HINGE, **changes):
    return StepResponse(DT, replace(WELCH, **changes), reading, crossing)


@given(rng=seeds(), crossing=st.sampled_from(Crossing), level=st.floats(-0.3, 0.3))
def test_inertia_of_any_output(rng, crossing, level):
    """Outputs that cross the step anywhere, many times or never."""
    outputs = STEP / 2 + level + 0.1 * rng.normal(size=(N, 2))
    lag = (SMALL - outputs.sum(axis=1))[ENTERS:]
    first, _ = lag_to_first_crossing(lag, DT)
    expected = first if crossing is Crossing.FIRST else lag_below(lag, DT)
    actual = parts(small(crossing=crossing), outputs, SMALL).inertia
    assert float(actual) == pytest.approx(expected, rel=1e-13)  # a sum of 44 positive terms


@pytest.mark.parametrize("at", [ENTERS, ENTERS + 1, 40, N - 1, None])
def test_inertia_ends_at_the_first_crossing(at):
    """At the sample the step enters with, the next, some, the last and none."""
    outputs = np.zeros((N, 2))
    outputs[ENTERS:, 0] = np.linspace(0.0, 0.1, N - ENTERS)
    if at is not None:
        outputs[at, 0] = STEP if at == 40 else 2 * STEP  # reaching is enough
        outputs[at + 1 :, 0] = 0.0  # what follows does not count
    lag = (SMALL - outputs.sum(axis=1))[ENTERS:]
    expected, end = lag_to_first_crossing(lag, DT)
    assert end + ENTERS == (N - 1 if at is None else at)
    actual = parts(small(crossing=Crossing.FIRST), outputs, SMALL).inertia
    assert float(actual) == pytest.approx(expected, rel=1e-14, abs=0)


@pytest.mark.parametrize("crossing", Crossing)
def test_nothing_before_the_step_counts(crossing):
    outputs = np.zeros((N, 2))
    outputs[:ENTERS] = np.random.default_rng(1).normal(size=(ENTERS, 2))
    expected = (N - 1 - ENTERS) * DT * STEP**2
    assert float(parts(small(crossing=crossing), outputs, SMALL).inertia) == pytest.approx(expected)


@pytest.mark.parametrize("crossing", Crossing)
def test_a_step_at_the_last_sample_has_no_width(crossing):
    objective = small(crossing=crossing)
    assert float(parts(objective, np.zeros((N, 2)), step_signal(N, N - 1)).inertia) == 0.0


# --- the second integral -------------------------------------------------------------------------


def spectrum(welch: Welch, x):
    _, density = scipy.signal.welch(
        x,
        fs=1 / DT,
        window=scipy.signal.get_window("hamming", welch.segment, fftbins=False),
        nperseg=welch.segment,
        noverlap=welch.overlap,
        nfft=welch.nfft,
        detrend=False if welch.detrend == "none" else welch.detrend,
    )
    return density, 1 / (welch.nfft * DT)


@given(rng=seeds(), reading=st.sampled_from(Reading))
def test_noise_of_any_output(rng, reading):
    outputs = rng.normal(size=(N, 2))
    signal = outputs.sum(axis=1) if reading is Reading.R1 else outputs[:, 1]
    density, resolution = spectrum(WELCH, signal)
    expected = (np.sqrt(density) if reading is Reading.R6 else density).sum() * resolution
    actual = parts(small(reading), outputs, SMALL).noise
    assert float(actual) == pytest.approx(expected, rel=1e-12)  # an FFT, or Parseval instead


def test_the_amplitude_may_be_detrended():
    """Only Parseval's weights need a spectrum without a detrend; R6 does not use them."""
    outputs = np.random.default_rng(4).normal(size=(N, 2)) + 3.0
    objective = small(Reading.R6, detrend="constant")
    density, resolution = spectrum(objective.welch, outputs[:, 1])
    expected = np.sqrt(density).sum() * resolution
    assert float(parts(objective, outputs, SMALL).noise) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("reading", [Reading.R1, Reading.R2])
def test_the_power_may_not_be_detrended(reading):
    with pytest.raises(ValueError, match="only without detrend"):
        small(reading, detrend="constant").truth(SMALL)


def test_under_R1_one_signal_will_do():
    """Their sum alone counts, so a filter may be run on the sum."""
    outputs = np.random.default_rng(5).normal(size=(N, 2))
    objective = small(Reading.R1)
    together = parts(objective, outputs, SMALL)
    added = parts(objective, outputs.sum(axis=1, keepdims=True), SMALL)
    np.testing.assert_allclose(np.array(added), np.array(together), rtol=1e-14)


@pytest.mark.parametrize("reading", Reading)
def test_weight_multiplies_the_second_integral(reading):
    outputs = np.random.default_rng(6).normal(size=(N, 2))
    objective = replace(small(reading), weight=2.5)
    data = Data(jnp.asarray(outputs), objective.truth(SMALL))
    (_, total), kept = compiled(Folded(Replay(), objective), None, data)
    inertia, noise = objective.parts(total, kept)
    expected = float(inertia) + 2.5 * float(noise)
    assert float(objective.value(total, kept)) == pytest.approx(expected, rel=1e-15)


# --- errors --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "step",
    [
        np.zeros(N),
        np.ones(N),
        step_signal(N, ENTERS)[::-1],
        -SMALL,
        np.where(np.arange(N) == 40, 0.0, SMALL),
        np.where(np.arange(N) == 40, np.nan, SMALL),
    ],
    ids=["none", "from the start", "falls", "negative", "interrupted", "nan"],
)
@pytest.mark.parametrize("reading", Reading)
def test_a_signal_that_is_no_step_is_an_error(step, reading):
    with pytest.raises(ValueError, match="must be 0 at first, rise within the record and stay"):
        small(reading).truth(step)


@pytest.mark.parametrize("reading", Reading)
def test_a_record_shorter_than_a_segment_is_an_error(reading):
    step = step_signal(10, 5)
    with pytest.raises(ValueError, match="10 samples, fewer than one Welch segment of 16"):
        parts(small(reading), np.zeros((10, 2)), step)
