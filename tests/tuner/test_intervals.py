"""Intervals against textbook oracles: profiles of likelihoods, scatter of mean squares."""

from functools import cache

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from filters import (
    LevelSample,
    LinearKalman,
    LinearModel,
    LocalLevel,
    LocalLevelNoise,
    Sample,
    Transition,
)
from objectives import Data, InnovationLikelihood
from tuner.certificate.profile import limit
from tuner.certificate.sandwich import long_run
from tuner.certificate.solution import Status
from tuner.certificate.table import range_in_words
from tuner.certificate.yardstick import yardstick
from tuner.problem.parameters import Covariance, Positive
from tuner.problem.problem import Problem
from tuner.problem.samples import added, numbers, slopes
from tuner.problem.space import Space
from tuner.solvers import Gradient

WIDE = {"low": 1e-6, "high": 1e6}


def level(length, q, R, seed):
    rng = np.random.default_rng(seed)
    return np.cumsum(np.sqrt(q) * rng.standard_normal(length)) + np.sqrt(R) * rng.standard_normal(
        length
    )


def posed(z, q=1.0, R=1.0, unit=1.0):
    low, high = WIDE["low"] * unit**2, WIDE["high"] * unit**2
    space = Space.of(q=Positive(q * unit**2, low, high), R=Positive(R * unit**2, low, high))
    data = Data(LevelSample(jnp.asarray(unit * z)), jnp.zeros((len(z), 1)))
    return Problem("level", space, LocalLevel(dt=1.0), None, InnovationLikelihood(), data)


def nats(z, q, R):
    """Minus the log likelihood of a local level, by the textbook's loop from the second sample."""
    x, p, total = z[0], R, 0.0
    for measured in z[1:]:
        p += q
        s, y = p + R, measured - x
        total += (np.log(2 * np.pi * s) + y * y / s) / 2
        k = p / s
        x, p = x + k * y, (1 - k) * p
    return total


def profile(z, name, value):
    """The least there is with one parameter held."""

    def other(log):
        values = {name: value, ({"q", "R"} - {name}).pop(): np.exp(log)}
        return nats(z, **values)

    return minimize_scalar(other, bounds=(-14, 14), method="bounded", options={"xatol": 1e-8}).fun


@cache
def fitted(seed=1):
    z = level(300, 0.3, 2.0, seed)
    return z, Gradient("l-bfgs-b", seed=0, starts=2)(posed(z))


@pytest.mark.parametrize("name", ["q", "R"])
def test_a_likelihoods_interval_ends_where_the_profile_says(name):
    z, solution = fitted()
    found = solution.parameters[name]
    best = nats(z, *(float(solution.parameters[each].value) for each in "qR"))
    limit = 3.841459 / 2
    rise = lambda log: profile(z, name, np.exp(log)) - best - limit  # noqa: E731
    centre = np.log(float(found.value))
    ends = [np.exp(brentq(rise, centre - 4, centre)), np.exp(brentq(rise, centre, centre + 4))]
    # half a per cent of the log's half width
    np.testing.assert_allclose(found.interval, ends, rtol=5e-3)
    assert found.interval_kind == "95 %, likelihood ratio"
    low, high = found.robust
    # Gaussian and white: both speak of the same scatter.
    assert 0.6 < np.log(high / low) / np.log(ends[1] / ends[0]) < 1.6


def test_without_a_walk_there_is_a_limit_to_one_side():
    z = np.random.default_rng(3).standard_normal(400)
    q = Gradient("l-bfgs-b", seed=0, starts=2)(posed(z)).parameters["q"]
    assert q.interval[0] == 0.0
    assert range_in_words(q.interval, q.interval_kind).startswith("[below")
    assert q.robust[0] == 0.0
    best = min(profile(z, "q", 1e-12), profile(z, "q", float(q.value)))
    # 95 % to one side: the 90 % quantile of chi-square
    assert profile(z, "q", q.interval[1]) - best == pytest.approx(2.705543 / 2, rel=0.02)


