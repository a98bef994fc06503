"""The vertical channel: its two models, the conventional loop, and filters with stored gains."""

import inspect

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
from hypothesis import assume, given
from hypothesis import strategies as st

from filters import (
    GRAVITY_GRADIENT,
    ConventionalLoop,
    GainedSample,
    KalmanCovariance,
    LinearKalman,
    LinearModel,
    LoopGains,
    Sample,
    StoredGains,
    Transition,
    loop_error,
    loop_step,
    run,
    van_loan,
    vertical_channel,
)
from tests import oracles_ha1981 as ha
from tests.oracles import kalman_predict, kalman_update
from tests.strategies import seeds, stable_models

compiled = jax.jit(run, static_argnums=0)
discrete = jax.jit(van_loan)
stepped = jax.jit(loop_step)
SAME = 1e-10  # a dozen samples against a solve, as in test_linear.py

GAINS = LoopGains(1.2, 0.8, 0.3)
STEEP = 0.05  # a gradient of gravity, 1/s^2, at which nothing about it can be overlooked


def close(actual, expected, tolerance=SAME):
    np.testing.assert_allclose(actual, expected, rtol=0, atol=tolerance * np.abs(expected).max())


# -------------------------------------------------------------------------------------- models


def test_channel_is_model_11():
    assert GRAVITY_GRADIENT == ha.K_GH
    assert 1 / np.sqrt(GRAVITY_GRADIENT) == pytest.approx(571, abs=0.5)  # as the module says
    np.testing.assert_array_equal(vertical_channel(), ha.kalman_F())
    np.testing.assert_array_equal(vertical_channel(STEEP), ha.kalman_F(STEEP))


@pytest.mark.parametrize("Ts", [0.5, 5.0])
def test_channel_over_one_sample_equals_its_closed_form(Ts):
    A, G = vertical_channel(), jnp.array([[0.0], [1.0], [0.0]])
    step, (Phi, Q) = discrete(A, G, jnp.full((1, 1), ha.Q_A), Ts), ha.discrete_closed(Ts)
    np.testing.assert_allclose(step.F, Phi, rtol=1e-13, atol=1e-18)
    np.testing.assert_allclose(step.Q, Q, rtol=1e-13, atol=1e-18)


def five_states(gains, k_gh, fed_back):
    """C of (4) for [A_B, dV, dh, dh_r, A_Bhat]; as printed, A_Bhat is fed back nowhere."""
    K1, K2, K3 = gains
    C = np.zeros((5, 5))
    C[1] = [1, 0, k_gh - K2, K2, -1 if fed_back else 0]
    C[2] = [0, 1, -K1, K1, 0]
    C[4] = [0, 0, K3, -K3, 0]
    return C


TO_ERRORS = np.array([[-1, 0, 0, 0, 1], [0, 0, 1, -1, 0], [0, 1, 0, 0, 0], [0, 0, 0, 1, 0.0]])


@pytest.mark.parametrize("k_gh", [GRAVITY_GRADIENT, STEEP])
def test_loop_error_is_the_scheme_of_the_figure(k_gh):
    """The errors (A_Bhat - A_B, dh - dh_r, dV, dh_r) of the five states move by our matrix."""
    moved = loop_error(GAINS, k_gh) @ TO_ERRORS
    np.testing.assert_allclose(TO_ERRORS @ five_states(GAINS, k_gh, True), moved, atol=1e-16)
    assert np.abs(TO_ERRORS @ five_states(GAINS, k_gh, False) - moved).max() == 1.0


def test_the_loop_defaults_to_the_earths_gradient():
    expected = ha.error_matrix((1.2, 0.8 - ha.K_GH, 0.3))
    np.testing.assert_allclose(loop_error(GAINS), expected, rtol=1e-15)
    assert inspect.signature(loop_step).parameters["k_gh"].default == GRAVITY_GRADIENT


@given(rng=seeds(), k_gh=st.sampled_from([0.0, GRAVITY_GRADIENT, STEEP]))
def test_loop_is_stable_where_routh_and_hurwitz_say_so(rng, k_gh):
    """K1 K2' > K3 > 0 and K1 > 0, of gains of either sign; the fourth state is a constant."""
    K1, K2, K3 = rng.normal(size=3) + rng.integers(3)
    damping = K1 * K2 - K3  # with K2' for K2
    assume(min(abs(K1), abs(K3), abs(damping)) > 1e-3)
    A = np.asarray(loop_error(LoopGains(K1, K2 + k_gh, K3), k_gh))
    np.testing.assert_array_equal(A[3], 0.0)
    growth = np.linalg.eigvals(A[:3, :3]).real.max()
    assert (growth < 0) == (K1 > 0 and damping > 0 and K3 > 0)
    assert (growth < 0) == ha.is_stable((K1, K2, K3))


