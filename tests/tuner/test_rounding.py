"""A descent ends where its values differ by rounding only: where its gradient is smallest."""

from types import SimpleNamespace
from zlib import crc32

import numpy as np
import pytest

from objectives import Data, InnovationLikelihood
from tuner.solvers.gradient import minimise
from tuner.solvers.rounding import OnlyRoundingError, UntilRounding

SAMPLES = 300_000
BOX = np.full(3, -8.0), np.full(3, 8.0)
LIMITS = {"gtol": 1e-8, "maxiter": 200}
MATRIX = np.array([[2.0, 0.9, 0.1], [0.9, 1.0, 0.2], [0.1, 0.2, 0.5]])


def rounded(z, noise):
    """A bowl of least value 1, with an error of its own at each point, and its exact gradient."""
    away = np.asarray(z) - 0.3
    curved = away @ MATRIX @ away / 2 + 0.02 * np.sum(away**4)
    slope = MATRIX @ away + 0.08 * away**3
    error = np.random.default_rng(crc32(np.asarray(z).tobytes())).normal()
    return 1.0 + curved + noise * error, slope


class Bowl(SimpleNamespace):
    objective = InnovationLikelihood()

    def value_and_gradient(self, z):
        self.evaluations += 1
        return rounded(z, self.noise)

    def value(self, z):
        return rounded(z, self.noise)[0]


def bowl(noise, samples=SAMPLES):
    return Bowl(noise=noise, evaluations=0, data=Data(np.zeros((samples, 1)), None))


def descend(problem, z):
    return minimise(problem, z, "l-bfgs-b", LIMITS, BOX)


@pytest.mark.parametrize("seed", range(8))
def test_rounding_ends_a_descent_near_the_minimum(seed):
    problem, start = bowl(noise=1e-13), np.random.default_rng(seed).uniform(-6, 6, 3)
    end = descend(problem, start)
    exact = descend(bowl(noise=0.0), start)
    assert end.finished
    assert problem.evaluations <= exact.evaluations + 6
    assert np.abs(rounded(end.z, 0.0)[1]).max() < 1e-6
    np.testing.assert_allclose(end.z, 0.3, atol=2e-6)


def test_line_searches_took_rounding_for_a_rise(monkeypatch):
    """Without the end by rounding the same descents need twice as many evaluations."""
    counts = []
    for still in (6, 10**9):
        monkeypatch.setattr("tuner.solvers.rounding._STILL", still)
        draw = np.random.default_rng(0)
        ends = [descend(bowl(noise=1e-13), draw.uniform(-6, 6, 3)) for _ in range(8)]
        counts.append(sum(end.evaluations for end in ends))
    assert counts[1] > 1.5 * counts[0]


def test_the_point_of_the_smallest_gradient_is_kept():
    values = iter([(3.0, 1.0), *((2.0 + 1e-14 * k, 0.1 / (1 + k % 4)) for k in range(9))])

    def value_and_gradient(z):
        value, slope = next(values)
        return value, np.array([slope])

    problem = bowl(noise=0.0)
    problem.value_and_gradient = value_and_gradient
    watched = UntilRounding(problem, (np.array([-1.0]), np.array([9.0])))
    with pytest.raises(OnlyRoundingError, match="^values that differ by rounding only$") as caught:
        list(map(watched, np.arange(10.0)[:, None]))
    end = caught.value.end
    assert (end.z.item(), end.evaluations, end.finished) == (4.0, 8, True)


@pytest.mark.parametrize("count", [1, 1000])
def test_a_slow_descent_goes_on(count):
    """Values that fall by more than rounding, however little, are no end."""
    watched = UntilRounding(bowl(noise=0.0, samples=count), BOX)
    problem = watched._problem
    for k in range(50):
        problem.value_and_gradient = lambda z, k=k: (1.0 - 1e-12 * k, np.ones(3))
        watched(np.zeros(3))


def test_a_gradient_out_of_the_box_is_none():
    problem = bowl(noise=0.0)
    problem.value_and_gradient = lambda z: (1.0, np.array([1.0, -1.0, 2e-3 * z[2]]))
    watched = UntilRounding(problem, (np.zeros(3), np.ones(3)))
    points = [np.array([0.0, 1.0, z]) for z in (0.9, 0.2, 0.5, 0.6, 0.7, 0.8, 0.9)]
    with pytest.raises(OnlyRoundingError) as caught:
        list(map(watched, points))
    assert caught.value.end.z[2] == 0.2
