"""Covariances without measurements: textbook loops, another integrator, and printed numbers."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.integrate
import scipy.interpolate
import scipy.linalg
import scipy.optimize
from hypothesis import given
from hypothesis import strategies as st
from jax.flatten_util import ravel_pytree

from filters import (
    Flow,
    GainCovariance,
    GainTable,
    KalmanCovariance,
    LinearModel,
    LoopGains,
    RiccatiCovariance,
    TableCovariance,
    Transition,
    loop_error,
    riccati_flow,
    run,
    van_loan,
    vertical_channel,
)
from tests import oracles_ha1981 as ha
from tests.oracles import Model, central_difference, kalman_predict, kalman_update
from tests.published import as_printed
from tests.strategies import covariance, seeds, stable_models

compiled = jax.jit(run, static_argnums=0)
discrete = jax.jit(van_loan)

# A dozen samples, some ten operations deep each and with an R of condition 1e2 at most.
SAME = 1e-12
N = 12


def near(actual, expected, tolerance=SAME):
    """Equal to the given share of each sample's largest entry."""
    expected = np.asarray(expected)
    scale = np.abs(expected).max(axis=tuple(range(1, expected.ndim)), keepdims=True)
    assert (np.abs(actual - expected) <= tolerance * np.maximum(scale, 1e-300)).all()


def built(model, **changes):
    n = len(model.P0)
    move = Transition(F=jnp.asarray(model.F), G=jnp.eye(n), Q=jnp.asarray(model.W))
    parts = {name: jnp.asarray(getattr(model, name)) for name in ("H", "R", "P0", "x0")}
    return LinearModel(transition=move, **parts)._replace(**changes)


def optimal(params, samples=N):
    return compiled(KalmanCovariance(), params, np.empty(samples))[1]


def given_gains(params, K):
    return compiled(GainCovariance(), params, jnp.asarray(K))[1].P


def textbook(model, samples=N):
    """P(+) and K, measured first; R is the full matrix."""
    x, P, Ps, Ks = model.x0, model.P0, [], []
    for _ in range(samples):
        Ks.append(np.linalg.solve(model.H @ P @ model.H.T + model.R, model.H @ P).T)
        x, P = kalman_update(x, P, model.H, model.R, np.zeros(len(model.R)))
        Ps.append(P)
        x, P = kalman_predict(x, P, model.F, model.W)
    return np.array(Ps), np.array(Ks)


def joseph(model, gains):
    """P(+) with the given gains, measured first."""
    P, Ps = model.P0, []
    for K in gains:
        keep = np.eye(len(P)) - K @ model.H
        Ps.append(keep @ P @ keep.T + K @ model.R @ K.T)
        P = model.F @ Ps[-1] @ model.F.T + model.W
    return np.array(Ps)


# ------------------------------------------------------------------------- against plain loops


@given(drawn=stable_models(missing=False))
def test_kalman_equals_the_textbook_for_any_model(drawn):
    model, _ = drawn
    P, K = textbook(model)
    outputs = optimal(built(model))
    near(outputs.P, P)
    near(outputs.K, K)


@given(drawn=stable_models(missing=False))
def test_diagonal_R_equals_the_same_R_written_in_full(drawn):
    model, _ = drawn
    diagonal = np.diag(model.R)
    params = built(model, R=jnp.asarray(diagonal))
    model = model._replace(R=np.diag(diagonal))
    P, K = textbook(model)
    outputs = optimal(params)
    near(outputs.P, P)
    near(outputs.K, K)
    near(given_gains(params, 0.5 * K), joseph(model, 0.5 * K))


STARTS = {
    "rank one": np.ones((3, 3)),
    "zero": np.zeros((3, 3)),
    "full": np.diag([1.0, 2.0, 3.0]),
}


def example(m, P0):
    rng = np.random.default_rng(1981)
    F = np.array([[0.9, 0.2, 0.0], [-0.2, 0.9, 0.1], [0.0, 0.0, 0.95]])
    G, Q = rng.normal(size=(3, 2)), covariance(rng, 2, 2)
    R = covariance(rng, m, m) + 0.5 * np.eye(m)
    params = LinearModel(
        transition=Transition(jnp.asarray(F), jnp.asarray(G), jnp.asarray(Q)),
        H=jnp.asarray(rng.normal(size=(m, 3))),
        R=jnp.asarray(R),
        P0=jnp.asarray(STARTS[P0]),
        x0=jnp.asarray(rng.normal(size=3)),
    )
    return params, plain(params)


