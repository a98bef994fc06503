"""A problem's value, gradient, Hessian and score; what it refuses; what it compiles."""

import dataclasses
import re
from functools import cache

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.signal import get_window, welch

from filters import AccelerometerFilter, GyroscopeFilter, KownackiNoise
from objectives import Crossing, Data, Reading, StepResponse, Welch
from studies.kownacki2010 import problems
from studies.kownacki2010.data import benches
from studies.kownacki2010.paper import ACC, GYRO
from studies.kownacki2010.settings import Settings
from tests.oracles import central_difference, lag_below, lag_to_first_crossing
from tests.tuner.helpers import ANY, SQUARE, Echo, bowl, hollow, logarithms, problem, ratio
from tuner.problem.parameters import Covariance, Fixed, Positive
from tuner.problem.problem import Problem
from tuner.problem.programs import value_and_gradient_of, value_of
from tuner.problem.space import Space

DT, N = 1e-3, 2001


@cache
def bench(sensor):
    """The paper's sensor on a fifth of its samples, at a tenth of its rate."""
    made = benches(Settings(seconds=2.0, rate_hz=1e3), None, 0)
    return next(one for one in made if one.sensor is sensor)


# The same in plain NumPy: Phi = [1 T; 0 1], W = Q T^2 I, P0 = ones.


def filtered(sensor, R, Q, z):
    """The filter's output, by matrices, sample after sample."""
    phi, W = np.array([[1.0, DT], [0.0, 1.0]]), Q * DT**2 * np.eye(2)
    h = np.array([1.0, 0.0]) if sensor is GYRO else np.array([0.0, 1.0])
    if sensor is ACC:
        phi = np.eye(2)  # the acceleration neither drives nor is driven
    x, P, outputs = np.zeros(2), np.ones((2, 2)), []
    for sample in z:
        x, P = phi @ x, phi @ P @ phi.T + W
        K = P @ h / (h @ P @ h + R)
        x = x + K * (sample - h @ x)
        keep = np.eye(2) - np.outer(K, h)
        P = keep @ P @ keep.T + R * np.outer(K, K)
        outputs.append(h @ x)
    return np.array(outputs)


def spectrum(x):
    """MATLAB's pwelch with its default options, by scipy."""
    segment = int(N / 4.5)
    taper = get_window("hamming", segment, fftbins=False)
    return welch(
        x, 1 / DT, taper, noverlap=segment // 2, nfft=512, detrend=False, scaling="density"
    )


def plain_cost(made, R, Q, reading, crossing):
    answer = filtered(made.sensor, R, Q, made.step)
    noise = filtered(made.sensor, R, Q, made.record)
    lag = (made.step - answer - noise)[made.step > 0]
    inertia = lag_below(lag, DT) if crossing == "hinge" else lag_to_first_crossing(lag, DT)[0]
    frequencies, power = spectrum(answer + noise if reading == "R1" else noise)
    density = np.sqrt(power) if reading == "R6" else power
    return inertia + density.sum() * frequencies[1]


@pytest.mark.parametrize("sensor", [GYRO, ACC], ids=["gyro", "acc"])
@pytest.mark.parametrize(
    ("reading", "crossing"), [("R6", "hinge"), ("R1", "first"), ("R2", "hinge")]
)
def test_value_is_that_of_a_plain_computation(sensor, reading, crossing):
    made = bench(sensor)
    settings = made.settings.model_copy(update={"reading": reading, "crossing": crossing})
    posed = problems.paper(dataclasses.replace(made, settings=settings))
    for R, Q in ((1e-6, 1e-3), (2e-4, 0.5)):
        value = posed.value(np.log([R, Q]))
        # 2001 samples summed in another order and another form of the covariance: 2001 eps.
        assert value == pytest.approx(plain_cost(made, R, Q, reading, crossing), rel=1e-10)
        assert posed.value_and_gradient(np.log([R, Q]))[0] == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize("sensor", [GYRO, ACC], ids=["gyro", "acc"])
