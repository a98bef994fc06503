"""The linear system: its checks, units, samples, and the filter that is made of it."""

from dataclasses import FrozenInstanceError

import jax.numpy as jnp
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

from filters import LinearKalman, Sample, run
from objectives import LinearSystem, covariance, steady_kalman, unobservable
from tests.oracles_ha1981 import van_loan
from tests.strategies import seeds

TIMES = pytest.mark.parametrize("dt", [None, 0.2], ids=["continuous", "discrete"])


def example(dt, n=3, m=2, seed=0, shared=False):
    """A system of any size, detectable and driven; its noises share something where asked."""
    draw = np.random.default_rng(seed)
    A = draw.normal(size=(n, n))
    A = A if dt is None else 0.9 * A / np.abs(np.linalg.eigvals(A)).max()
    G = draw.normal(size=(n + m, n + m))
    joint = G @ G.T
    S = joint[:n, n:] if shared else None
    return LinearSystem(A, draw.normal(size=(m, n)), joint[:n, :n], joint[n:, n:], dt=dt, S=S)


def stabilising(system):
    return steady_kalman(system).predictor


GOOD = {"A": np.eye(2), "C": np.eye(2), "W": np.eye(2), "V": np.eye(2)}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"A": [1.0]}, r"^A has the shape \(1,\); give a matrix$"),
        ({"C": np.zeros((0, 2))}, r"^C has the shape \(0, 2\); give a matrix$"),
        (
            {"C": np.eye(3)},
            r"^C has the shape \(3, 3\); 2 states and 3 measurements need \(3, 2\)$",
        ),
        ({"S": np.eye(3)}, r"^S has the shape \(3, 3\); 2 states .* need \(2, 2\)$"),
        ({"A": np.full((2, 2), np.nan)}, "^A holds nan; give finite numbers$"),
        ({"V": np.diag([np.inf, 1.0])}, "^V holds inf; give finite numbers$"),
        ({"W": np.diag([1.0, -0.5])}, "^W must be positive semi-definite.* the eigenvalue -0.5$"),
        ({"V": [[1.0, 0.5], [0.0, 1.0]]}, "^V must be symmetric$"),
        (
            {"S": 2 * np.eye(2)},
            r"^W and V cannot share S, for .* the eigenvalue -1; give a smaller",
        ),
        ({"dt": 0.0}, "^the sample time is 0 s; give a positive number, or none$"),
        ({"dt": np.nan}, "^the sample time is nan s"),
        ({"states": ["a"]}, r"^1 names \(a\) for 2 states; give one each$"),
    ],
)
def test_what_is_no_system_is_refused(change, sentence):
    with pytest.raises(ValueError, match=sentence):
        LinearSystem(**GOOD | change)


def test_a_system_stays_as_it_was_given():
    given = np.eye(2)
    system = LinearSystem(given, given, given, given)
    given[0, 0] = 5.0
    assert system.A[0, 0] == 1.0
    assert system.states == ("x1", "x2")
    with pytest.raises(ValueError, match="read-only"):
        system.A[0, 0] = 2.0
    with pytest.raises(FrozenInstanceError):
        system.dt = 1.0


def test_no_unit_decides_what_a_covariance_is():
    units = np.array([1e-9, 1.0, 1e9])
    square = np.array([[2.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 2.0]]) * np.outer(units, units)
    np.testing.assert_array_equal(covariance(square, definite=True), square)
    with pytest.raises(ValueError, match="must be positive semi-definite"):
        covariance(square - np.diag([3e-18, 0.0, 0.0]))


