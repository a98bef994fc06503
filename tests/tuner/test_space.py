"""Parameters and their unconstrained vector: round trips, boxes, starts and refusals."""

import dataclasses
import re
from typing import Annotated, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filters import LinearKalman, Param
from filters.declared import assembled
from objectives import covariance
from tests.strategies import seeds
from tuner.problem.parameters import Bounded, Covariance, Fixed, Limited, Positive
from tuner.problem.space import Space

EYE = ((1.0, 0.0), (0.0, 1.0))
MIXED = Space.of(
    R=Positive(1e-4, low=1e-8, high=1.0, unit="(rad/s)^2"),
    T=Fixed(0.01, unit="s"),
    b=Bounded(0.3, low=-1.0, high=2.0),
    P=Covariance(((2.0, -0.5), (-0.5, 1.0)), low=1e-3, high=1e3),
    M=Fixed(((1.0, 2.0), (3.0, 4.0))),
)


def exactly(sentence):
    return f"^{re.escape(sentence)}$"


def constrained(parameter, z):
    return np.asarray(parameter.constrain(jnp.asarray(z)))


# Round trips. exp and log lose a few units in the last place of z, which for |z| <= 700 are
# 1e-13 each; a value is then off by |z| eps relative, 2e-13 at most.


@given(st.floats(1e-300, 1e300))
def test_positive_round_trip(value):
    parameter = Positive(1.0, low=1e-3, high=1e3)
    z = parameter.unconstrain(np.asarray(value))
    assert z.shape == (1,)
    assert float(constrained(parameter, z)) == pytest.approx(value, rel=1e-12)


@given(st.floats(-700, 700))
def test_any_z_is_a_positive_number(z):
    parameter = Positive(1.0, low=1e-3, high=1e3)
    value = constrained(parameter, [z])
    assert value > 0
    assert parameter.unconstrain(value) == pytest.approx(z, abs=1e-12)


@given(st.floats(-1e6, 1e6), st.floats(1e-3, 1e6), st.floats(1e-6, 1 - 1e-6))
def test_bounded_round_trip(low, width, share):
    high = low + width
    value = low + share * (high - low)
    parameter = Bounded((low + high) / 2, low=low, high=high)
    z = parameter.unconstrain(np.asarray(value))
    # Bounds of 1e6 leave 1e-10 of absolute rounding, whatever the width.
    assert float(constrained(parameter, z)) == pytest.approx(value, rel=1e-12, abs=1e-9)
    assert z.shape == (1,)


@given(st.floats(-30, 30))
def test_any_z_lies_between_the_bounds(z):
    parameter = Bounded(0.3, low=-1.0, high=2.0)
    assert -1.0 < constrained(parameter, [z]) < 2.0  # a logit of 30 is 1e-13 from the bound