def plain(params):
    """The same for the textbook."""
    F, G, Q, _ = (None if part is None else np.asarray(part) for part in params.transition)
    H, R, P0, x0 = (np.asarray(part) for part in params[1:])
    return Model(F, G @ Q @ G.T, H, R, P0, x0)


@pytest.mark.parametrize("P0", STARTS)
@pytest.mark.parametrize("m", [1, 2])
def test_any_number_of_measurements_and_any_start(m, P0):
    params, model = example(m, P0)
    P, K = textbook(model)
    outputs = optimal(params)
    near(outputs.P, P)
    near(outputs.K, K)
    gains = np.random.default_rng(m).normal(size=(N, 3, m)) * 0.3
    near(given_gains(params, gains), joseph(model, gains))


@given(drawn=stable_models(missing=False), rng=seeds())
def test_given_gains_are_right_whatever_they_are(drawn, rng):
    model, _ = drawn
    gains = rng.normal(size=(N, 3, 2)) * 10.0 ** rng.uniform(-3, 1)
    near(given_gains(built(model), gains), joseph(model, gains))


@given(drawn=stable_models(missing=False))
def test_given_the_optimal_gains_both_are_one(drawn):
    model, _ = drawn
    outputs = optimal(built(model))
    near(given_gains(built(model), outputs.K), outputs.P)


@given(drawn=stable_models(missing=False), rng=seeds(), exponent=st.floats(-4, 0))
def test_no_gains_are_better_than_the_optimal_ones(drawn, rng, exponent):
    """The Kalman filter is the best linear one: P - P_optimal is positive semi-definite.

    And it is dK S dK' at the first sample, so what is too small to be seen is known to be so.
    """
    model, _ = drawn
    outputs = optimal(built(model))
    moved = 10.0**exponent * rng.normal(size=(N, 3, 2))
    P = np.asarray(given_gains(built(model), outputs.K + moved))
    excess = P - outputs.P
    size = np.abs(P).max(axis=(1, 2))
    assert (np.linalg.eigvalsh(excess).min(axis=1) >= -SAME * size).all()
    S = model.H @ model.P0 @ model.H.T + model.R
    first = moved[0] @ S @ moved[0].T
    np.testing.assert_allclose(excess[0], first, rtol=0, atol=SAME * size[0])


@given(drawn=stable_models(missing=False), rng=seeds())
def test_a_table_is_its_gains_in_turn(drawn, rng):
    model, _ = drawn
    table, turns = jnp.asarray(rng.normal(size=(3, 3, 2))), jnp.asarray(rng.integers(3, size=N))
    outputs = compiled(TableCovariance(), GainTable(built(model), table), turns)[1]
    np.testing.assert_array_equal(outputs.K, table[turns])
    near(outputs.P, joseph(model, np.asarray(table)[np.asarray(turns)]))


def test_last_state_is_the_prediction_after_the_last_sample():
    params, model = example(2, "rank one")
    P, K = textbook(model)
    ahead = model.F @ P[-1] @ model.F.T + model.W
    for filter, inputs in ((KalmanCovariance(), np.empty(N)), (GainCovariance(), jnp.asarray(K))):
        near(compiled(filter, params, inputs)[0][None], ahead[None])


def test_inputs_only_count():
    params, flow = example(2, "full")[0], continuous(1)[0]
    counted = compiled(KalmanCovariance(), params, np.full(N, np.nan))[1]
    jax.tree.map(np.testing.assert_array_equal, counted, optimal(params))
    P = compiled(RiccatiCovariance(), flow, np.full(401, np.nan))[1]
    np.testing.assert_array_equal(P, followed(flow, 401))


# ------------------------------------------------------------------------------ continuous time