@pytest.mark.parametrize("q_over_r", [30.0, 3000.0])
def test_gradient_equals_finite_differences(sensor, q_over_r):
    posed = problems.paper(bench(sensor))
    z = np.log([1e-4, 1e-4 * q_over_r])
    value, gradient = posed.value_and_gradient(z)
    # Steps of 1e-3 in a logarithm: truncation 1e-6 of the value, rounding far below; the hinge
    # bends where single samples cross the step, which leaves as much again.
    difference = central_difference(posed.value, z, 1e-3)
    np.testing.assert_allclose(gradient, difference, rtol=0, atol=1e-5 * value)
    assert np.abs(gradient).max() > 1e-3 * value  # there is something to compare


def test_hessian_of_a_quadratic():
    # Central differences of an exact gradient are exact for a quadratic, up to eps / step = 1e-13.
    hessian = problem(bowl).hessian(np.array([0.3, 0.7]))
    np.testing.assert_allclose(hessian, [[2.0, 0.6], [0.6, 1.0]], atol=1e-11)
    assert (hessian == hessian.T).all()


def test_hessian_of_the_study_is_symmetric_and_that_of_its_values():
    posed = problems.paper(bench(GYRO))
    z = np.log([1e-4, 0.05])
    hessian = posed.hessian(z)
    assert (hessian == hessian.T).all()
    h, value = 0.02, posed.value(z)
    for d in ([1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0]):
        along = h * np.array(d)
        second = (posed.value(z + along) - 2 * value + posed.value(z - along)) / h**2
        # Truncation of order h^2 = 4e-4, and the hinge's bends.
        assert np.array(d) @ hessian @ d == pytest.approx(second, rel=5e-3, abs=2e-3 * value)


# Data that is refused.


@dataclasses.dataclass(frozen=True)
class Pass:
    """A filter that outputs its input."""

    def init(self, params):
        return ()

    def step(self, params, state, inputs):
        return state, inputs


def build_nothing(values):
    return values["a"]


def with_data(inputs, truth):
    space = Space.of(a=Positive(1.0, 0.1, 10.0))
    return Problem("given", space, Pass(), build_nothing, bowl, Data(inputs, truth))


SINGLE = (
    "is float32, in which slow gains may be wrong by their own size; convert it to float64 with "
    "np.asarray(x, float)"
)


@pytest.mark.parametrize("make", [np.float32, jnp.float32])
def test_single_precision_is_refused(make):
    good, bad = np.ones(5), np.ones(5).astype(make)
    for data, where in (
        ((bad, good), ".inputs"),
        ((good, bad), ".truth"),
        (((good, {"gyr": bad}), good), ".inputs[1]['gyr']"),
    ):
        with pytest.raises(ValueError, match=f"^{re.escape(f'data{where} {SINGLE}')}$"):
            with_data(*data)


def test_half_precision_is_refused():
    with pytest.raises(ValueError, match="is float16, in which slow gains"):
        with_data(np.ones(5, np.float16), np.ones(5))


@pytest.mark.parametrize("infinite", [np.inf, -np.inf])
def test_infinite_values_are_refused_with_their_place(infinite):
    bad = np.ones((5, 2))
    bad[3, 1] = infinite
    sentence = "data.inputs is infinite at (3, 1); use NaN if missing"
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        with_data(bad, np.ones(5))


def test_unequal_lengths_are_refused():
    sentence = "the data of given has unequal lengths [4, 5]"
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        with_data(np.ones(5), np.ones(4))


def test_missing_samples_whole_numbers_and_scalars_are_allowed():
    with_data(np.array([1.0, np.nan]), (np.arange(2), 3.0))


# Names.


def test_score_of_given_parameters():
    space = Space.of(a=Positive(1.0, 0.1, 10.0, unit="m"), b=Fixed(2.0))
    posed = problem(bowl, space=space)
    # exp(ln a) would be off in the last place: the score is that of the very number.
    x, y = np.log(3.0) - 1, np.log(2.0) + 1
    expected = 1.0 + x**2 + 0.5 * y**2 + 0.6 * x * y
    assert posed.score({"a": 3.0, "b": 2.0}) == pytest.approx(expected, rel=1e-15)
    assert posed.score({"a": np.array(3.0), "b": np.array(2.0)}) == posed.score({"a": 3, "b": 2.0})