@given(seeds(), st.integers(1, 4))
def test_covariance_round_trip(rng, n):
    root = rng.normal(size=(n, n))
    matrix = root @ root.T + 0.1 * np.eye(n)
    init = tuple(map(tuple, np.eye(n).tolist()))
    parameter = Covariance(init, low=1e-3, high=1e3)
    z = parameter.unconstrain(matrix)
    assert z.shape == (parameter.size,) == (n * (n + 1) // 2,)
    # Cholesky and L L' are backward stable: a few eps times the matrix' norm, order 10.
    np.testing.assert_allclose(constrained(parameter, z), matrix, rtol=1e-12, atol=1e-13)


@given(seeds())
def test_any_z_is_a_covariance(rng):
    parameter = Covariance(EYE, low=1e-3, high=1e3)
    matrix = constrained(parameter, rng.uniform(-3, 3, 3))
    covariance(matrix, definite=True)


def test_fixed_takes_no_place_and_keeps_its_value():
    for value in (0.01, ((1.0, 2.0), (3.0, 4.0))):
        fixed = Fixed(value)
        assert fixed.size == 0
        assert fixed.unconstrain(np.asarray(value)).shape == (0,)
        assert constrained(fixed, []).tolist() == np.asarray(value).tolist()
        assert constrained(fixed, []).dtype == np.float64


def test_space_round_trip_by_name():
    given = {"R": 0.5, "b": -0.9, "P": np.array([[3.0, 1.0], [1.0, 2.0]])}
    found = MIXED.constrain(jnp.asarray(MIXED.unconstrain(given)))
    assert list(found) == ["R", "T", "b", "P", "M"]
    assert float(found["R"]) == pytest.approx(0.5, rel=1e-15)
    assert float(found["b"]) == pytest.approx(-0.9, rel=1e-15)
    np.testing.assert_allclose(found["P"], given["P"], rtol=1e-15)
    assert float(found["T"]) == 0.01
    assert found["M"].tolist() == [[1.0, 2.0], [3.0, 4.0]]


def test_what_is_left_out_keeps_its_initial_value():
    np.testing.assert_array_equal(MIXED.unconstrain({}), MIXED.start())
    np.testing.assert_array_equal(MIXED.unconstrain({"R": 0.5})[1:], MIXED.start()[1:])
    initial = MIXED.constrain(jnp.asarray(MIXED.start()))
    assert float(initial["R"]) == pytest.approx(1e-4, rel=1e-14)  # |z| = 9 times eps
    assert float(initial["b"]) == pytest.approx(0.3, rel=1e-15)


def test_names_size_and_coordinates():
    assert MIXED.names == ("R", "T", "b", "P", "M")
    assert MIXED.size == 5
    assert MIXED.coordinates == ["ln R", "logit b", "ln L11 of P", "L21 of P", "ln L22 of P"]


def test_equal_spaces_are_interchangeable():
    assert hash(MIXED) == hash(Space(MIXED.parameters))
    assert Space.of(R=Fixed(1.0)) == Space.of(R=Fixed(1.0)) != Space.of(R=Fixed(2.0))
    with pytest.raises(dataclasses.FrozenInstanceError):
        MIXED.parameters = ()


@jax.jit
@jax.grad
def gradient_of_total(z):
    return sum(jnp.sum(value) for value in MIXED.constrain(z).values())


@given(st.lists(st.floats(-6, 6), min_size=5, max_size=5))
def test_gradient_of_constrain_is_finite_and_right(z):
    gradient = np.asarray(gradient_of_total(jnp.array(z)))
    r, b, l11, l21, l22 = z
    share = 1 / (1 + np.exp(-b))
    # Sum of L L': (L11)^2 + 2 L11 L21 + L21^2 + L22^2.
    L11, L22 = np.exp(l11), np.exp(l22)
    expected = [
        np.exp(r),
        3 * share * (1 - share),
        2 * L11**2 + 2 * L11 * l21,
        2 * L11 + 2 * l21,
        2 * L22**2,
    ]
    np.testing.assert_allclose(gradient, expected, rtol=1e-11, atol=1e-9)  # terms up to 1e5


# Boxes and starts.


def test_box_of_every_kind():
    low, high = MIXED.box()
    np.testing.assert_allclose(low, [np.log(1e-8), -6.9, np.log(1e-3), -1e3, np.log(1e-3)])
    np.testing.assert_allclose(high, [0.0, 6.9, np.log(1e3), 1e3, np.log(1e3)])
    share = (constrained(Bounded(0.3, low=-1.0, high=2.0), [6.9]) + 1.0) / 3.0
    assert 1 - share == pytest.approx(1e-3, rel=0.01)  # "a thousandth of the range"


@pytest.mark.parametrize("share", [1e-9, 1e-4, 0.5, 1 - 1e-4, 1 - 1e-9])
def test_box_of_a_bounded_parameter_holds_its_init(share):
    parameter = Bounded(share, low=0.0, high=1.0)
    low, high = parameter.box()
    assert low <= parameter.start() <= high
    assert low <= -6.9 < 6.9 <= high


def test_first_start_is_the_initial_point_and_all_lie_in_the_box():
    starts = MIXED.starts(50, seed=3)
    low, high = MIXED.box()
    assert starts.shape == (50, 5)
    np.testing.assert_array_equal(starts[0], MIXED.start())
    assert ((low <= starts) & (starts <= high)).all()
    # Random points all over the box: none in the same place, both halves of every axis.
    assert len(np.unique(starts, axis=0)) == 50
    middle = (low + high) / 2
    assert ((starts[1:] < middle).any(axis=0) & (starts[1:] > middle).any(axis=0)).all()


def test_starts_are_those_of_their_seed():
    np.testing.assert_array_equal(MIXED.starts(4, seed=7), MIXED.starts(4, seed=7))
    assert (MIXED.starts(4, seed=7)[1:] != MIXED.starts(4, seed=8)[1:]).all()
    # Fewer starts are the first of more.
    np.testing.assert_array_equal(MIXED.starts(2, seed=7), MIXED.starts(4, seed=7)[:2])
    assert MIXED.starts(1, seed=7).shape == (1, 5)
    assert MIXED.starts(0, seed=7).shape == (0, 5)


# Refusals.


def test_unknown_names_list_the_near_ones():
    space = Space.of(noise=Fixed(1.0), voice=Fixed(1.0), R=Fixed(1.0))
    with pytest.raises(ValueError, match="unknown parameter 'nois'; did you mean noise") as raised:
        space.unconstrain({"nois": 1.0})
    assert str(raised.value).endswith("There are: R, noise, voice")


@pytest.mark.parametrize(
    ("low", "init", "high"),
    [
        (1e-3, -1.0, 1e3),
        (1e-3, 0.0, 1e3),
        (1e-3, 1e-4, 1e3),
        (1e-3, 1e4, 1e3),
        (1e3, 1.0, 1e-3),
        (0.0, 1.0, 1e3),
        (-1.0, 1.0, 1e3),
        (1e-3, np.nan, 1e3),
        (np.nan, 1.0, 1e3),
        (1e-3, 1.0, np.nan),
        (1e-3, 1.0, np.inf),
        (1e-3, np.inf, np.inf),
    ],
)
def test_positive_refuses(low, init, high):
    with pytest.raises(ValueError, match="^a positive parameter needs 0 < low <= init <= high"):
        Positive(init, low=low, high=high)


def test_positive_may_start_on_a_bound():
    assert Positive(1.0, low=1.0, high=1.0).start() == 0.0


@pytest.mark.parametrize(
    ("low", "init", "high"),
    [
        (0.0, 0.0, 1.0),
        (0.0, 1.0, 1.0),
        (0.0, 2.0, 1.0),
        (1.0, 0.5, 0.0),
        (0.0, np.nan, 1.0),
        (-np.inf, 0.5, 1.0),
        (0.0, 0.5, np.inf),
    ],
)
def test_bounded_refuses(low, init, high):
    with pytest.raises(ValueError, match="^a bounded parameter needs finite low < init < high"):
        Bounded(init, low=low, high=high)


@pytest.mark.parametrize(
    ("init", "sentence"),
    [
        (((1.0, 2.0), (2.0, 1.0)), "must be positive definite, but has the eigenvalue -1"),
        (((1.0, 1.0), (1.0, 1.0)), "must be positive definite, but has the eigenvalue"),
        (((0.0, 0.0), (0.0, 0.0)), "must be positive definite, but has the eigenvalue 0"),
        (((1.0, 0.5), (0.4, 1.0)), "must be symmetric"),
        (((1.0, np.nan), (np.nan, 1.0)), "must be finite"),
        (((np.inf, 0.0), (0.0, 1.0)), "must be finite"),
        (((1.0, 0.0),), "must be a square matrix, got the shape (1, 2)"),
        ((1.0, 2.0), "must be a square matrix, got the shape (2,)"),
        ((), "must be a square matrix, got the shape (0,)"),
    ],
)
def test_covariance_refuses(init, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}"):
        Covariance(init, low=1e-3, high=1e3)


@pytest.mark.parametrize(
    ("low", "high"), [(0.0, 1.0), (-1.0, 1.0), (1.0, 1.0), (2.0, 1.0), (1.0, np.inf), (np.nan, 1.0)]
)
def test_covariance_refuses_bounds(low, high):
    with pytest.raises(ValueError, match="^a covariance needs 0 < low < high"):
        Covariance(EYE, low=low, high=high)


@pytest.mark.parametrize(
    "init",
    [
        ((1e-8, 0.0), (0.0, 1.0)),  # a standard deviation of 1e-4
        ((1e8, 0.0), (0.0, 1.0)),
        ((1.0, 1.0), (1.0, 1.0 + 1e-8)),  # L22 = 1e-4
    ],
)
def test_covariance_must_start_in_its_box(init):
    with pytest.raises(ValueError, match="^the Cholesky factor of a covariance's init needs"):
        Covariance(init, low=1e-3, high=1e3)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"R": 0.0}, "R must be positive and finite, got 0"),
        ({"R": -1.0}, "R must be positive and finite, got -1"),
        ({"R": np.nan}, "R must be positive and finite, got nan"),
        ({"R": np.inf}, "R must be positive and finite, got inf"),
        ({"R": [1.0, 2.0]}, "R must be one number, got the shape (2,)"),
        ({"R": [-1.0, 2.0]}, "R must be one number, got the shape (2,)"),
        ({"R": []}, "R must be one number, got the shape (0,)"),
        ({"b": -1.0}, "b must lie strictly between -1 and 2, got -1"),
        ({"b": 2.5}, "b must lie strictly between -1 and 2, got 2.5"),
        ({"b": np.nan}, "b must lie strictly between -1 and 2, got nan"),
        ({"b": [[0.0, 1.0]]}, "b must be one number, got the shape (1, 2)"),
        ({"P": np.ones((2, 2))}, "P must be positive definite, but has the eigenvalue 0"),
        ({"P": np.eye(3)}, "P must have the shape (2, 2), got (3, 3)"),
        ({"P": 1.0}, "P must be a square matrix, got the shape ()"),
        ({"T": 0.02}, "T is fixed at 0.01, got 0.02"),
    ],
)
def test_values_outside_a_constraint(values, sentence):
    with pytest.raises(ValueError, match=exactly(sentence)):
        MIXED.unconstrain(values)