def matrices(m):
    """A detectable model with a mode that grows, noise on every state and correlated V."""
    rng = np.random.default_rng(1961)
    A = np.array([[0.1, 1.0, 0.0], [-1.0, -0.3, 0.5], [0.0, 0.0, -0.2]])
    W, V = covariance(rng, 3, 3) + 0.1 * np.eye(3), covariance(rng, m, m) + 0.5 * np.eye(m)
    return A, rng.normal(size=(m, 3)), W, V


def continuous(m, dt=0.1, P0=None):
    A, C, W, V = matrices(m)
    M = riccati_flow(*(jnp.asarray(part) for part in (A, C, W, V, dt)))
    return Flow(M, jnp.asarray(STARTS["full"] if P0 is None else P0)), (A, C, W, V)


def followed(flow, steps):
    """P at the start of each step; always as many, for each length is a compilation."""
    return np.asarray(compiled(RiccatiCovariance(), flow, np.empty(401))[1][:steps])


@pytest.mark.parametrize("P0", STARTS)
@pytest.mark.parametrize("m", [1, 2])
def test_riccati_equals_an_integrator(m, P0):
    flow, (A, C, W, V) = continuous(m, P0=STARTS[P0])

    def slope(_, P):
        P = P.reshape(3, 3)
        return (A @ P + P @ A.T + W - P @ C.T @ np.linalg.solve(V, C @ P)).ravel()

    times = 0.1 * np.arange(40)
    solution = scipy.integrate.solve_ivp(
        slope,
        (0, times[-1]),
        STARTS[P0].ravel(),
        method="DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-13,
    )
    # the first output is P0 itself; the integrator keeps its tolerance a step, over some 100 steps
    near(followed(flow, 40), solution.y.T.reshape(-1, 3, 3), 1e-10)


@pytest.mark.parametrize("m", [1, 2])
def test_riccati_ends_where_the_algebraic_equation_is_solved(m):
    flow, (A, C, W, V) = continuous(m, dt=1.0)
    limit = scipy.linalg.solve_continuous_are(A.T, C.T, W, V)
    near(followed(flow, 201)[-1:], limit[None], 1e-11)  # the slowest mode moves at 0.2 1/s
    stays = followed(flow._replace(P0=jnp.asarray(limit)), 201)
    near(stays, np.broadcast_to(limit, stays.shape), 1e-11)


def test_riccati_does_not_depend_on_the_step():
    coarse, fine = (followed(continuous(2, dt)[0], n) for dt, n in ((0.5, 41), (0.05, 401)))
    near(coarse, fine[::10], 1e-10)
    flows = [paper_flow(dt) for dt in (1.0, 0.1)]
    near(followed(flows[0], 41), followed(flows[1], 401)[::10], 1e-10)


def test_riccati_is_the_limit_of_fast_measurements():
    """Measurements every dt with R = V / dt: a scheme of first order."""
    flow, (A, C, W, V) = continuous(1, dt=1.0)
    P = followed(flow, 3)[2]
    gaps = []
    for n in (100, 200):
        F, Q = (jnp.asarray(part) for part in ha.van_loan(A, W, 2.0 / n))
        move = Transition(F, jnp.eye(3), Q)
        R = jnp.asarray(n * V[0] / 2)
        params = LinearModel(move, jnp.asarray(C), R, flow.P0, jnp.zeros(3))
        gaps.append(np.asarray(optimal(params, SAMPLES).P[n]) - P)
    np.testing.assert_allclose(gaps[0] / gaps[1], 2.0, rtol=0.05)


# ------------------------------------------------------------------- the numbers of Ha et al. 1981

SAMPLES = 250
G, C = jnp.array([[0.0], [1.0], [0.0]]), jnp.array([[0.0, 0.0, 1.0]])  # of the vertical channel


def paper(Ts, *, k_gh=ha.K_GH, q_a=ha.Q_A, q_b=ha.Q_B, P0=ha.KALMAN_P0):
    move = discrete(vertical_channel(k_gh), G, jnp.eye(1), Ts)
    move = move._replace(Q=q_a * move.Q)
    return LinearModel(move, C, jnp.reshape(q_b, 1), jnp.asarray(P0), jnp.zeros(3))


def paper_flow(dt):
    A = vertical_channel(ha.K_GH)
    M = riccati_flow(A, C, G @ G.T * ha.Q_A, jnp.array([[ha.Q_B]]), jnp.array(dt))
    return Flow(M, jnp.asarray(ha.KALMAN_P0))


