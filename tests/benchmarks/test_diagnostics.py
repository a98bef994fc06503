"""Whether the benchmark's faults are the faults that they are called."""

import numpy as np
import pytest

from benchmarks import faulty_records as bench


def still(count=40):
    return np.zeros((bench.SAMPLES, count))


def test_coloured_noise_has_its_correlation_and_variance():
    z = bench.coloured(np.random.default_rng(1), still(), 2.0, 0.6)
    assert np.std(z) == pytest.approx(2.0, rel=0.03)
    pairs = np.mean(z[1:] * z[:-1]) / np.mean(z**2)
    assert pairs == pytest.approx(0.6, abs=0.02)


def test_outliers_are_as_many_and_as_large():
    z = bench.outliers(np.random.default_rng(2), still(), 0.1, 50.0, share=0.01)
    assert np.mean(np.abs(z) > 4) == pytest.approx(0.01, rel=0.2)


def test_noise_grows_to_both_ends():
    level = np.sort(np.random.default_rng(3).standard_normal((bench.SAMPLES, 200)), axis=0)
    for made in (bench.growing, bench.ageing):
        z = made(np.random.default_rng(4), level, 1.0, 1.5) - level
        ends = [np.mean(z[:50] ** 2), np.mean(z[-50:] ** 2)]
        assert np.log(ends) == pytest.approx([-1.425, 1.425], abs=0.1)


def test_a_full_turn_is_one():
    z = bench.wrapped(np.random.default_rng(5), still(), 0.1, 2)
    steps = np.diff(z, axis=0)
    assert (np.abs(steps) > 3).sum(axis=0).max() == 2
    assert z[-1].mean() == pytest.approx(-2 * bench.TURN, abs=0.1)


def test_the_records_are_those_of_the_filters():
    """Increments of the local level and steps of the velocity have the variance that q says."""
    draw = np.random.default_rng(6)
    walk = bench.walk(draw, 50)
    assert np.var(np.diff(walk, axis=0)) == pytest.approx(bench.MODELS["local level"].q, rel=0.03)
    track = bench.track(draw, 50)
    # Second differences of a white acceleration's position have 2/3 q dt^3.
    assert np.var(np.diff(track, 2, axis=0)) == pytest.approx(2 / 3 * 0.5 * 0.5**3, rel=0.03)