# The helper that checks covariances.


# Spaces of filters.


class Inner(NamedTuple):
    bias: Annotated[jax.Array, Param("rad/s", "offset of the gyroscope", 0.0, -0.1, 0.3)]


class Facts(NamedTuple):
    R: Annotated[jax.Array, Param("m^2", "variance of the measurement", 0.5, 1e-3, 1e3)]
    share: Annotated[jax.Array, Param("1", "share of the new", 0.25, 0.0, 1.0)]
    inner: Inner
    g: Annotated[jax.Array, Param("m/s^2", "gravity", 9.81)]
    low: Annotated[jax.Array, Param("s", "half a range", 2.0, low=1.0)]
    P0: Annotated[jax.Array, Param("m^2", "at the start", ((1.0, 0.0), (0.0, 2.0)), shape=(2, 2))]


class Declaring:
    params = Facts


def test_facts_suggest_a_space():
    assert Space.of_filter(Declaring) == Space.of(
        R=Positive(0.5, 1e-3, 1e3, "m^2", meaning="variance of the measurement"),
        share=Bounded(0.25, 0.0, 1.0, "1", meaning="share of the new"),
        bias=Bounded(0.0, -0.1, 0.3, "rad/s", meaning="offset of the gyroscope"),
        g=Fixed(9.81, "m/s^2", meaning="gravity"),
        low=Fixed(2.0, "s", meaning="half a range"),
        P0=Fixed(((1.0, 0.0), (0.0, 2.0)), "m^2", meaning="at the start"),
    )
    assert Space.of_filter(Declaring()) == Space.of_filter(Declaring)