def crossing(times, values, level):
    """Last time at which values fall through the level, on a cubic spline."""
    k = np.flatnonzero(np.asarray(values) > level)[-1]
    near = slice(max(k - 3, 0), k + 5)
    spline = scipy.interpolate.CubicSpline(times[near], values[near] - level)
    return scipy.optimize.brentq(spline, times[k], times[k + 1])


@pytest.mark.parametrize("Ts", ha.P11)
def test_paper_covariance_of_the_bias(Ts):
    outputs = optimal(paper(Ts), SAMPLES)
    for t, printed in ha.P11[Ts].items():
        assert float(outputs.P[round(t / Ts), 0, 0]) == as_printed(printed)
    history = ha.kalman_history(Ts, SAMPLES - 1)
    # P falls from 100 to 1e-4, and the oracle's update P - P h' h P / s subtracts
    np.testing.assert_allclose(outputs.P, history.P, rtol=1e-9)
    np.testing.assert_allclose(outputs.K[:, :, 0], history.K, rtol=1e-9)


@pytest.mark.parametrize("Ts", ha.KALMAN_REACHES)
def test_paper_time_to_reach_the_bound(Ts):
    reached = np.asarray(optimal(paper(Ts), SAMPLES).P[:, 0, 0]) <= ha.BOUND
    assert int(np.argmax(reached)) * Ts == as_printed(ha.KALMAN_REACHES[Ts])


@pytest.mark.parametrize("Ts", ha.STEADY)
def test_paper_steady_gains(Ts):
    """K_gh -> 0 and a bias that is known: an unknown one takes 1/t to settle."""
    known = np.diag([0.0, 0.0, ha.VAR_HR])
    K = np.asarray(optimal(paper(Ts, k_gh=0.0, P0=known), SAMPLES).K[-1, :, 0])
    assert K[0] == 0.0
    assert (K[1], K[2]) == tuple(as_printed(printed) for printed in ha.STEADY[Ts][2:])
    np.testing.assert_allclose(K[1:], ha.steady_closed(Ts)[2:], rtol=1e-11)  # B subtracts
    tiny = optimal(paper(Ts, k_gh=1e-12, P0=known), SAMPLES).K[-1, :, 0]
    np.testing.assert_allclose(tiny, K, rtol=0, atol=1e-10)


def test_paper_riccati():
    P = followed(paper_flow(1.0), 106)
    for t, printed in ha.P11_RICCATI.items():
        assert P[t, 0, 0] == as_printed(printed)
    near(P, ha.riccati_history(np.arange(106.0)), 1e-10)
    assert crossing(np.arange(106.0), P[:, 0, 0], ha.BOUND) == pytest.approx(104.233, abs=0.01)
    fine = followed(paper_flow(0.01)._replace(P0=jnp.asarray(P[104])), 101)[:, 0, 0]
    assert crossing(104 + 0.01 * np.arange(101), fine, ha.BOUND) == as_printed(ha.RICCATI_REACHES)


def loop(gains, dt, *, q_a=ha.Q_A, k_gh=ha.K_GH, P0=ha.LOOP_P0):
    """The conventional scheme, which takes no measurement: its gains are in its error matrix."""
    K1, K2, K3 = gains
    A = loop_error(LoopGains(K1, K2 + k_gh, K3), k_gh)
    move = discrete(A, jnp.eye(4)[:, 2:3], jnp.full((1, 1), q_a), dt)
    return LinearModel(move, jnp.eye(1, 4), jnp.ones(1), jnp.asarray(P0), jnp.zeros(4))


def loop_covariance(gains, dt, steps, **model):
    """E (eps, e, dV, dh_r)^2 at 0, dt, ..., steps dt."""
    return np.asarray(given_gains(loop(gains, dt, **model), jnp.zeros((steps + 1, 4, 1))))


def loop_variance(gains, dt, steps, **model):
    """E eps^2 at 0, dt, ..., steps dt."""
    return loop_covariance(gains, dt, steps, **model)[:, 0, 0]