@pytest.mark.parametrize("unit", [1e-9, 1e-3, 1e9])
def test_the_unit_does_not_matter(unit):
    z, solution = fitted()
    other = Gradient("l-bfgs-b", seed=0, starts=2)(posed(z, unit=unit))
    assert other.status is solution.status is Status.CONVERGED
    for name in "qR":
        one, two = solution.parameters[name], other.parameters[name]
        assert float(two.value) == pytest.approx(unit**2 * float(one.value), rel=1e-6)
        np.testing.assert_allclose(two.interval, unit**2 * np.array(one.interval), rtol=1e-4)
    assert other.value == pytest.approx(solution.value + np.log(unit), abs=1e-9)


def test_what_samples_add_is_the_derivative_of_the_sum():
    z, solution = fitted()
    problem = posed(z)
    each = slopes(problem, solution.z)
    assert each.shape == (300, 1, 2)
    assert numbers(problem, solution.z) == 299
    total = problem.value_and_gradient(solution.z + 0.1)[1] * 299
    np.testing.assert_allclose(slopes(problem, solution.z + 0.1).sum(axis=(0, 1)), total, rtol=1e-9)
    assert added(problem, solution.z).amounts.sum() / 299 == pytest.approx(solution.value)


@pytest.mark.parametrize("correlation", [0.0, 0.8])
def test_the_long_run_variance_is_that_of_an_autoregression(correlation):
    rng = np.random.default_rng(5)
    noise = np.zeros((20_000, 3, 1))
    for i in range(1, len(noise)):
        noise[i] = correlation * noise[i - 1] + rng.standard_normal((3, 1))
    found = long_run(noise - noise.mean(axis=(0, 1)))
    true = 60_000 / (1 - correlation) ** 2
    # blocks overlap: a relative deviation of sqrt(2 / freedom)
    assert found.covariance[0, 0] == pytest.approx(true, rel=3 * np.sqrt(2 / found.freedom))


def test_a_mean_square_has_an_interval_by_its_scatter():
    """A constant gain against a truth: deviation of the optimum over records, and its interval."""
    from objectives import ChannelRmse

    ends, values = [], []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        truth = np.cumsum(0.5 * rng.standard_normal(400))
        z = truth + rng.standard_normal(400)
        data = Data(LevelSample(jnp.asarray(z)), jnp.asarray(truth))
        space = Space.of(q=Positive(1.0, 1e-4, 1e4))
        problem = Problem("rms", space, LocalLevel(1.0), fixed, ChannelRmse("level"), data)
        solution = Gradient("l-bfgs-b", seed=0, starts=1)(problem)
        q = solution.parameters["q"]
        assert q.interval_kind == "95 %, sandwich"
        ends.append(np.log(q.interval))
        values.append(np.log(float(q.value)))
    widths = np.diff(ends, axis=1)[:, 0] / (2 * 1.96)
    assert 0.6 < np.median(widths) / np.std(values) < 1.6
    # the best gain is that of q / R = 0.25
    covered = [low < np.log(0.25) < high for low, high in ends]
    assert sum(covered) >= 17


def fixed(values):
    return LocalLevelNoise(values["q"], jnp.ones(()))


def tracked(values):
    """Two levels whose walks are correlated, each measured with the same variance."""
    Q = jnp.asarray(values["Q"])
    transition = Transition(jnp.eye(2), jnp.eye(2), Q)
    R = values["R"] * jnp.ones(2)
    return LinearModel(transition, jnp.eye(2), R, 10 * jnp.eye(2), jnp.zeros(2))


def test_the_entries_of_a_matrix_have_deviations():
    """Against the inverse Hessian in the entries themselves, by differences of the score."""
    rng = np.random.default_rng(0)
    steps = rng.multivariate_normal([0, 0], [[1.0, 0.5], [0.5, 2.0]], 600)
    z = np.cumsum(steps, axis=0) + rng.standard_normal((600, 2))
    space = Space.of(
        Q=Covariance(((1.0, 0.0), (0.0, 1.0)), low=1e-3, high=1e3), R=Positive(1.0, 1e-3, 1e3)
    )
    data = Data(Sample(jnp.asarray(z)), jnp.asarray(z))
    problem = Problem("two", space, LinearKalman(), tracked, InnovationLikelihood(), data)
    solution = Gradient("l-bfgs-b", seed=0, starts=1)(problem)
    Q, R = (solution.parameters[name].value for name in "QR")
    centre, h = np.array([Q[0, 0], Q[1, 0], Q[1, 1], R]), 1e-3

    def total(x):
        return 1200 * problem.score({"Q": [[x[0], x[1]], [x[1], x[2]]], "R": x[3]})

    basis = h * np.eye(4)
    hessian = [
        [
            (total(centre + a + b) - total(centre + a - b) - total(centre - a + b))
            + total(centre - a - b)
            for a in basis
        ]
        for b in basis
    ]
    expected = np.sqrt(np.diag(np.linalg.inv(np.array(hessian) / (4 * h * h))))
    found = solution.parameters["Q"].deviation
    np.testing.assert_allclose(found[[0, 1, 1], [0, 0, 1]], expected[:3], rtol=1e-3)
    assert found[0, 1] == found[1, 0]
    assert solution.parameters["R"].deviation is None


