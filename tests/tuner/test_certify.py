"""Certificates: what is flat and how that is said, bounds, stationarity, intervals."""

from functools import cache

import jax.numpy as jnp
import numpy as np
import pytest

import tuner.certificate.certify as judged
from studies.kownacki2010 import problems
from studies.kownacki2010.data import benches
from studies.kownacki2010.paper import GYRO
from studies.kownacki2010.settings import Settings
from tests.tuner.helpers import (
    ANY,
    Echo,
    bowl,
    hollow,
    plain,
    problem,
    slope,
    trench,
)
from tuner.certificate import intervals
from tuner.certificate.certify import flat_in_words, predicted_fall
from tuner.certificate.kkt import hold
from tuner.certificate.neighbours import neighbours
from tuner.certificate.solution import Starts
from tuner.certificate.spectrum import spectrum
from tuner.certificate.yardstick import yardstick
from tuner.problem.parameters import Bounded, Covariance, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers import Gradient

ONE = Starts(1, 1, 0.0)


def looked(posed, z):
    """How values are measured at a point, what holds it, and how the problem curves there."""
    yard = yardstick(posed, z)
    held = hold(posed, z, yard.unit)
    return yard, held, spectrum(posed, yard, z, held)


def certify(posed, z, starts):
    yard, held, curved = looked(posed, z)
    undetermined = judged.flat(posed, yard, z, curved)
    return judged.certify(posed, z, held, curved, undetermined, starts)


def estimates(posed, z):
    yard, _, curved = looked(posed, z)
    undetermined = judged.flat(posed, yard, z, curved)
    return intervals.estimates(posed, z, yard, curved.hessian, undetermined)


@cache
def gyro(free):
    """The paper's gyroscope on a short record, at its best point: problem and solution."""
    made = next(b for b in benches(Settings(seconds=2.0, rate_hz=1e3), None, 0) if b.sensor is GYRO)
    posed = problems.paper(made) if free == "R and Q" else problems.problem(made)
    return posed, Gradient("l-bfgs-b", seed=0, starts=1)(posed)


def test_two_parameters_of_the_paper_have_one_flat_direction():
    _, solution = gyro("R and Q")
    certificate = solution.certificate
    assert certificate.flat_directions == (
        "R x 10 with Q x 10 changes nothing: only Q/R is determined",
    )
    flat, steep = certificate.curvatures
    # Eigenvalues (0, 2 J'') of the Hessian in (ln R, ln Q); what is left of P0 is below 1e-4.
    assert abs(flat) < 1e-4
    one = gyro("Q")[1].certificate.curvatures[0]
    # J'' by both problems: the gradient at either end vanishes, P0 weighs differently.
    assert steep == pytest.approx(2 * one, rel=1e-2)
    assert solution.parameters["R"].interval is None
    assert solution.parameters["Q"].interval is None


def test_one_parameter_of_the_paper_is_well_posed():
    _, solution = gyro("Q")
    assert solution.certificate.flat_directions == ()
    assert solution.certificate.active_bounds == ()
    assert solution.parameters["R"].interval is None  # not free
    low, high = solution.parameters["Q"].interval
    assert low < solution.parameters["Q"].value < high


def test_the_value_at_the_ends_of_an_interval_is_one_per_cent_higher():
    posed, solution = gyro("Q")
    for end in solution.parameters["Q"].interval:
        rise = posed.value(np.log([end])) / solution.value - 1
        # The root of the rise is good to a thousandth.
        assert rise == pytest.approx(0.01, rel=3e-3)


def test_intervals_let_the_other_parameters_follow():
    posed = problem(bowl)
    found = estimates(posed, np.array([1.0, -1.0]))
    # value(z) = 1 + d H d / 2 rises by 1 % at d_i = sqrt(0.02 inv(H)_ii), the other at its best.
    reach = np.sqrt(0.02 * np.diag(np.linalg.inv([[2.0, 0.6], [0.6, 1.0]])))
    for name, centre, half in zip("ab", (1.0, -1.0), reach, strict=True):
        # An end is good to a thousandth of its distance.
        ends = np.log(found[name].interval) - centre
        np.testing.assert_allclose(ends, [-half, half], rtol=1e-3)
        assert found[name].interval_kind == "1 % of the cost"
    end = np.array([1.0 + reach[0], -1.0 - 0.6 * reach[0]])  # d_b = -H_ab / H_bb d_a
    assert posed.value(end) == pytest.approx(1.01, rel=1e-9)
    assert found["a"].unit == "m"
    assert float(found["a"].value) == pytest.approx(np.e, rel=1e-15)


