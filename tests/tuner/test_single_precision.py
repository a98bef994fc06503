"""Single precision: where it hurts, what is said, and what is refused."""

import re
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

from filters import (
    Channel,
    FixedGainFilter,
    FixedGains,
    GyroscopeFilter,
    KownackiNoise,
    gyroscope_steady,
)
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
class Count:
    """Counts samples beside its output: whole numbers and truth values stay what they are."""

    def init(self, params):
        return jnp.zeros((), int)

    def step(self, params, state, inputs):
        value, valid = inputs
        assert (params[1].dtype, valid.dtype, state.dtype) == (jnp.int64, jnp.bool, jnp.int64)
        return state + 1, (jnp.where(valid, params[0] * value, 0.0), state, valid)


class Told(NamedTuple):
    """Outputs of which a filter says what they are."""

    att: Annotated[Array, Channel("", "attitude", ("w", "x", "y", "z"), kind="attitude")]
    yaw: Annotated[Array, Channel("rad", "heading", kind="angle")]
    speed: Annotated[Array, Channel("m/s", "speed")]
    turns: Annotated[Array, Channel("", "how often it was seen")]
    innovation: Annotated[Array, Channel("m/s", "innovation", kind="detail")]


@dataclass(frozen=True)
class Telling:
    """Outputs what ``made`` makes, which may depend on the precision it meets."""

    made: Any
    outputs = Told

    def init(self, params):
        return ()

    def step(self, params, state, inputs):
        single = inputs.dtype == jnp.float32
        told = {
            "att": jnp.array([1.0, 0.0, 0.0, 0.0]),
            "yaw": inputs,
            "speed": inputs,
            "innovation": inputs,
        } | self.made(single, inputs)
        told = {name: jnp.asarray(value, inputs.dtype) for name, value in told.items()}
        return state, Told(**told, turns=jnp.array(3))


@dataclass(frozen=True)
class Overflow:
    """A square that single precision cannot hold."""

    def init(self, params):
        return ()

    def step(self, params, state, inputs):
        return state, params * inputs * inputs


def test_deviation_is_that_of_the_two_runs():
    check = single_precision("sum", Integrator(), np.array(0.0), RECORD)
    small, whole = np.float32(0.0), 0.0
    deviation, right = [], []
    for sample in RECORD:
        small, whole = small + np.float32(sample), whole + sample
        deviation.append(abs(float(small) - whole))
        right.append(whole)
    assert check.largest == max(deviation)
    assert check.sample == int(np.argmax(deviation))
    assert check.rms == pytest.approx(np.sqrt(np.mean(np.square(deviation))), rel=1e-12)
    # A share of how far the output goes up and down.
    assert check.share == pytest.approx(max(deviation) / (max(right) - min(right)), rel=1e-12)
    assert (check.form, check.output) == ("sum", "")


