"""Gradients of problems that tune other parameters of one filter, by one program."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from filters import LevelSample, LocalLevel
from objectives import Data, InnovationLikelihood
from tuner import Fixed, Positive, Problem, Space
from tuner.problem.shared_gradients import SharedGradients, value_and_slopes_of
from tuner.run.background_work import of_each_program

RECORD = Data(LevelSample(np.sin(0.3 * np.arange(60.0))), np.zeros(60))
FILTER = LocalLevel(dt=1.0)


def posed(space, build=None, tangents=2):
    return Problem(
        name="level",
        space=space,
        filter=FILTER,
        build=build,
        objective=InnovationLikelihood(),
        data=RECORD,
        gradients=SharedGradients(FILTER, tangents),
    )


def as_ratio(values):
    return FILTER.params(q=values["ratio"] * values["R"], R=values["R"])


BOTH = Space.of(q=Positive(0.1, 1e-6, 1e3), R=Positive(0.2, 1e-6, 1e3))
ONE = Space.of(q=Positive(0.1, 1e-6, 1e3), R=Fixed(0.2))
RATIO = Space.of(ratio=Positive(0.5, 1e-6, 1e3), R=Positive(0.2, 1e-6, 1e3))


@pytest.mark.parametrize(("space", "build"), [(BOTH, None), (ONE, None), (RATIO, as_ratio)])
def test_it_is_the_gradient_of_the_problem(space, build):
    problem = posed(space, build)
    z = space.start() + 0.1
    value, gradient = problem.by_xla(z)
    assert gradient.shape == (space.size,)
    own = replace(problem, gradients=None).by_xla(z)
    np.testing.assert_allclose(value, own[0], rtol=1e-13)
    np.testing.assert_allclose(gradient, own[1], rtol=1e-11)


def test_problems_with_other_parameters_share_a_program():
    problems = [posed(BOTH), posed(ONE), posed(RATIO, as_ratio)]
    assert of_each_program(problems) == problems[:1]
    problems[0].by_xla(BOTH.start())
    size = value_and_slopes_of._cache_size()
    for problem in problems[1:]:
        problem.by_xla(problem.space.start())
    assert value_and_slopes_of._cache_size() == size


def test_each_coordinate_needs_a_tangent():
    problem = posed(BOTH, tangents=1)
    with pytest.raises(ValueError, match="a gradient by 2 coordinates needs as many tangents, not"):
        problem.by_xla(jnp.zeros(2))
