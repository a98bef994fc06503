"""Many recordings in lines: the likelihood is that of a loop over one recording after another."""

import os
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from filters import (
    Lanes,
    LevelSample,
    LinearKalman,
    LinearModel,
    LocalLevel,
    Sample,
    Timed,
    TimedSample,
    Transition,
)
from objectives import ChannelRmse, Data, InnovationLikelihood
from tests.oracles import central_difference
from tests.tuner.code.compiled import needed
from tuner import Positive, Problem, Space, values, values_and_gradients
from tuner.problem import lines

LENGTHS = (3, 14, 0, 9, 1, 12, 11, 8, 7, 10)
Z = (np.log([1.0, 1.0]), np.log([0.3, 2.0]))
SPACE = Space.of(q=Positive(1.0, 1e-3, 1e3), r=Positive(1.0, 1e-3, 1e3))


@pytest.fixture(autouse=True)
def few_samples(monkeypatch):
    monkeypatch.setattr(lines, "LEAST", 0)
    monkeypatch.setattr(lines, "LENGTH", 12)
    monkeypatch.setattr(lines, "SIDE_BY_SIDE", 2)
    monkeypatch.setattr(os, "cpu_count", lambda: 2)


def recordings():
    """Side by side ``(N, k)``, NaN past their ends and where nothing was measured."""
    draw, N = np.random.default_rng(5), max(LENGTHS) + 2
    z = np.cumsum(draw.normal(size=(N, len(LENGTHS))), 0) + draw.normal(size=(N, len(LENGTHS)))
    z[draw.random(z.shape) < 0.1] = np.nan
    z[np.arange(N)[:, None] >= LENGTHS] = np.nan
    return z


def level(values):
    one = jnp.ones((1, 1))
    step = Transition(0.9 * one, one, values["q"] * one)
    return LinearModel(step, one, values["r"][None], 4 * one, jnp.zeros(1))


def posed(objective=None, truth=None, way=None, z=None):
    z = recordings() if z is None else z
    truth = np.where(np.isnan(z), np.nan, 0.0)[..., None] if truth is None else truth
    filter, data = Lanes(LinearKalman(), z.shape[1]), Data(Sample(z[..., None]), truth)
    objective = objective or InnovationLikelihood()
    return Problem("level", SPACE, filter, level, objective, data, way=way)


def nats(point, z):
    """The mean over all measured numbers, by a loop over one recording after another."""
    (q, r), found = np.exp(point), []
    for one in z.T:
        x, P = 0.0, 4.0
        for measured in one:
            x, P = 0.9 * x, 0.81 * P + q
            if np.isnan(measured):
                continue
            y, s = measured - x, P + r
            found.append((y**2 / s + np.log(2 * np.pi * s)) / 2)
            x, P = x + P / s * y, P * r / s
    return np.mean(found)


@pytest.mark.parametrize("way", ["forwards", "backwards"])
def test_value_and_gradient_are_those_of_a_loop(way):
    problem, z = posed(way=way), recordings()
    shapes = {part.inputs.begins.shape for part in problem.in_lines.parts}
    assert len(problem.in_lines.parts) == 2
    assert len(shapes) == 1
    for point in Z:
        value, gradient = problem.value_and_gradient(point)
        assert [value, problem.value(point)] == pytest.approx([nats(point, z)] * 2, rel=1e-13)
        slope = central_difference(lambda at: nats(at, z), point, 1e-5)
        np.testing.assert_allclose(gradient, slope, rtol=0, atol=1e-9)


def test_a_recording_that_does_not_count_is_left_out():
    z = recordings()
    held = np.where(np.isnan(z) | (np.arange(z.shape[1]) >= 6), np.nan, 0.0)[..., None]
    problem = posed(truth=held)
    samples = sum(part.inputs.begins.size for part in problem.in_lines.parts)
    assert samples < 1.5 * sum(LENGTHS[:6])
    assert problem.value(Z[1]) == pytest.approx(nats(Z[1], z[:, :6]), rel=1e-13)


def test_other_sums_are_those_of_recordings_side_by_side(monkeypatch):
    problem = posed(ChannelRmse("x"), truth=recordings()[..., None])
    found = problem.value(Z[1]), *problem.value_and_gradient(Z[1])
    monkeypatch.setattr(lines, "LEAST", np.inf)
    padded = replace(problem)
    assert padded.in_lines is None
    value, gradient = padded.value_and_gradient(Z[1])
    assert found[:2] == pytest.approx((value, value), rel=1e-13)
    np.testing.assert_allclose(found[2], gradient, rtol=1e-11)


def test_times_stay_with_their_samples(monkeypatch):
    z = recordings()
    dt = np.random.default_rng(2).uniform(0.5, 2.0, z.shape)
    filter = Lanes(Timed(LocalLevel(dt=1.0)), z.shape[1])
    data = Data(TimedSample(dt, LevelSample(z)), np.where(np.isnan(z), np.nan, 0.0)[..., None])
    problem = Problem(
        "level", Space.of_filter(LocalLevel), filter, None, InnovationLikelihood(), data
    )
    found = problem.value(problem.space.start())
    monkeypatch.setattr(lines, "LEAST", np.inf)
    assert found == pytest.approx(replace(problem).value(problem.space.start()), rel=1e-13)


def test_many_points_are_points_one_by_one():
    problem = posed()
    found, gradients = values_and_gradients(problem, np.stack(Z))
    assert found.tolist() == values(problem, np.stack(Z)).tolist()
    assert gradients.tolist() == [problem.value_and_gradient(z)[1].tolist() for z in Z]


def test_compiled_c_goes_through_the_parts_in_threads(monkeypatch):
    needed("cc")
    monkeypatch.setenv("TUNER_NATIVE", "on")
    problem = posed()
    value, gradient = problem.value_and_gradient(Z[1])
    assert problem.gradient_by.startswith("C")
    right = problem.by_xla(Z[1])
    assert len(problem.route.at) == 1
    assert value == pytest.approx(right[0], rel=1e-13)
    np.testing.assert_allclose(gradient, right[1], rtol=1e-11)


def test_few_samples_and_what_does_not_add_up_stay_side_by_side(monkeypatch):
    z = recordings()
    assert posed(lambda outputs, truth: jnp.nansum(outputs.innovation**2)).in_lines is None
    assert posed(truth=np.zeros(len(z))).in_lines is None  # one truth for all
    assert posed(z=z[:, :1]).in_lines is None
    monkeypatch.setattr(lines, "LEAST", z.size + 1)
    assert posed().in_lines is None


@settings(deadline=None, max_examples=60)
@given(st.lists(st.integers(0, 60), min_size=2, max_size=40).filter(any))
def test_every_recording_is_in_one_line_and_little_is_filled_up(lengths):
    parts = lines._plan(np.array(lengths))
    found = sorted(i for part in parts for line in part for i in line)
    assert found == [i for i, length in enumerate(lengths) if length]
    assert len({len(part) for part in parts}) == 1
    taken = [sum(lengths[i] for i in line) for part in parts for line in part]
    # As far as the longest may be from the mean where each goes to the shortest line.
    assert max(taken) <= sum(taken) / len(taken) + max(lengths)
    assert min(taken) > 0