def test_overrides_decide_and_the_facts_keep_unit_and_meaning():
    space = Space.of_filter(
        Declaring,
        R=Positive(2.0, 1.0, 4.0),
        share=Limited(0.5, 0.0, 1.0, unit="%", meaning="in words of one's own"),
        bias=0,
        g=Bounded(9.8, 9.7, 9.9),
        low=np.float64(3.0),
        P0=Covariance(EYE, 1e-3, 1e3),
    )
    assert space == Space.of(
        R=Positive(2.0, 1.0, 4.0, "m^2", meaning="variance of the measurement"),
        share=Limited(0.5, 0.0, 1.0, "%", meaning="in words of one's own"),
        bias=Fixed(0.0, "rad/s", meaning="offset of the gyroscope"),
        g=Bounded(9.8, 9.7, 9.9, "m/s^2", meaning="gravity"),
        low=Fixed(3.0, "s", meaning="half a range"),
        P0=Covariance(EYE, 1e-3, 1e3, "m^2", meaning="at the start"),
    )
    fixed = dict(Space.of_filter(Declaring, P0=((3.0, 0.0), (0.0, 3.0))).parameters)["P0"]
    assert fixed == Fixed(((3.0, 0.0), (0.0, 3.0)), "m^2", meaning="at the start")