def test_printed_matrix_forgets_no_bias():
    """The paper's own triple pole: with C as printed the error never settles, with ours it does."""
    K1, K2, K3 = ha.triple_pole_gains(0.01)
    gains = (K1, K2 + ha.K_GH, K3)
    start = np.array([1.0, 0.0, 0.0, 0.0, 0.0])
    ends = [
        TO_ERRORS @ scipy.linalg.expm(five_states(gains, ha.K_GH, fed_back) * 1000) @ start
        for fed_back in (True, False)
    ]
    assert abs(ends[0][0]) < 1e-6
    assert abs(ends[1][0]) > 1.0
    ours = scipy.linalg.expm(np.asarray(loop_error(LoopGains(*gains))) * 1000)
    np.testing.assert_allclose(ours @ TO_ERRORS @ start, ends[0], rtol=0, atol=1e-12)


# ------------------------------------------------------------------------------------ the loop


@pytest.mark.parametrize("k_gh", [GRAVITY_GRADIENT, STEEP])
def test_step_is_the_exact_answer_to_a_held_difference(k_gh):
    K1, K2, K3 = GAINS

    def slope(_, state):
        bias, velocity, altitude = state
        y = 0.7
        return [K3 * y, bias + k_gh * altitude + K2 * y, velocity + K1 * y]

    start = np.array([0.3, -0.4, 0.9])
    solution = scipy.integrate.solve_ivp(
        slope, (0, 1.5), start, method="DOP853", rtol=1e-13, atol=1e-14
    )
    F, B = stepped(GAINS, 1.5, k_gh)
    np.testing.assert_allclose(F @ start + 0.7 * B, solution.y[:, -1], rtol=1e-11)


def channel(start, dt, steps, k_gh):
    """(A_B, dV, dh) of the channel left alone, at 0, dt, ..., steps dt."""
    over = scipy.linalg.expm(ha.kalman_F(k_gh) * dt)
    states = [np.asarray(start, float)]
    for _ in range(steps):
        states.append(over @ states[-1])
    return np.array(states)


def looped(gains, dt, z, k_gh=GRAVITY_GRADIENT):
    return np.asarray(compiled(ConventionalLoop(), stepped(gains, dt, k_gh), jnp.asarray(z))[1])


@pytest.mark.parametrize("dt", [0.05, 0.2])
def test_loop_finds_a_constant_bias(dt):
    """To all digits, however far the channel has run away by then."""
    truth = channel([0.02, 0.5, -3.0], dt, 1600, GRAVITY_GRADIENT)
    found = looped(GAINS, dt, truth[:-1, 2])
    assert truth[-1, 2] > 50.0
    # e^-22 of the first errors is left after 80 s
    np.testing.assert_allclose(found[-1], truth[-1], rtol=1e-9, atol=1e-8)
    assert abs(found[0, 0] - 0.02) > 0.01