@TIMES
@pytest.mark.parametrize("shared", [False, True])
def test_covariance_of_the_error_under_any_gain(dt, shared):
    system = example(dt, shared=shared)
    L = 1.1 * stabilising(system)
    # The noise of the error, drawn from the joint covariance: w - L v = [1, -L] [w; v].
    joint = np.block([[system.W, system.S], [system.S.T, system.V]])
    rows = np.hstack([np.eye(3), -L])
    F, noise = system.A - L @ system.C, rows @ joint @ rows.T
    solve = scipy.linalg.solve_discrete_lyapunov if dt else scipy.linalg.solve_continuous_lyapunov
    expected = solve(F, noise if dt else -noise)
    np.testing.assert_allclose(system.covariance(L), expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(system.steady(jnp.asarray(L)), expected, rtol=1e-9, atol=1e-12)
    poles = np.linalg.eigvals(F)
    slowest = -np.log(np.abs(poles).max()) / dt if dt else -poles.real.max()
    assert system.decay(L) == pytest.approx(slowest, rel=1e-12)
    unstable = system.covariance(-10 * L)
    assert np.isnan(unstable).all()
    assert system.decay(-10 * L) < 0


@TIMES
def test_noise_that_both_share_is_used_by_the_steady_filter(dt):
    """Against scipy's equation with the cross covariance, and against gains beside it."""
    system = example(dt, shared=True, seed=3)
    A, C, W, V, S = system.matrices.values()
    solve = scipy.linalg.solve_discrete_are if dt else scipy.linalg.solve_continuous_are
    P = solve(A.T, C.T, W, V, s=S)
    found = steady_kalman(system)
    L = (
        (A @ P @ C.T + S) @ np.linalg.inv(C @ P @ C.T + V)
        if dt
        else (P @ C.T + S) @ np.linalg.inv(V)
    )
    np.testing.assert_allclose(found.predicted, P, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(found.predictor, L, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(found.predicted, system.covariance(L), rtol=1e-8, atol=1e-10)
    assert np.trace(steady_kalman(example(dt, seed=3)).predicted) > np.trace(P)


def test_a_discrete_measurement_without_noise_has_a_steady_filter():
    system = LinearSystem([[0.9]], [[1.0]], [[2.0]], [[0.0]], dt=1.0)
    found = steady_kalman(system)
    assert found.predicted.item() == pytest.approx(2.0, rel=1e-10)
    assert found.predictor.item() == pytest.approx(0.9, rel=1e-10)


@TIMES
def test_other_units_are_the_same_system(dt):
    system = example(dt)
    states, measurements, time = np.diag([1e-3, 1.0, 1e4]), np.array([10.0, 0.1]), 0.2
    other = system.in_units(states, measurements, time)
    L = stabilising(system)
    per = 1.0 if dt else time
    inside = per * np.linalg.solve(states, L) * measurements
    assert other.decay(inside) == pytest.approx(time * system.decay(L), rel=1e-9)
    back = states @ other.covariance(inside) @ states
    np.testing.assert_allclose(back, system.covariance(L), rtol=1e-9, atol=1e-12)


def test_samples_of_a_continuous_system():
    system = example(None)
    sampled = system.sampled(0.3, 2 * np.eye(2))
    F, Q = van_loan(system.A, system.W, 0.3)
    np.testing.assert_allclose(sampled.A, F, rtol=1e-12)
    np.testing.assert_allclose(sampled.W, Q, rtol=1e-10)
    assert (sampled.dt, sampled.states) == (0.3, system.states)
    with pytest.raises(
        ValueError, match="^the system is discrete, with samples of 0.3 s; sample a"
    ):
        sampled.sampled(0.1, np.eye(2))
    with pytest.raises(ValueError, match="so the system cannot be sampled$"):
        example(None, shared=True).sampled(0.1, np.eye(2))


@pytest.mark.parametrize("diagonal", [False, True])
def test_the_filter_of_a_system_settles_in_its_steady_state(diagonal):
    system = example(0.2)
    if diagonal:
        system = LinearSystem(system.A, system.C, system.W, np.diag([2.0, 3.0]), dt=0.2)
    model = system.filter_model(np.eye(3))
    assert model.R.ndim == (1 if diagonal else 2)
    assert not model.x0.any()
    after = run(LinearKalman(), model, Sample(jnp.zeros((400, 2))))[1].P[-1]
    np.testing.assert_allclose(after, steady_kalman(system).updated, rtol=1e-9, atol=1e-12)


def test_what_makes_no_filter_is_refused():
    with pytest.raises(
        ValueError, match=r"^a filter needs a discrete system; .* sampled\(dt, V\)$"
    ):
        example(None).filter_model(np.eye(3))
    with pytest.raises(
        ValueError, match="^w and v are correlated .* cannot become a filter's model$"
    ):
        example(0.2, shared=True).filter_model(np.eye(3))


def test_hidden_poles_of_both_times():
    A, C = np.diag([-1.0, -2.0, -3.0]), [[1.0, 0.0, 1.0]]
    hidden = unobservable(LinearSystem(A, C, np.eye(3), [[1.0]]))
    assert hidden.values.tolist() == [-2.0]
    step = unobservable(LinearSystem(scipy.linalg.expm(0.1 * A), C, np.eye(3), [[1.0]], dt=0.1))
    np.testing.assert_allclose(step.values, np.exp(-0.2), rtol=1e-14)


# The helper that checks covariances.


def test_semi_definite_matrices_are_allowed_unless_definite_ones_are_asked_for():
    for matrix in (np.zeros((2, 2)), np.ones((2, 2)), np.outer([1e-3, 1e3], [1e-3, 1e3])):
        np.testing.assert_array_equal(covariance(matrix), matrix)
        with pytest.raises(ValueError, match="must be positive definite, but has the eigenvalue"):
            covariance(matrix, definite=True)
    np.testing.assert_array_equal(covariance([[2, 1], [1, 2]], definite=True), [[2, 1], [1, 2]])
    assert covariance([[2, 1], [1, 2]]).dtype == np.float64


@given(seeds(), st.integers(2, 5), st.integers(-12, 12))
def test_rounding_of_a_rank_one_matrix_is_no_negative_eigenvalue(rng, n, exponent):
    vector = rng.normal(size=n)
    covariance(10.0**exponent * np.outer(vector, vector))


def test_the_copy_that_is_returned_is_its_own():
    given = np.eye(2)
    covariance(given)[0, 0] = 5.0
    assert given[0, 0] == 1.0


def test_an_empty_matrix_is_refused():
    with pytest.raises(ValueError, match="must be a square matrix"):
        covariance(np.zeros((0, 0)))
