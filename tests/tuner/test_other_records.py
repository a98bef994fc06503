"""A problem's mean over records that it was not tuned on."""

from dataclasses import replace

import numpy as np
import pytest

from filters import AngleSample, Complementary, Lanes
from objectives import Data, Records
from tuner.problem.other_records import mean_on
from tuner.problem.parameters import Positive
from tuner.problem.problem import Problem
from tuner.problem.programs import value_of
from tuner.problem.space import Space


def squares(outputs, truth):
    return ((outputs - truth) ** 2).mean()


def made(count, seed):
    draw = np.random.default_rng(seed).normal(size=(3, 40, count))
    return Data(AngleSample(*draw[:2]), draw[2])


def posed(data):
    lanes = Lanes(Complementary(dt=0.1), data.truth.shape[1])
    space = Space.of_filter(Complementary, tau=Positive(1.0, 0.1, 10.0), angle0=0.0)
    return Problem("lanes", space, lanes, None, Records(squares), data)


def by_hand(tau, data):
    """The textbook's loop, one record after another."""
    found = []
    for rate, angle, truth in zip(
        data.inputs.rate.T, data.inputs.angle.T, data.truth.T, strict=True
    ):
        share, x, errors = tau / (tau + 0.1), 0.0, []
        for k in range(len(rate)):
            x = share * (x + 0.1 * rate[k]) + (1 - share) * angle[k]
            errors.append((x - truth[k]) ** 2)
        found.append(np.mean(errors))
    return np.mean(found)


@pytest.mark.parametrize("count", [2, 4, 5])
def test_the_textbooks_mean_also_where_the_last_lanes_are_fewer(count):
    other = made(count, 1)
    found = mean_on(posed(made(2, 0)), {"tau": 0.7, "angle0": 0.0}, other)
    assert found == pytest.approx(by_hand(0.7, other), rel=1e-12)


def test_as_many_records_as_the_problem_has_need_no_compilation():
    problem = posed(made(3, 0))
    problem.score(problem.parameters(problem.space.start()))
    before = value_of._cache_size()
    mean_on(problem, {"tau": 20.0, "angle0": 0.0}, made(6, 1))
    assert value_of._cache_size() == before


def test_refused():
    problem = posed(made(2, 0))
    with pytest.raises(ValueError, match="no value for angle0"):
        mean_on(problem, {"tau": 1.0}, made(2, 1))
    single = Data(AngleSample(np.zeros(5), np.zeros(5)), np.zeros(5))
    alone = replace(problem, filter=Complementary(dt=0.1), objective=squares, data=single)
    with pytest.raises(ValueError, match="no records side by side"):
        mean_on(alone, {"tau": 1.0, "angle0": 0.0}, single)