def test_score_is_exact_where_z_is_rounded():
    @dataclasses.dataclass(frozen=True)
    class Plain:
        def init(self, params):
            return ()

        def step(self, params, state, inputs):
            return state, params["a"]

    space = Space.of(a=Positive(1.0, 1e-12, 1e12))
    posed = Problem("plain", space, Plain(), dict, lambda outputs, _: outputs[-1], ANY)
    numbers = np.random.default_rng(0).lognormal(sigma=8, size=50)
    assert [posed.score({"a": n}) for n in numbers] == numbers.tolist()
    assert [posed.value(np.log([n])) for n in numbers] != numbers.tolist()


def test_score_takes_a_covariance_as_it_is():
    space = Space.of(P=Covariance(((1.0, 0.0), (0.0, 1.0)), low=1e-3, high=1e3))
    posed = Problem(
        "trace",
        space,
        Echo(),
        lambda values: jnp.ravel(values["P"]),
        lambda outputs, _: outputs[-1] @ jnp.array([1.0, 10.0, 100.0, 1000.0]),
        ANY,
    )
    assert posed.score({"P": [[2.0, 0.5], [0.5, 3.0]]}) == 2.0 + 5.0 + 50.0 + 3000.0


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"a": 1.0}, "bowl has no value for b: give them all"),
        ({}, "bowl has no value for a, b: give them all"),
        ({"a": 1.0, "b": 1.0, "c": 1.0}, "unknown parameter 'c'; there are: a, b"),
        ({"a": 1.0, "b": -1.0}, "b must be positive and finite, got -1"),
    ],
)
def test_score_refuses(parameters, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        problem(bowl).score(parameters)


def test_not_a_number_is_infinite():
    posed = problem(hollow)
    assert posed.value(np.zeros(2)) == np.inf
    assert posed.value_and_gradient(np.zeros(2))[0] == np.inf


def test_parameters_and_derived_quantities():
    posed = problem(bowl, space=Space.of(a=Fixed(2.0), b=Positive(1.0, 0.1, 10.0)))
    z = np.log([5.0])
    assert posed.parameters(z)["a"] == 2.0
    assert posed.parameters(z)["b"] == pytest.approx(5.0, rel=1e-15)
    assert posed.derived(z) == {"b_over_a": pytest.approx(2.5, rel=1e-15)}
    assert dataclasses.replace(posed, derive=None).derived(z) == {}


# Compilation.


def test_equal_problems_share_one_compilation():
    def again():
        space = Space.of(**{name: dataclasses.replace(p) for name, p in SQUARE.parameters})
        return Problem("another name", space, Echo(), logarithms, bowl, ANY, ratio)

    problem(bowl).value(np.zeros(2))
    problem(bowl).value_and_gradient(np.zeros(2))
    sizes = value_of._cache_size(), value_and_gradient_of._cache_size()
    again().value(np.ones(2))
    again().value_and_gradient(np.ones(2))
    assert (value_of._cache_size(), value_and_gradient_of._cache_size()) == sizes
    other = dataclasses.replace(again(), objective=lambda outputs, _: outputs.sum())
    other.value(np.ones(2))
    assert value_of._cache_size() == sizes[0] + 1


def test_what_a_problem_is_compiled_for_is_made_once():
    one = problem(bowl)
    assert one.scored is one.scored
    assert one.static is one.static
    assert dataclasses.replace(one, objective=hollow).static != one.static


def test_new_numbers_in_the_data_need_no_new_compilation():
    made = bench(ACC)
    filter, welch_ = AccelerometerFilter(DT, (2,)), Welch.matlab(N)
    objective = StepResponse(DT, welch_, Reading.R2, Crossing.HINGE)
    space = Space.of(Q=Positive(1.0, 1e-3, 1e3))

    def posed(record):
        data = Data(np.stack([made.step, record], axis=1), objective.truth(made.step))
        return Problem("data", space, filter, unit_noise, objective, data)

    first = posed(made.record).value(np.zeros(1))
    size = value_of._cache_size()
    assert posed(2 * made.record).value(np.zeros(1)) != first
    assert value_of._cache_size() == size


def unit_noise(values):
    return KownackiNoise(1.0, values["Q"], jnp.ones((2, 2)))


def test_a_problem_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        problem(bowl).name = "other"
    assert hash(problem(bowl).static) == hash(problem(bowl).static)
    assert problem(bowl).static == problem(bowl).static
    assert problem(bowl).static.filter == Echo() != GyroscopeFilter(DT)