@pytest.mark.parametrize("k_gh", [GRAVITY_GRADIENT, STEEP])
def test_wrong_altitude_leaves_its_gravity_as_an_error_of_the_bias(k_gh):
    """epsilon goes to K_gh dh_r, the floor of the paper, whatever the step."""
    found = looped(GAINS, 0.2, np.full(1600, -10.0), k_gh)[-1]
    np.testing.assert_allclose(found, [k_gh * 10.0, 0.0, -10.0], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("k_gh", [GRAVITY_GRADIENT, STEEP])
def test_loop_is_what_its_error_matrix_says(k_gh):
    """As dt -> 0, with order one because the difference is held."""
    start, offset, end = np.array([0.3, 0.4, 2.0]), 1.5, 4.0
    first = np.array([-start[0], start[2] - offset, start[1], offset])
    expected = (scipy.linalg.expm(np.asarray(loop_error(GAINS, k_gh)) * end) @ first)[:3]
    gaps = []
    for steps in (400, 800):
        dt = end / steps
        truth = channel(start, dt, steps, k_gh)
        bias, velocity, altitude = looped(GAINS, dt, truth[:-1, 2] - offset, k_gh)[-1]
        errors = (
            bias - start[0],
            truth[-1, 2] - offset - altitude,
            truth[-1, 1] - velocity,
        )
        gaps.append(np.array(errors) - expected)
    assert np.abs(gaps[0]).max() < 0.02
    np.testing.assert_allclose(gaps[0] / gaps[1], 2.0, rtol=0.02)
    # what is left by extrapolation is of order dt^2 = 1e-4
    np.testing.assert_allclose(2 * gaps[1] - gaps[0], 0.0, atol=1e-4)


def test_missing_difference_leaves_a_prediction():
    rng = np.random.default_rng(4)
    z = rng.normal(size=12)
    expected = looped(GAINS, 0.1, z[:6])[-1]
    for hole in (6, 7):
        z[hole] = np.nan
    actual = looped(GAINS, 0.1, z)
    F, B = (np.asarray(part) for part in stepped(GAINS, 0.1, GRAVITY_GRADIENT))
    for k in range(6, 12):
        expected = F @ expected + (0.0 if k in (6, 7) else B * (z[k] - expected[2]))
        np.testing.assert_allclose(actual[k], expected, rtol=1e-12)
    # no difference at all: a loop at rest stays there
    np.testing.assert_array_equal(looped(GAINS, 0.1, np.full(12, np.nan)), 0.0)


def test_slope_in_the_loops_gains():
    z = jnp.asarray(np.random.default_rng(6).normal(size=12))
    along = jnp.array([1.0, -0.4, 0.7])

    @jax.jit
    def slope(gains):
        def total(gains):
            step = loop_step(LoopGains(*gains), 0.3, STEEP)
            squares = (run(ConventionalLoop(), step, z)[1] ** 2).sum()
            return squares + (jnp.sin(loop_error(LoopGains(*gains), STEEP)) ** 2).sum()

        return jax.jvp(total, (gains,), (along,))

    point, h = jnp.array(GAINS), 1e-5
    difference = (slope(point + h * along)[0] - slope(point - h * along)[0]) / (2 * h)
    # h^2 = 1e-10 and eps/h = 2e-11, each times ten
    assert float(slope(point)[1]) == pytest.approx(float(difference), rel=1e-8)


# -------------------------------------------------------------------------------- stored gains


def moved_by(model):
    n = len(model.P0)
    move = Transition(F=jnp.asarray(model.F), G=jnp.eye(n), Q=jnp.asarray(model.W))
    parts = (jnp.asarray(part) for part in (model.H, model.R, model.P0, model.x0))
    return LinearModel(move, *parts)


def predicting_first(params, z):
    """LinearKalman, its first prediction made to be nothing."""
    F, G, Q, _ = params.transition
    stack = [jnp.broadcast_to(part, (len(z), *part.shape)) for part in (F, G, Q)]
    move = Transition(stack[0].at[0].set(jnp.eye(len(F))), stack[1], stack[2].at[0].set(0.0))
    return compiled(LinearKalman(), params, Sample(jnp.asarray(z), transition=move))[1].x


def stored(params, z, K):
    return compiled(StoredGains(), params, GainedSample(jnp.asarray(z), jnp.asarray(K)))


def gains_where_seen(model, z, elsewhere):
    """Textbook gains of a record with holes; a missing measurement's column is what you like."""
    x, P, Ks = model.x0, model.P0, []
    for row, K in zip(z, elsewhere, strict=True):
        seen = ~np.isnan(row)
        H, R = model.H[seen], model.R[np.ix_(seen, seen)]
        K[:, seen] = np.linalg.solve(H @ P @ H.T + R, H @ P).T
        Ks.append(K)
        x, P = kalman_predict(*kalman_update(x, P, model.H, model.R, row), model.F, model.W)
    return np.array(Ks)


@given(drawn=stable_models(missing=False))
def test_stored_gains_of_the_kalman_filter_are_the_kalman_filter(drawn):
    model, z = drawn
    params = moved_by(model)
    K = compiled(KalmanCovariance(), params, np.empty(len(z)))[1].K
    close(stored(params, z, K)[1], predicting_first(params, z))


@given(drawn=stable_models(), rng=seeds())
def test_missing_measurements_do_nothing_whatever_their_gain(drawn, rng):
    model, z = drawn
    params = moved_by(model)
    K = gains_where_seen(model, z, rng.normal(size=(len(z), 3, 2)))
    close(stored(params, z, K)[1], predicting_first(params, z))


def test_stored_gains_put_out_before_they_predict():
    rng = np.random.default_rng(13)
    F, H, K = (rng.normal(size=shape) for shape in ((3, 3), (2, 3), (12, 3, 2)))
    z, x0 = rng.normal(size=(12, 2)), rng.normal(size=3)
    move = Transition(jnp.asarray(F / 3), jnp.eye(3), jnp.eye(3))
    params = LinearModel(move, jnp.asarray(H), jnp.ones(2), jnp.eye(3), jnp.asarray(x0))
    state, outputs = stored(params, z, 0.2 * K)
    x = x0
    for k in range(12):
        x = x + 0.2 * K[k] @ (z[k] - H @ x)
        np.testing.assert_allclose(outputs[k], x, rtol=0, atol=1e-12 * np.abs(x).max())
        x = F / 3 @ x
    np.testing.assert_allclose(state, x, rtol=0, atol=1e-12 * np.abs(x).max())