def test_deviation_grows_with_the_length_of_the_record():
    largest = [
        single_precision("sum", Integrator(), np.array(0.1), RECORD[: N // 4 * k]).largest
        for k in (1, 2, 4)
    ]
    assert largest[0] < largest[1] < largest[2]


def test_slow_gains_lose_more_than_fast_ones():
    """In the covariance recursion the loss is largest where Q/R is small."""

    def share(q_over_r):
        noise = KownackiNoise.of(R=1e-6, Q=1e-6 * q_over_r)
        return single_precision("full", GyroscopeFilter(DT), noise, RECORD).share

    slow, fast = share(1e-3), share(1e3)
    assert slow > 3 * fast
    # Eight digits less a few lost in the recursion of 20001 samples.
    assert fast < 1e-3


def test_fixed_gains_survive():
    gains = gyroscope_steady(1027.47, DT).gains
    fixed = FixedGains(np.array(gains.K1), np.array(gains.K2))
    check = single_precision("fixed gain", FixedGainFilter(DT), fixed, RECORD)
    assert check.share < 1e-4  # 2^-24 over the gain K1 = 3e-3 is 2e-5
    assert check.warning == ""


def telling(made, inputs=RECORD[:100]):
    return single_precision("full", Telling(made), np.array(1.0), inputs)


@pytest.mark.parametrize(("factor", "warned"), [(0.99, False), (1.01, True)])
def test_the_limit_of_the_warning(factor, warned):
    """Off by a share of the range from 1 to 5, at the last sample."""
    ramp = np.linspace(1.0, 5.0, 100)

    def made(single, z):
        return {"speed": z + single * jnp.where(z == 5.0, 4 * HARMLESS * factor, 0.0)}

    check = telling(made, ramp)
    assert check.output == "speed"
    # Rounding 5 and the deviation to single precision: 2^-22 each.
    assert check.share == pytest.approx(HARMLESS * factor, abs=2e-7)
    assert bool(check.warning) == warned


def test_the_warning_says_how_much_of_what_where_and_what_to_do():
    check = telling(lambda single, z: {"speed": 2.0 - single}, np.arange(100) / 8)
    assert check.warning == (
        "in single precision the full form deviates by 50 % of 2 of the output 'speed' at sample 0"
        "; run it in double precision or use a fixed-gain form"
    )
    plain = single_precision("square", Overflow(), np.array(1.0), np.array([1.0, 1e25]))
    assert plain.warning == (
        "in single precision the square form deviates by inf % of 1e+50 at sample 1; "
        "run it in double precision or use a fixed-gain form"
    )


# Which outputs, and how they are compared.


def test_details_are_not_compared():
    far = telling(lambda single, z: {"innovation": 100.0 * single})
    assert far.warning == ""
    assert far.largest < 1e-7
    near = telling(lambda single, z: {"speed": 100.0 * single + z})
    assert near.output == "speed"
    assert near.warning != ""


def test_the_output_that_strays_most_of_its_own_range_is_told():
    """A tenth of a small range counts more than a larger number that is a hundredth of its own."""
    ramp = np.linspace(0.0, 1.0, 100)
    check = telling(
        lambda single, z: {"speed": 1000 * z + 10.0 * single, "yaw": z + 0.1 * single}, ramp
    )
    assert check.output == "yaw"
    assert check.share == pytest.approx(0.1, rel=1e-5)


def test_attitudes_are_compared_whatever_their_sign():
    q = np.array([0.5, 0.5, -0.5, 0.5])
    turned = telling(lambda single, z: {"att": -q if single else q})
    assert turned.warning == ""
    assert turned.largest < 1e-7
    # One sign for the whole quaternion: another sign in one part is another attitude.
    other = telling(lambda single, z: {"att": q * np.array([1, 1, 1, -1]) if single else q})
    assert (other.output, other.largest, other.share) == ("att", 1.0, 1.0)


def test_angles_are_compared_within_half_a_turn():
    angle = 3.0
    turned = telling(lambda single, z: {"yaw": angle + 2 * np.pi * single + 0 * z})
    assert turned.largest < 1e-6  # a turn more in single precision
    assert turned.warning == ""
    near = telling(lambda single, z: {"yaw": 3.1 - 6.2 * single + 0 * z})
    assert near.output == "yaw"
    assert near.largest == pytest.approx(2 * np.pi - 6.2, abs=1e-6)
    assert telling(lambda single, z: {"speed": 3.0 + 2 * np.pi * single}).output == "speed"


def test_an_output_that_never_moves_is_compared_with_its_size():
    level = 1000.0
    check = telling(lambda single, z: {"speed": level + 20.0 * single, "yaw": 0 * z})
    assert (check.output, check.share) == ("speed", 0.02)
    zero = telling(lambda single, z: {"speed": 0.5 * single + 0 * z, "yaw": 0 * z})
    assert (zero.output, zero.share) == ("speed", 0.5)


def test_whole_numbers_stay_whole():
    params = (np.array(0.1), np.array(3))
    inputs = (RECORD[:50], np.arange(50) % 7 > 0)
    check = single_precision("count", Count(), params, inputs)
    assert check.output == "[0]"
    assert 0 < check.share < 1e-6
    with pytest.raises(TypeError, match=r"^Overflow has no output that can be compared$"):
        single_precision("none", Overflow(), np.array(1), np.arange(5))


# What goes wrong.


def test_overflow_is_an_infinite_deviation():
    check = single_precision("square", Overflow(), np.array(1.0), np.array([1.0, 1e25]))
    assert (check.largest, check.share) == (np.inf, np.inf)
    assert check.sample == 1
    assert check.warning.startswith("in single precision the square form deviates by inf %")


def test_a_parameter_that_overflows():
    check = single_precision("sum", Overflow(), np.array(1e39), np.array([1.0, 2.0]))
    assert (check.largest, check.share, check.sample) == (np.inf, np.inf, 0)


def test_not_a_number_counts_as_infinite():
    # 1e200 is infinite in single precision, and zero times that is not a number.
    check = single_precision("0", Overflow(), np.array(0.0), np.array([1.0, 1e100]))
    assert (check.largest, check.share, check.rms, check.sample) == (np.inf, np.inf, np.inf, 1)
    assert check.warning != ""


def test_what_is_missing_in_both_is_equal():
    def made(single, z):
        return {"speed": jnp.where(z > 0.1, jnp.nan, z), "yaw": jnp.where(z > 0.1, jnp.inf, z)}

    check = telling(made, np.linspace(0.0, 0.2, 20))
    assert check.largest < 1e-8
    assert check.warning == ""
    lost = telling(lambda single, z: {"speed": jnp.where(single & (z > 0.1), jnp.nan, z)}, RECORD)
    assert lost.share == np.inf


@pytest.mark.parametrize(
    ("filter", "sentence"),
    [(Upcast(), "the output '' is float64 for float32 inputs")],
)
def test_a_filter_that_upcasts_is_refused(filter, sentence):
    with pytest.raises(TypeError, match=f"^{re.escape(sentence)}$"):
        single_precision("any", filter, np.array(1.0), RECORD)


def test_several_signals():
    both = np.stack([RECORD, 10 * RECORD], axis=1)
    gains = FixedGains(np.array(0.1), np.array(0.0))
    check = single_precision("fixed gain", FixedGainFilter(DT, (2,)), gains, both)
    alone = single_precision("fixed gain", FixedGainFilter(DT), gains, 10 * RECORD)
    assert 0 <= check.sample < N
    # The larger signal strays the most, by as much as alone but for fused operations.
    assert check.largest == pytest.approx(alone.largest, rel=0.5)
