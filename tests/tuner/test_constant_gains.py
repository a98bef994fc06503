"""Likelihoods of long records go on with constant gains, where these settle."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from filters import Lanes, LevelSample, LocalLevel
from objectives import Data, InnovationLikelihood
from tuner import Positive, Problem, Space

RNG = np.random.default_rng(3)
SAMPLES = 4096
Z = np.cumsum(RNG.normal(size=SAMPLES)) + RNG.normal(size=SAMPLES)


def problem(q=1.0, **given):
    level = LocalLevel(dt=1.0)
    return Problem(
        name="level",
        space=Space.of(q=Positive(q, 1e-12, 1e3), R=Positive(1.0, 1e-3, 1e3)),
        filter=level,
        build=None,
        objective=InnovationLikelihood(),
        data=Data(LevelSample(jnp.asarray(Z)), jnp.zeros((SAMPLES, 1))),
        **given,
    )


def test_value_gradient_and_score_are_the_same():
    short, full = problem(steady=True, way="forwards"), problem(steady=False, way="forwards")
    z = short.space.start() + 0.3
    assert full.settled == 0
    assert short.settled > 0.7
    value, slope = full.value_and_gradient(z)
    found = short.value_and_gradient(z)
    np.testing.assert_allclose(found[0], value, rtol=1e-12)
    np.testing.assert_allclose(found[1], slope, rtol=0, atol=1e-10 * np.abs(slope).max())
    np.testing.assert_allclose(short.value(z), value, rtol=1e-12)
    np.testing.assert_allclose(short.score(short.parameters(z)), value, rtol=1e-12)
    assert short.gradient_by == f"XLA, forwards, constant gains for {short.settled:.1%}: forced"
    assert short.identity() == full.identity()


@pytest.mark.parametrize(
    ("q", "long", "settles"), [(1.0, True, True), (1e-12, True, False), (1.0, False, False)]
)
def test_it_is_chosen_for_long_records_of_filters_that_forget(monkeypatch, q, long, settles):
    monkeypatch.setattr("tuner.problem.constant_gains.WORTH", 1e4 if long else 1e6)
    assert (problem(q).settled > 0) == settles


def test_of_another_objective_nothing_is_taken_short():
    assert (
        replace(problem(steady=True), objective=lambda outputs, truth: outputs.level.mean()).settled
        == 0
    )


def test_recordings_end_to_end_take_every_sample(monkeypatch):
    monkeypatch.setattr("tuner.problem.lines.LEAST", SAMPLES)
    two = jnp.asarray(np.stack([Z, Z[::-1]], axis=1))
    data = Data(LevelSample(two), jnp.zeros((SAMPLES, 2, 1)))
    both = replace(problem(steady=True), filter=Lanes(LocalLevel(dt=1.0), 2), data=data)
    assert both.in_lines is not None
    assert both.settled == 0