def test_certificate_of_a_quadratic():
    certificate = certify(problem(bowl), np.array([1.5, -1.0]), ONE)
    value = 1.25
    # Relative to the value; the gradient there is (2, 0.6) * 0.5.
    assert certificate.gradient == {
        "ln a": pytest.approx(1.0 / value, rel=1e-12),
        "ln b": pytest.approx(0.3 / value, rel=1e-12),
    }
    expected = np.linalg.eigvalsh([[2.0, 0.6], [0.6, 1.0]]) / value
    np.testing.assert_allclose(certificate.curvatures, expected, rtol=1e-9)
    assert certificate.flat_directions == ()
    assert certificate.starts == ONE
    assert certificate.methods == {}


def test_only_a_power_law_is_determined():
    posed = problem(trench)
    certificate = certify(posed, np.array([0.5, 2.0]), ONE)
    assert certificate.flat_directions == (
        "a x 3.16 with b x 10 changes nothing: only b/a^2 is determined",
    )
    assert [estimates(posed, np.array([0.5, 2.0]))[name].interval for name in "ab"] == [None, None]


def test_nothing_is_determined():
    certificate = certify(problem(plain), np.zeros(2), ONE)
    assert sorted(certificate.flat_directions) == [
        "a x 10 changes nothing: a is not determined",
        "b x 10 changes nothing: b is not determined",
    ]


def product(outputs, truth):
    return 1.0 + (outputs[-1].sum() - 1.0) ** 2


def test_only_a_product_is_determined():
    (sentence,) = certify(problem(product), np.array([0.5, 0.5]), ONE).flat_directions
    assert sentence in {
        "a x 10 with b x 0.1 changes nothing: only b*a is determined",
        "a x 0.1 with b x 10 changes nothing: only b*a is determined",
    }


def test_a_slope_without_curvature_is_not_flat():
    """At a bound the curvature may vanish; the direction is determined all the same."""
    certificate = certify(problem(slope), np.array([-3.0, -1.0]), ONE)
    assert certificate.gradient["ln a"] == pytest.approx(0.3, rel=1e-12)
    assert min(map(abs, certificate.curvatures)) < 1e-9
    assert certificate.flat_directions == ()


def quartic(outputs, truth):
    return 1.0 + ((outputs[-1] - 0.5) ** 2).sum() ** 2


def test_a_flat_sentence_is_tried_and_not_read_off_the_curvature():
    certificate = certify(problem(quartic), np.array([0.5, 0.5]), ONE)
    np.testing.assert_allclose(certificate.curvatures, 0.0, atol=1e-5)
    assert certificate.flat_directions == ()
    found = estimates(problem(quartic), np.array([0.5, 0.5]))
    # x^4 = 0.01
    reach = 0.01**0.25
    np.testing.assert_allclose(np.log(found["a"].interval), [0.5 - reach, 0.5 + reach], atol=2e-3)


def hill(outputs, truth):
    return 2.0 - 0.05 * (outputs[-1] ** 2).sum()


def test_a_hilltop_is_neither_flat_nor_an_interval():
    posed = problem(hill)
    assert certify(posed, np.zeros(2), ONE).flat_directions == ()
    found = estimates(posed, np.zeros(2))
    assert [found[name].interval for name in "ab"] == [None, None]
    yard, held, curved = looked(posed, np.zeros(2))
    assert neighbours(posed, yard, np.zeros(2), held, curved).lower is not None
    # -0.05 over the value 2 along either axis, within a step of 1
    assert predicted_fall(posed, np.zeros(2), held, curved) == pytest.approx(0.05, rel=1e-6)


def test_what_is_not_a_number_is_neither_flat_nor_stationary():
    posed = problem(hollow)
    certificate = certify(posed, np.zeros(2), ONE)
    assert certificate.flat_directions == ()
    assert np.isnan(certificate.curvatures).all()
    _, held, curved = looked(posed, np.zeros(2))
    assert np.isnan(predicted_fall(posed, np.zeros(2), held, curved))
    assert [estimates(posed, np.zeros(2))[name].interval for name in "ab"] == [None, None]


def cliff(outputs, truth):
    x, y = outputs[-1]
    return 1.0 + x**2 + jnp.sqrt(y)


def test_a_hessian_that_reaches_over_a_cliff_is_not_a_number():
    # The point is fine, its neighbour at a distance of 1e-3 is not.
    certificate = certify(problem(cliff), np.array([0.0, 5e-4]), ONE)
    assert np.isnan(certificate.curvatures).all()
    assert np.isfinite(list(certificate.gradient.values())).all()


@pytest.mark.parametrize(
    ("z", "active"),
    [
        ([0.0, 0.0], ()),
        ([-3.0, 0.0], ("ln a",)),
        ([3.0, -3.0], ("ln a", "ln b")),
        ([-2.995, 2.995], ("ln a", "ln b")),  # barriers and samplers never quite get there
        ([-2.98, 2.98], ()),
    ],
)
def test_active_bounds(z, active):
    assert certify(problem(bowl), np.array(z), ONE).active_bounds == active