def test_the_space_makes_what_the_filter_takes():
    space = Space.of_filter(Declaring, P0=4.0)
    made = assembled(Declaring, space.constrain(jnp.asarray(space.start())))
    assert (float(made.R), float(made.inner.bias)) == (pytest.approx(0.5), pytest.approx(0.0))
    np.testing.assert_array_equal(made.P0, np.full((2, 2), 4.0))


def test_unknown_names_of_a_filters_parameters():
    sentence = "unknown parameter 'bais'; did you mean bias? There are: P0, R, bias, g, low, share"
    with pytest.raises(ValueError, match=exactly(sentence)):
        Space.of_filter(Declaring, bais=0.0)
    with pytest.raises(ValueError, match=r"^LinearKalman declares no params; give the class "):
        Space.of_filter(LinearKalman, K1=0.1)


@pytest.mark.parametrize(
    ("fact", "sentence"),
    [
        (Param("s", "", 20.0, 1.0, 10.0), "a positive parameter needs 0 < low <= init <= high"),
        (Param("s", "", 0.0, 0.0, 10.0), "a bounded parameter needs finite low < init < high"),
        (Param("s", "", (1.0, 2.0), 0.5, 10.0), "only "),
    ],
)
def test_facts_that_suggest_nothing(fact, sentence):
    facts = {"tau": fact}

    class Odd:
        params = facts

    with pytest.raises(ValueError, match=f"^the facts of tau suggest no parameter: {sentence}"):
        Space.of_filter(Odd)
    assert Space.of_filter(Odd, tau=1.0).names == ("tau",)


def test_the_form_of_a_space_has_the_same_values_and_neither_box_nor_start():
    other = Space.of(
        R=Positive(2.0, low=1e-3, high=1e3),
        T=Fixed(0.01),
        b=Bounded(0.3, low=-1.0, high=2.0, meaning="another word"),
        P=Covariance(EYE, low=1e-1, high=1e1, unit="m^2"),
        M=Fixed(((1.0, 2.0), (3.0, 4.0)), nominal=True),
        d=Limited(3.0, low=1.0, high=9.0, scale=2.0),
    )
    space = Space((*MIXED.parameters, ("d", Limited(1.0, low=0.0, high=4.0, scale=2.0))))
    z = np.random.default_rng(0).standard_normal(space.size)
    assert space.form() == other.form() != space
    for whole in (space, other):
        exact, found = whole.constrain(jnp.asarray(z)), whole.form().constrain(jnp.asarray(z))
        assert exact.keys() == found.keys()
        assert all(np.array_equal(exact[name], found[name]) for name in exact)


def test_forms_that_differ_in_their_values_are_unlike():
    unlike = [
        Bounded(0.3, low=-1.0, high=2.0),
        Bounded(0.3, low=-1.0, high=2.5),
        Limited(1.0, low=0.0, high=4.0, scale=2.0),
        Limited(1.0, low=0.0, high=4.0),
        Fixed(1.0),
        Fixed(2.0),
        Positive(1.0, 0.5, 2.0),
        Covariance(EYE, low=0.1, high=9.0),
        Covariance(((1.0,),), low=0.1, high=9.0),
    ]
    assert len({each.form() for each in unlike}) == len(unlike)