def test_paper_loop_variance():
    gains = ha.triple_pole_gains(0.01)
    variance = loop_variance(gains, 10.0, 30)
    for t, printed in ha.LOOP_VARIANCE.items():
        assert variance[t // 10] == as_printed(printed)
    times = 10.0 * np.arange(31)
    np.testing.assert_allclose(variance, ha.conventional_variance(gains, times), rtol=1e-10)


def test_paper_loop_floor():
    """Without noise only the altitude's error is left, through gravity's gradient."""
    left = loop_variance(ha.triple_pole_gains(0.01), 100.0, 30, q_a=0.0)[-1]
    assert left == as_printed(ha.FLOOR)


def test_paper_loop_reaches_the_bound():
    times = 0.1 * np.arange(3001)
    variance = loop_variance(ha.triple_pole_gains(0.01), 0.1, 3000)
    for level, printed in ha.LOOP_REACHES.items():
        assert crossing(times, variance, level * ha.BOUND) == as_printed(printed)


def test_paper_stages():
    one = loop_covariance(ha.triple_pole_gains(ha.ONE_STAGE_ETA), 105.0, 30)[1]
    P, switch = ha.LOOP_P0, ha.TWO_STAGE_SWITCH
    for eta, seconds in zip(ha.TWO_STAGE_ETAS, (switch, 105.0 - switch), strict=True):
        P = loop_covariance(ha.triple_pole_gains(eta), seconds, 30, P0=P)[1]
    assert one[0, 0] * 105 / ha.Q_A == as_printed(ha.ONE_STAGE)
    assert P[0, 0] * 105 / ha.Q_A == as_printed(ha.TWO_STAGES)


@pytest.mark.parametrize("name", ha.DESIGNS)
def test_paper_step_errors(name):
    """From eps = -1 and without noise the variance is the step error's square; eta = 1."""
    design = ha.DESIGNS[name]
    gains = ha.scaled_to_bound(design.shape, 1.0)
    dt, steps = 0.01, 3000
    square = loop_variance(gains, dt, steps, q_a=0.0, k_gh=0.0, P0=np.diag([1.0, 0, 0, 0]))
    assert scipy.integrate.simpson(square, dx=dt) == as_printed(design.ise)
    times = dt * np.arange(steps + 1)
    assert crossing(times, square, 0.05**2) == as_printed(design.settling_5)
    assert crossing(times, square, 0.02**2) == as_printed(design.settling_2)
    if name == "triple pole":
        assert crossing(times / 0.01, square, 0.02**2) == as_printed(ha.SETTLING_2_WORKED)


def test_paper_sensitivities_are_logarithmic_derivatives():
    """With the gains held; and through the optimal ones too, for those are where P is least."""
    model = paper(5.0, q_a=1.0)
    K = optimal(paper(5.0), SAMPLES).K
    nominal = np.log([ha.Q_A, ha.Q_B, ha.VAR_AB])

    def log_variance(point, filter, inputs):
        q_a, q_b, bias = jnp.exp(point)
        P0 = jnp.diag(jnp.stack([bias, jnp.zeros(()), jnp.asarray(ha.VAR_HR)]))
        move = model.transition._replace(Q=q_a * model.transition.Q)
        params = model._replace(transition=move, R=q_b[None], P0=P0)
        outputs = run(filter, params, inputs)[1]
        return jnp.log(outputs.P[:, 0, 0])

    shares = jax.jit(jax.jacfwd(log_variance), static_argnums=1)
    held = np.asarray(shares(nominal, GainCovariance(), K))
    for t, printed in ha.SENSITIVITY.items():
        assert tuple(held[t // 5]) == tuple(as_printed(share) for share in printed)
    np.testing.assert_allclose(shares(nominal, KalmanCovariance(), K), held, rtol=1e-8, atol=1e-10)


def test_paper_gains_at_another_rate():
    """Gains of Ts = 5 at Ts = 2.5, by their index and by their time (each used twice)."""
    params, K = paper(2.5), optimal(paper(5.0), SAMPLES).K
    best = optimal(params, SAMPLES).P[:, 0, 0]
    by_index = given_gains(params, K)[:, 0, 0] / best
    held = given_gains(params, jnp.repeat(K, 2, axis=0)[:SAMPLES])[:, 0, 0] / best
    for t in (50, 100, 200):
        k = round(t / 2.5)
        assert float(by_index[k]) == as_printed(ha.REPLAY_BY_INDEX[t])
        assert float(held[k]) == as_printed(ha.REPLAY_BY_TIME_HELD[t])


# ------------------------------------------------------------------------------------ gradients


def assert_gradients(total, *points):
    """Finite, and central differences in every parameter.

    A step h = 1e-5 leaves h^2 = 1e-10 of truncation and eps/h = 2e-11 of rounding, each times a
    factor of up to a hundred: a dozen steps of a nonlinear equation.
    """
    unflatten = ravel_pytree(points[0])[1]
    both = jax.jit(jax.value_and_grad(lambda flat: total(unflatten(flat))))
    for point in points:
        flat = np.asarray(ravel_pytree(point)[0])
        gradient = np.asarray(both(flat)[1])
        difference = central_difference(lambda flat: both(flat)[0], flat, 1e-5)
        assert np.isfinite(gradient).all()
        scale = np.abs(difference).max()
        assert scale > 0
        np.testing.assert_allclose(gradient, difference, rtol=0, atol=1e-7 * scale)


def late(P):
    """One number of a late covariance: an entry off the diagonal and all of it."""
    return P[-1, 0, 1] + (P[-1] ** 2).sum()


def test_gradient_of_a_late_covariance_and_gain():
    """In F, G, Q, H, R and P0, at P0 = 0 too."""

    def total(params):
        outputs = run(KalmanCovariance(), params, jnp.empty(N))[1]
        return late(outputs.P) + (outputs.K[-1] ** 2).sum()

    assert_gradients(total, *(example(1, start)[0] for start in ("zero", "rank one")))


def test_gradient_in_given_gains():
    """In the model and in a table of gains."""

    def total(params):
        outputs = run(TableCovariance(), params, jnp.arange(N) // 4)[1]
        return late(outputs.P)

    table = jnp.asarray(0.3 * np.random.default_rng(5).normal(size=(3, 3, 1)))
    assert_gradients(
        total, *(GainTable(example(1, start)[0], table) for start in ("zero", "rank one"))
    )


def test_gradient_in_the_densities_of_the_continuous_channel():
    """Through the exponential, at P0 = 0: one slope forwards."""
    A = vertical_channel(ha.K_GH)

    @jax.jit
    def slope(point):
        def total(point):
            q_a, q_b = jnp.exp(point)
            flow = Flow(riccati_flow(A, C, G @ G.T * q_a, q_b * jnp.eye(1), 1.0), jnp.zeros((3, 3)))
            return run(RiccatiCovariance(), flow, jnp.empty(41))[1][-1].sum()

        return jax.jvp(total, (point,), (jnp.array([1.0, 0.3]),))

    point, h = jnp.log(jnp.array([ha.Q_A, ha.Q_B])), 1e-4
    ahead, behind = (slope(point + step * jnp.array([1.0, 0.3]))[0] for step in (h, -h))
    assert float(slope(point)[1]) == pytest.approx(float((ahead - behind) / (2 * h)), rel=1e-7)


def test_gradient_in_the_noise_of_the_vertical_channel():
    model = paper(1.0, q_a=1.0)

    @jax.jit
    def both(point, start):
        def total(point):
            q_a, q_b = jnp.exp(point)
            move = model.transition._replace(Q=q_a * model.transition.Q)
            params = model._replace(transition=move, R=q_b[None], P0=start)
            return run(KalmanCovariance(), params, jnp.empty(51))[1].P[-1].sum()

        return jax.value_and_grad(total)(point)

    point = np.log([ha.Q_A, ha.Q_B])
    for start in (np.zeros((3, 3)), ha.KALMAN_P0):
        value, gradient = both(point, start)
        difference = central_difference(lambda p, start=start: both(p, start)[0], point, 1e-4)
        # h^2 = 1e-8 of truncation times the third derivative, of the order of the first
        np.testing.assert_allclose(gradient, difference, rtol=1e-7)
        if not start.any():  # all of P is then caused by both densities, and scales with them
            assert float(gradient.sum()) == pytest.approx(float(value), rel=1e-12)