@pytest.mark.parametrize(
    ("z", "slopes", "fall"),
    [
        ([0.0, 0.0], [0.0, 0.0], 0.0),
        ([0.0, 0.0], [0.02, 0.0], 0.02**2 / 2 / 2),
        ([0.0, 0.0], [3.0, 0.0], 3.0 - 2 / 2),  # the model is trusted for a step of 1
        ([-3.0, 0.0], [0.3, 0.0], 0.0),  # pushed against the lower bound
        ([-3.0, 0.0], [-0.3, 0.0], 0.3**2 / 2 / 2),  # pulled away from it
        ([3.0, 0.0], [-0.3, 0.0], 0.0),
        ([-3.0, 0.0], [0.3, 0.3], 0.3**2 / 2 / 2),  # one held, the other not
        ([-3.0, 3.0], [0.3, -0.3], 0.0),
        ([-3.0, 0.0], [np.nan, 0.0], np.nan),
    ],
)
def test_predicted_fall(z, slopes, fall):
    """Against slope^2 / 2 / curvature, of a model with the curvature 2 along both coordinates."""
    posed, z = problem(bowl), np.array(z)
    _, held, curved = looked(posed, z)
    held = held._replace(gradient=np.array(slopes))
    model = curved._replace(curvatures=np.array([2.0, 2.0]), directions=np.eye(2))
    assert predicted_fall(posed, z, held, model) == pytest.approx(fall, rel=1e-12, nan_ok=True)


# Words.


@pytest.mark.parametrize(
    ("labels", "direction", "sentence"),
    [
        (["ln R", "ln Q"], [-0.7, -0.7], "R x 10 with Q x 10 changes nothing: only Q/R"),
        (["ln R", "ln Q"], [0.7, -0.7], "R x 10 with Q x 0.1 changes nothing: only Q*R"),
        (["ln R", "ln Q"], [0.7, 0.69], "R x 10 with Q x 9.68 changes nothing: only Q/R"),
        (["ln R", "ln Q"], [0.5, 1.0], "R x 3.16 with Q x 10 changes nothing: only Q/R^2"),
        (["ln R", "ln Q"], [0.01, 1.0], "Q x 10 changes nothing: Q"),
        (["ln R", "logit b"], [0.0, -1.0], "logit b +1 changes nothing: b"),
        (["L21 of P", "ln Q"], [1.0, 0.0], "L21 of P +1 changes nothing: L21 of P"),
    ],
)
def test_flat_directions_in_words(labels, direction, sentence):
    assert flat_in_words(labels, np.array(direction)) == f"{sentence} is{_not(sentence)} determined"


def _not(sentence):
    return "" if "only" in sentence else " not"


@pytest.mark.parametrize(
    ("labels", "direction", "sentence"),
    [
        (["ln R", "logit b"], [1.0, -0.5], "R x 10 with logit b -0.5"),
        (["ln R", "ln Q", "ln S"], [1.0, 1.0, 0.1], "R x 10 with Q x 10 with S x 1.26"),
    ],
)
def test_flat_directions_without_a_name(labels, direction, sentence):
    found = flat_in_words(labels, np.array(direction))
    assert found == f"{sentence} changes nothing: these are determined up to that"


def test_only_free_single_numbers_have_intervals():
    space = Space.of(
        b=Bounded(0.5, low=0.0, high=1.0),
        P=Covariance(((1.0, 0.0), (0.0, 1.0)), low=1e-3, high=1e3),
        a=Positive(1.0, 1e-3, 1e3),
    )

    def flat(values):
        return jnp.concatenate([values["b"][None], values["P"].ravel(), values["a"][None]])

    def distance(outputs, truth):
        goal = jnp.array([0.3, 2.0, 0.0, 0.0, 2.0, 5.0])
        return 1.0 + ((outputs[-1] - goal) ** 2).sum()

    posed = Problem("mixed", space, Echo(), flat, distance, ANY)
    z = space.unconstrain({"b": 0.3, "P": 2 * np.eye(2), "a": 5.0})
    found = estimates(posed, z)
    assert found["P"].interval is None
    np.testing.assert_allclose(found["P"].value, 2 * np.eye(2), rtol=1e-14, atol=1e-15)
    # (b - 0.3)^2 = 0.01 at 0.1 from the best, (a - 5)^2 as well: tried, to a thousandth of it.
    np.testing.assert_allclose(found["b"].interval, [0.2, 0.4], atol=1e-4)
    np.testing.assert_allclose(found["a"].interval, [4.9, 5.1], atol=1e-4)
