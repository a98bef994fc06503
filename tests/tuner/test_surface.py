"""Many points at once: the same numbers as one by one, in bounded memory."""

import os
from functools import cache

import numpy as np
import pytest

import tuner.problem.surface
from objectives import kept_bytes
from studies.kownacki2010 import problems
from studies.kownacki2010.data import benches
from studies.kownacki2010.paper import ACC, GYRO
from studies.kownacki2010.settings import Settings
from tests.tuner.helpers import bowl, crater, problem
from tuner.problem.parameters import Fixed, Positive
from tuner.problem.space import Space
from tuner.problem.surface import MEMORY, _lanes, grid, values, values_and_gradients


@cache
def posed(sensor, reading="R6"):
    made = benches(Settings(seconds=0.5, rate_hz=1e3, cutoff_hz=5.0, reading=reading), None, 0)
    return problems.paper(next(bench for bench in made if bench.sensor is sensor))


def points(count):
    low, high = np.log([1e-8, 1e-6]), np.log([1e-2, 1e2])
    return np.random.default_rng(count).uniform(low, high, (count, 2))


@pytest.mark.parametrize("sensor", [GYRO, ACC], ids=["gyro", "acc"])
@pytest.mark.parametrize("reading", ["R6", "R1"])
def test_values_equal_those_one_by_one(sensor, reading):
    one = posed(sensor, reading)
    Z = points(7)
    # Side by side, sums are added and products fused in another order: 501 samples times eps.
    np.testing.assert_allclose(values(one, Z), [one.value(z) for z in Z], rtol=1e-11)


@pytest.mark.parametrize("sensor", [GYRO, ACC], ids=["gyro", "acc"])
def test_values_and_gradients_equal_those_one_by_one(sensor):
    one = posed(sensor)
    Z = points(5)
    found, gradients = values_and_gradients(one, Z)
    single = [one.value_and_gradient(z) for z in Z]
    assert gradients.shape == (5, 2)
    np.testing.assert_allclose(found, [value for value, _ in single], rtol=1e-11)
    scale = np.abs([gradient for _, gradient in single]).max()
    np.testing.assert_allclose(gradients, [g for _, g in single], rtol=1e-9, atol=1e-11 * scale)


@pytest.mark.parametrize("count", [1, 2, 3, 5, 8, 13])
@pytest.mark.parametrize("lanes", [1, 3, 8])
def test_batches_need_not_divide_the_points(count, lanes, monkeypatch):
    monkeypatch.setattr(tuner.problem.surface, "_lanes", lambda *_: lanes)
    one = problem(bowl)
    Z = np.random.default_rng(0).normal(size=(count, 2))
    expected = [one.value(z) for z in Z]
    np.testing.assert_allclose(values(one, Z), expected, rtol=1e-14)
    found, gradients = values_and_gradients(one, Z)
    np.testing.assert_allclose(found, expected, rtol=1e-14)
    assert gradients.shape == (count, 2)
    np.testing.assert_allclose(gradients[-1], one.value_and_gradient(Z[-1])[1], rtol=1e-13)


def test_what_is_not_a_number_is_infinite_here_as_well():
    Z = np.array([[0.0, 0.0], [1.0, -1.0]])
    assert values(problem(crater), Z).tolist() == [np.inf, 1.0]
    assert values_and_gradients(problem(crater), Z)[0].tolist() == [np.inf, 1.0]


def test_grid_equals_single_values_in_the_order_of_its_axes():
    one = problem(bowl)
    a, b = np.array([0.5, 1.0, 2.0]), np.array([0.3, 3.0])
    expected = [[one.value(np.log([i, j])) for j in b] for i in a]
    np.testing.assert_allclose(grid(one, {"a": a, "b": b}), expected, rtol=1e-14)
    np.testing.assert_allclose(grid(one, {"b": b, "a": a}), np.transpose(expected), rtol=1e-14)


def test_grid_leaves_the_others_at_their_initial_values():
    one = problem(bowl, space=Space.of(a=Positive(2.0, 0.1, 10.0), b=Positive(0.5, 0.1, 10.0)))
    b = np.array([0.3, 3.0, 5.0])
    expected = [one.value(np.log([2.0, j])) for j in b]
    np.testing.assert_allclose(grid(one, {"b": b}), expected, rtol=1e-14)


def test_grid_may_reach_beyond_the_box():
    one = problem(bowl)
    assert np.isfinite(grid(one, {"a": np.array([1e-9, 1e9])})).all()


@pytest.mark.parametrize(
    ("axes", "sentence"),
    [
        ({"c": [1.0]}, "unknown parameter 'c'"),
        ({"a": [1.0, 0.0]}, "a must be positive and finite, got 0"),
        ({"a": [1.0], "b": [-1.0]}, "b must be positive and finite, got -1"),
    ],
)
def test_grid_refuses(axes, sentence):
    with pytest.raises(ValueError, match=sentence):
        grid(problem(bowl), {name: np.array(axis) for name, axis in axes.items()})


def test_grid_refuses_a_fixed_parameter():
    one = problem(bowl, space=Space.of(a=Positive(2.0, 0.1, 10.0), b=Fixed(0.5)))
    with pytest.raises(ValueError, match=r"^b is fixed at 0.5, got 0.7$"):
        grid(one, {"b": np.array([0.7])})


# Memory.


def lanes(one, threads, count, memory, monkeypatch):
    monkeypatch.setattr(tuner.problem.surface, "MEMORY", memory)
    return _lanes(one, threads, count)


def kept(one):
    params = one.build(one.space.constrain(one.space.start()))
    return kept_bytes(one.filter, one.objective, params, one.data)


def test_kept_records_bound_the_lanes(monkeypatch):
    one = posed(GYRO, "R6")
    assert kept(one) == 501 * 8  # the noise of every sample
    for memory in (1e5, 1e6, 3e6):
        for threads in (1, 2, 7):
            found = lanes(one, threads, 10_000, memory, monkeypatch)
            assert found >= 1
            # All threads at once, each with a dozen copies of what its lanes keep.
            assert found == 1 or threads * found * 12 * kept(one) <= memory
            assert found == 64 or threads * (found + 1) * 12 * kept(one) > memory


def test_one_lane_where_memory_allows_not_even_that(monkeypatch):
    assert lanes(posed(GYRO, "R6"), 2, 100, 10.0, monkeypatch) == 1


def test_nothing_kept_needs_no_memory(monkeypatch):
    one = posed(GYRO, "R1")
    assert kept(one) == 0
    assert lanes(one, 2, 10_000, 10.0, monkeypatch) == 64


def test_no_more_lanes_than_points_for_every_thread(monkeypatch):
    one = posed(GYRO, "R1")
    monkeypatch.setattr(tuner.problem.surface, "_SHORT", 0)
    assert [_lanes(one, 2, count) for count in (1, 2, 3, 100, 128, 1000)] == [1, 1, 2, 50, 64, 64]
    assert [_lanes(one, 16, count) for count in (1, 16, 17)] == [1, 1, 2]


def test_points_on_a_short_record_share_what_is_compiled():
    one = posed(GYRO, "R1")
    assert [_lanes(one, 2, count) for count in (1, 3, 64, 100, 1000)] == [1, 3, 64, 64, 64]


def test_full_record_fits_the_memory_of_a_small_machine():
    # 100 001 samples are 0.8 MB a lane, a dozen times that in flight.
    threads = os.cpu_count() or 1
    assert MEMORY <= 256e6
    assert int(MEMORY / threads / 12 / 800_008) >= 1 or threads > 20
