"""Stretches of a record that contradict the rest: found, told, and left out."""

import numpy as np
import pytest

import tuner
from tests.tuner.fit_cases import level
from tuner.identifiability.stretches import bridged


def moving(seed, samples=1500, rate=20.0):
    """Heights of a thing that drifts, and their times; accelerations of density 0.5, noise 0.3."""
    draw = np.random.default_rng(seed)
    speed = np.cumsum(np.sqrt(0.5 / rate) * draw.standard_normal(samples))
    height = np.cumsum(speed) / rate
    return np.arange(samples) / rate, height + 0.3 * draw.standard_normal(samples)


def port_error(t, start, end, size):
    """An error that sets in, decays as speed does, and rattles: of a port in the wind."""
    inside = (t > start) & (t < end)
    draw = np.random.default_rng(9)
    decay = size * np.exp(-(t - start) / (end - start) * 2.0)
    return np.where(inside, decay * (1.0 + 0.05 * draw.standard_normal(len(t))), 0.0)


def fitted(t, z, **options):
    record = tuner.Record.of({"x": z}, times=t, units={"x": "m"})
    return tuner.fit("constant-velocity", record, options=options, starts=1, hold_out=False)


def values(fit):
    return np.array([float(fit.solution.parameters[name].value) for name in ("q", "R")])


def test_a_smooth_error_of_a_third_of_the_record_moves_nothing():
    t, z = moving(1)
    bad = z + port_error(t, 20.0, 45.0, -200.0)
    by_hand = fitted(t, np.where((t > 20.0) & (t < 45.0), np.nan, z))
    found = fitted(t, bad, stretches=4)
    np.testing.assert_allclose(values(found), values(by_hand), rtol=0.1)
    assert values(fitted(t, bad))[0] > 3 * values(by_hand)[0]  # it looks like motion
    left = found.judged.left_out
    assert 500 <= left.numbers <= 600
    assert len(left.stretches) == 1
    ((_, start, end),) = left.stretches
    assert 18.5 <= start <= 20.1
    assert 44.0 <= end <= 46.5
    assert f"{left.numbers} of 1500 numbers left out ({start:.4g} to {end:.4g} s)" in str(found)


def test_a_right_record_loses_nothing():
    t, z = moving(3)
    found = fitted(t, z, stretches=3)
    assert found.judged.left_out.numbers == 0
    assert found.judged.left_out.words == "no stretch contradicts the rest"
    np.testing.assert_array_equal(values(found), values(fitted(t, z)))


def test_of_several_recordings_the_wrong_one_is_named():
    t, z = moving(4)
    _, other = moving(5)
    bad = other + port_error(t, 30.0, 40.0, 80.0)
    records = [tuner.Record.of({"x": each}, times=t) for each in (z, bad)]
    found = tuner.fit(
        "constant-velocity", records, options={"stretches": 4}, starts=1, hold_out=False
    )
    assert {lane for lane, _, _ in found.judged.left_out.stretches} == {1}
    assert "left out (recording 2 " in found.judged.left_out.words


def test_what_is_short_between_two_is_doubtful():
    flags = np.array([1, 1, 1, 0, 0, 1, 1, 1, 0, 0, 0, 1], bool)
    assert bridged(flags).tolist() == [*[True] * 8, False, False, False, True]


@pytest.mark.parametrize(
    ("filter", "options", "message"),
    [
        ("alpha-beta", {"stretches": 4}, "no known linear model"),
        ("local-level", {"stretches": 0.5}, "rejects correct measurements; give 3 to 7"),
        ("local-level", {"stretches": True}, "stretches is True"),
    ],
)
def test_what_is_no_stretch(filter, options, message):
    columns = level(seed=1)
    record = tuner.Record.of({"z": columns["z"]}, rate_hz=1.0)
    with pytest.raises(ValueError, match=message):
        tuner.fit(filter, record, options=options, hold_out=False)