def white(values):
    """A state that is new at every sample: only the sum of both variances shows."""
    one, none = jnp.eye(1), jnp.zeros((1, 1))
    transition = Transition(none, one, values["q"] * one)
    return LinearModel(transition, one, values["R"] * jnp.ones(1), values["q"] * one, none[0])


def test_of_two_variances_whose_sum_is_known_each_is_below_it():
    z = 1.5 * np.random.default_rng(0).standard_normal((500, 1))
    space = Space.of(q=Positive(1.0, 1e-10, 1e10), R=Positive(1.0, 1e-10, 1e10))
    data = Data(Sample(jnp.asarray(z)), jnp.asarray(z))
    problem = Problem("white", space, LinearKalman(), white, InnovationLikelihood(), data)
    solution = Gradient("l-bfgs-b", seed=0)(problem)
    total = sum(float(solution.parameters[name].value) for name in ("q", "R"))
    assert total == pytest.approx(float((z**2).mean()), rel=1e-4)
    for name in ("q", "R"):
        low, high = solution.parameters[name].interval
        assert low == 0.0
        # The mean of 500 squares has a deviation of sqrt(2 / 500); 1.645 of them to one side.
        assert high == pytest.approx(total * (1 + 1.645 * np.sqrt(2 / 500)), rel=0.03)


def shown(v):
    return jnp.stack([jnp.log(v["a"]), jnp.log(v["b"])])


def bowl(point, _):
    return 10.0 + (point[0] - 0.3) ** 2 + (point[0] + point[1]) ** 2


def test_of_many_numbers_the_ends_of_a_cost_lie_on_the_ridge(monkeypatch):
    space = Space.of(a=Positive(0.5, 0.01, 100.0), b=Positive(0.5, 0.01, 100.0))
    problem = Problem("bowl", space, None, shown, bowl)
    full = Gradient("l-bfgs-b", seed=0, starts=1)(problem).parameters["a"].interval
    monkeypatch.setattr("tuner.certificate.profile.MANY", {"cost": 2})
    monkeypatch.setattr(
        "tuner.certificate.profile._Profile._minimised",
        lambda *_: pytest.fail("the others are moved"),
    )
    short = Gradient("l-bfgs-b", seed=0, starts=1)(problem).parameters["a"].interval
    reach = 0.1**0.5  # (ln a - 0.3)^2 = 0.1, where ln b = -ln a
    np.testing.assert_allclose(np.log(full), [0.3 - reach, 0.3 + reach], atol=2e-3)
    np.testing.assert_allclose(short, full, rtol=2e-3)


def beside_a_wall(point, _):
    return 10.0 + point[0] ** 2 + point[1] ** 2 + jnp.where(point[1] > 1e-9, 500.0, 0.0)


@pytest.mark.parametrize("side", [-1, 1])
def test_beside_a_jump_an_end_is_on_this_side_of_it(side):
    space = Space.of(a=Positive(0.5, 0.01, 100.0), b=Positive(0.5, 0.01, 100.0))
    problem = Problem("wall", space, None, shown, beside_a_wall)
    across = np.array([[1.0, -0.9 * side], [-0.9 * side, 1.0]])  # as if b rose where a moves
    z = np.zeros(2)
    yard = yardstick(problem, z)
    end = limit(problem, yard, z, across, 0, side, yard.rise)
    assert end.reached
    assert abs(end.z) == pytest.approx(0.1**0.5, rel=2e-3)
