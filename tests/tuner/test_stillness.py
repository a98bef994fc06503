"""Motion and rest, told apart in records of many kinds."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from tuner.data.stillness import check_at_rest, find_motion


def white(count, seed=0):
    return np.random.default_rng(seed).standard_normal(count)


def walk(count, seed=9):
    return np.cumsum(white(count, seed))


QUIET = {
    "white at 1 Hz": (white(5000), 1.0),
    "white at 10 kHz": (white(100_000), 1e4),
    "a bias that walks for hours": (white(360_000) + 2e-3 * walk(360_000), 100.0),
    "a bias that walks at 1 Hz": (white(20_000) + 0.02 * walk(20_000), 1.0),
    "behind a filter of 5 Hz": (lfilter(*butter(2, 5, fs=1000), white(60_000)), 1000.0),
    "coarse steps": (np.round(0.4 * white(60_000) + 0.2), 200.0),
    "coarser than the noise": (np.round(0.05 * white(60_000) + 0.4), 200.0),
    "a slow warming": (white(60_000) + 1e-4 * np.arange(60_000), 100.0),
}


@pytest.mark.parametrize("name", QUIET)
def test_rest_is_no_motion(name):
    assert find_motion(*QUIET[name]) is None


def test_false_alarms_are_rare():
    """None in 300 records of 30 s."""
    assert not any(find_motion(white(3000, seed), 100.0) for seed in range(300))


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_a_part_that_moves_is_left_out(scale):
    t = np.arange(3000) / 50
    moves = ((t > 5) & (t < 12)) | (t >= 40)
    record = scale * (white(3000) + np.where(moves, 20 * np.sin(2 * np.pi * 0.8 * t), 0.0))
    found = find_motion(record, 50.0)
    begin, end = found.rest
    assert 12 <= begin <= 15
    assert 37 <= end <= 40
    assert find_motion(record[(t >= begin) & (t <= end)], 50.0) is None


@pytest.mark.parametrize("size", [20.0, 200.0])
def test_all_motion_has_no_rest(size):
    t = np.arange(3000) / 50
    record = white(3000) + size * np.sin(2 * np.pi * 0.5 * t) * np.sin(0.2 * t + 1)
    with pytest.raises(ValueError, match="acc is not at rest .*record at rest, or use a fit"):
        check_at_rest("acc", record * (np.abs(np.sin(0.2 * t + 1)) > -1), 50.0)


def test_turned_from_one_pose_to_another_rests_in_the_longer():
    t = np.arange(6000) / 100
    record = white(6000) + 500 * np.clip(t - 20, 0, 1)
    with pytest.raises(ValueError, match=r"rests from 12\d\.?\d* s to 160 s: --from 12\d"):
        check_at_rest("acc", record, 100.0, start_s=100.0)


def test_a_record_of_a_few_samples_is_not_judged():
    assert find_motion(white(90), 1000.0) is None
