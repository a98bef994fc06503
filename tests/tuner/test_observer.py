"""Observers by matrix inequalities: against Riccati and Lyapunov solvers, and closed forms."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from scipy.linalg import (
    solve_continuous_are,
    solve_continuous_lyapunov,
    solve_discrete_are,
    solve_discrete_lyapunov,
)

from objectives import LinearSystem
from tuner.certificate.solution import Status
from tuner.observers.lmi import (
    FastestDecayTask,
    MinimumVarianceTask,
    fastest_observer,
    h2_observer,
)
from tuner.solvers.convex import Convex

both_times = pytest.mark.parametrize("discrete", [False, True], ids=["continuous", "discrete"])


@dataclass(frozen=True)
class Plant:
    A: np.ndarray
    C: np.ndarray
    W: np.ndarray
    V: np.ndarray
    M: np.ndarray

    def system(self, discrete=False, dt=1.0):
        return LinearSystem(self.A, self.C, self.W, self.V, dt=dt if discrete else None)

    def in_other_units(self, time, states, outputs):
        """The same plant where a second is ``time`` units, and so on."""
        x = np.asarray(states)
        return Plant(
            self.A / time * x[:, None] / x,
            self.C / x * outputs,
            self.W / time * x * x[:, None],
            self.V * outputs**2 * time,
            self.M / x,
        )


def plant(seed, discrete, n, m, k=1):
    rng = np.random.default_rng(seed)
    A, C, M = rng.normal(size=(n, n)), rng.normal(size=(m, n)), rng.normal(size=(k, n))
    if discrete:
        A *= 1.1 / np.abs(np.linalg.eigvals(A)).max()
    G, H = rng.normal(size=(n, n)), rng.normal(size=(m, m))
    spread = np.exp(2 * rng.normal(size=n))
    return Plant(
        A * spread[:, None] / spread,
        C / spread,
        G @ G.T * spread * spread[:, None],
        H @ H.T,
        M / spread,
    )


def kalman(p, discrete):
    """Gain and covariance of the Kalman filter in steady state, of the predictor if discrete."""
    if discrete:
        P = solve_discrete_are(p.A.T, p.C.T, p.W, p.V)
        return p.A @ P @ p.C.T @ np.linalg.inv(p.C @ P @ p.C.T + p.V), P
    P = solve_continuous_are(p.A.T, p.C.T, p.W, p.V)
    return P @ p.C.T @ np.linalg.inv(p.V), P


def covariance(p, L, discrete):
    F, noise = p.A - L @ p.C, p.W + L @ p.V @ L.T
    return solve_discrete_lyapunov(F, noise) if discrete else solve_continuous_lyapunov(F, -noise)


def chain(noise=0.0):
    """A bias, a velocity it drives, and a height that alone is measured; noise on the velocity."""
    k = 3.07e-6
    return Plant(
        np.array([[0.0, 0.0, 0.0], [1.0, 0.0, k], [0.0, 1.0, 0.0]]),
        np.array([[0.0, 0.0, 1.0]]),
        np.diag([0.0, 0.04, 0.0]),
        np.array([[noise]]),
        np.array([[1.0, 0.0, 0.0]]),
    )


BOUND = 4e-4
ETA = BOUND / 0.04


@cache
def designed(discrete, n, m, k):
    """A plant, its least variances, bounds of three times these, and the fastest within them."""
    p = plant(n, discrete, n, m, k)
    least = h2_observer(p.system(discrete), p.M)
    bound = 3 * least.variances
    return p, least, bound, fastest_observer(p.system(discrete), p.M, bound)


@pytest.fixture(scope="module")
def clean_chain():
    """The fastest observer of the chain measured without noise."""
    return fastest_observer(chain().system(), chain().M, BOUND)


# Least variance.


@both_times
@pytest.mark.parametrize(("n", "m", "k"), [(2, 1, 1), (3, 1, 2), (5, 2, 1)])
def test_least_variance_is_the_kalman_filter(discrete, n, m, k):
    p = plant(10 * n + k, discrete, n, m, k)
    L, P = kalman(p, discrete)
    expected = np.trace(p.M @ P @ p.M.T)
    found = h2_observer(p.system(discrete), p.M)
    assert found.status is Status.CONVERGED
    assert found.value == pytest.approx(expected, rel=1e-9)
    # Both sides of the certificate: no observer is better, and the bound is not idle.
    assert expected * (1 - 1e-7) < found.lower_bound <= expected * (1 + 1e-11)
    assert np.abs(found.gain - L).max() < 1e-6 * np.abs(L).max()
    # Of this very gain: found by scipy in the user's units.
    true = covariance(p, found.gain, discrete)
    assert found.variances == pytest.approx(np.diag(p.M @ true @ p.M.T), rel=1e-8)
    assert found.poles.size == n
    assert (np.abs(found.poles).max() < 1) if discrete else (found.poles.real.max() < 0)


@both_times
def test_the_inequalities_alone_give_the_same_value(discrete):
    p = plant(7, discrete, 3, 1)
    expected = np.trace(p.M @ kalman(p, discrete)[1] @ p.M.T)
    found = h2_observer(p.system(discrete), p.M)
    # In coordinates of their own, where only ratios mean something.
    unit = found.lower_bound / found.primal.lower_bound
    assert found.primal.variables["N"].trace() * unit == pytest.approx(expected, rel=1e-7)
    assert found.primal.value == pytest.approx(found.primal.lower_bound, rel=1e-7)
    # X is what the coordinates were chosen by.
    assert found.dual.variables["X"] == pytest.approx(np.eye(3), abs=1e-5)


def test_every_other_gain_is_worse():
    p = plant(21, False, 3, 1)
    found = h2_observer(p.system(), p.M)
    rng = np.random.default_rng(0)
    for size in (1e-4, 1e-2):
        other = found.gain * (1 + size * rng.normal(size=found.gain.shape))
        assert (p.M @ covariance(p, other, False) @ p.M.T).item() > found.lower_bound


def test_a_discrete_observer_needs_no_measurement_noise():
    p = plant(3, True, 3, 1)
    found = h2_observer(LinearSystem(p.A, p.C, p.W, np.zeros((1, 1)), dt=1.0), p.M)
    P = solve_discrete_are(p.A.T, p.C.T, p.W, np.zeros((1, 1)))
    assert found.status is Status.CONVERGED
    assert found.value == pytest.approx((p.M @ P @ p.M.T).item(), rel=1e-8)


def test_a_limit_that_no_gain_reaches_is_said():
    # The first state is measured without noise, so its derivative measures the second with noise
    # of density 1: P^2 + 2 P - 1 = 0.
    found = h2_observer(
        LinearSystem([[0, 1], [0, -1.0]], [[1.0, 0]], np.eye(2), [[0.0]]), [[0, 1.0]]
    )
    limit = np.sqrt(2) - 1
    assert found.status is Status.UNATTAINED
    assert "no observer reaches the lower bound" in found.message
    assert limit * (1 - 1e-3) < found.lower_bound <= limit
    assert limit < found.value < limit * 1.01
    assert found.gain[0, 0] > 20


@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_an_undriven_constant_is_a_limit_as_well(noise):
    # It is known better and better, and a constant gain never stops correcting it.
    found = h2_observer(chain(noise).system(), chain(noise).M)
    assert found.status is Status.UNATTAINED
    assert 0 <= found.lower_bound < 1e-6
    assert found.value > 0
    assert found.poles.real.max() < 0


@both_times
def test_without_any_noise_of_the_states_no_gain_is_best(discrete):
    A = 0.5 * np.eye(2) if discrete else -np.eye(2)
    system = LinearSystem(A, [[1.0, 1.0]], np.zeros((2, 2)), [[1.0]], dt=1.0 if discrete else None)
    found = h2_observer(system, [[1.0, 2.0]])
    assert found.status is Status.CONVERGED
    assert found.value == found.lower_bound == 0
    assert not found.gain.any()


# Fastest within a variance.


@pytest.mark.parametrize("noise", [0.3, 1.0])
def test_one_state_has_a_closed_form(noise):
    # The variance (1 + v l^2) / (2 + 2 l) is at most b up to the larger root.
    b = 1.5
    fast = fastest_observer(LinearSystem([[-1.0]], [[1.0]], [[1.0]], [[noise]]), [[1.0]], b)
    gain = max(np.roots([noise, -2 * b, 1 - 2 * b]))
    assert fast.status is Status.CONVERGED
    assert fast.alpha == pytest.approx(1 + gain, rel=1e-6)
    assert fast.alpha <= 1 + gain <= fast.limit * (1 + 1e-9)
    assert fast.gain.item() == pytest.approx(gain, rel=1e-6)
    slope = (2 * b + 2 * b * gain) / (2 * noise * gain - 2 * b) / (1 + gain)
    assert fast.multipliers == pytest.approx([slope], rel=1e-4)


def test_one_discrete_state_has_a_closed_form():
    # Pole a - l, variance (w + v l^2) / (1 - (a - l)^2).
    a, b, dt = 0.9, 0.5, 0.1
    fast = fastest_observer(LinearSystem([[a]], [[1.0]], [[0.1]], [[1.0]], dt=dt), [[1.0]], b)
    gain = max(np.roots([1 + b, -2 * a * b, 0.1 + b * a**2 - b]))
    pole = a - gain
    assert fast.alpha == pytest.approx(-np.log(pole) / dt, rel=1e-6)
    assert fast.poles == pytest.approx([pole], rel=1e-6)
    slope = b * (1 - pole**2) / (2 * gain - 2 * b * pole) / pole / -np.log(pole)
    assert fast.multipliers == pytest.approx([slope], rel=1e-4)
    assert fast.rate == pytest.approx(fast.alpha, rel=1e-6)


def test_a_loose_bound_lets_a_discrete_observer_forget_at_once():
    # With l = a the variance is w + v a^2 = 0.91.
    fast = fastest_observer(
        LinearSystem([[0.9]], [[1.0]], [[0.1]], [[1.0]], dt=1.0), [[1.0]], 1.0, tolerance=1e-3
    )
    assert fast.status is Status.UNBOUNDED
    assert fast.alpha == np.inf
    assert np.isnan(fast.needed)
    assert fast.rate > 9
    assert fast.variances[0] < 1


@both_times
@pytest.mark.parametrize(("n", "m", "k"), [(2, 1, 2), (4, 1, 2)])
def test_the_fastest_observer_keeps_what_it_promises(discrete, n, m, k):
    p, _, bound, fast = designed(discrete, n, m, k)
    assert fast.status is Status.CONVERGED
    assert 0 < fast.limit / fast.alpha - 1 < 1e-6
    assert fast.needed > 1
    poles = np.linalg.eigvals(p.A - fast.gain @ p.C)
    rate = -np.log(np.abs(poles).max()) if discrete else -poles.real.max()
    assert fast.rate == pytest.approx(rate, rel=1e-6)
    assert rate > fast.alpha * (1 - 1e-6)
    true = np.diag(p.M @ covariance(p, fast.gain, discrete) @ p.M.T)
    assert fast.variances == pytest.approx(true, rel=1e-6)
    assert np.all(true < bound * (1 + 1e-6))
    assert fast.alpha > 0


def test_multipliers_are_the_slopes_of_the_rate():
    p, _, bound, fast = designed(False, 2, 1, 2)
    assert np.all(fast.multipliers > -1e-6)
    assert fast.multipliers.max() > 0.01
    i = int(np.argmax(fast.multipliers))
    step = 2e-3 * np.eye(2)[i]
    ends = [fastest_observer(p.system(), p.M, bound * np.exp(s)).alpha for s in (-step, step)]
    assert np.log(ends[1] / ends[0]) / 4e-3 == pytest.approx(fast.multipliers[i], rel=1e-3)


@pytest.mark.parametrize(("time", "size"), [(1e3, 1e-3), (1e-3, 1e-3)])
def test_the_rate_does_not_depend_on_units(time, size):
    p, least, bound, here = designed(False, 4, 1, 2)
    states = [size, 1.0, 1 / size, 2.0]
    other = p.in_other_units(time, states, size)
    there = fastest_observer(other.system(), other.M, bound)
    assert there.alpha * time == pytest.approx(here.alpha, rel=1e-7)
    assert there.rate * time == pytest.approx(here.rate, rel=1e-5)
    gain = there.gain * time * size / np.array(states)[:, None]
    assert gain == pytest.approx(here.gain, rel=1e-3)
    assert h2_observer(other.system(), other.M).value == pytest.approx(least.value, rel=1e-9)


def test_bounds_that_are_out_of_reach_are_refused_with_the_least():
    p = plant(5, False, 3, 1)
    least = h2_observer(p.system(), p.M).value
    with pytest.raises(ValueError, match="no observer has") as refused:
        fastest_observer(p.system(), p.M, 0.5 * least)
    named = float(str(refused.value).split(",")[1].split(";")[0])
    assert named == pytest.approx(least, rel=1e-5)
    assert str(refused.value).startswith(f"no observer has the variances within {0.5 * least:.6g}")
    assert fastest_observer(p.system(), p.M, 1.05 * least, tolerance=0.5).alpha > 0


# Without measurement noise.


def test_the_vertical_channel_pays_for_one_lyapunov_matrix(clean_chain):
    # As gains grow, the bias alone is left, measured by a noise of density q: e' = -l e + l w has
    # the variance l q / 2. The best triple pole is at 16 eta / 3.
    p, fast = chain(), clean_chain
    assert fast.status is Status.UNATTAINED
    assert fast.alpha == pytest.approx(2 * ETA, rel=1e-6)
    assert fast.alpha < 16 * ETA / 3
    assert fast.multipliers == pytest.approx([1.0], rel=1e-4)
    # What is handed out keeps the bound and 99 % of the rate with finite gains.
    assert fast.rate >= 0.99 * fast.alpha * (1 - 1e-6)
    assert (p.M @ covariance(p, fast.gain, False) @ p.M.T).item() < BOUND
    poles = np.linalg.eigvals(p.A - fast.gain @ p.C)
    assert -poles.real.max() == pytest.approx(fast.rate, rel=1e-6)


def test_the_published_gains_are_faster(clean_chain):
    p = chain()
    L = np.array([[4096 * ETA**3 / 27], [256 * ETA**2 / 3 + p.A[1, 2]], [16 * ETA]])
    assert covariance(p, L, False)[0, 0] == pytest.approx(BOUND, rel=1e-9)
    poles = np.linalg.eigvals(p.A - L @ p.C)
    assert poles == pytest.approx(-16 * ETA / 3, rel=1e-4)
    assert -poles.real.max() > 2.6 * clean_chain.alpha


def test_little_noise_comes_close_to_none():
    alphas = [
        fastest_observer(chain(v).system(), chain(v).M, BOUND, tolerance=1e-2).alpha
        for v in (1.0, 1e-3)
    ]
    assert alphas[0] < alphas[1]
    assert 0.85 * 2 * ETA < alphas[1] < 2 * ETA


def test_a_reduced_observer_has_a_closed_form():
    # As for the least variance, with e' = -(1 + l) e + w2 - l w1.
    b = 0.6
    A, C, M = [[0, 1], [0, -1.0]], [[1.0, 0]], [[0, 1.0]]
    fast = fastest_observer(LinearSystem(A, C, np.eye(2), [[0.0]]), M, b)
    gain = max(np.roots([1, -2 * b, 1 - 2 * b]))
    assert fast.status is Status.UNATTAINED
    assert fast.alpha == pytest.approx(1 + gain, rel=1e-6)
    assert 0.99 * fast.alpha * (1 - 1e-6) <= fast.rate
    assert fast.variances[0] <= b


def test_one_clean_measurement_of_two():
    # A second, noisy measurement of the same state adds its information: densities 1 and 1/2.
    A, M, b = [[0, 1], [0, -1.0]], [[0, 1.0]], 0.6
    fast = fastest_observer(LinearSystem(A, np.eye(2), np.eye(2), np.diag([0, 0.5])), M, b)
    density = 1 / (1 / 1.0 + 1 / 0.5)
    gain = max(np.roots([density, -2 * b, 1 - 2 * b]))
    assert fast.status is Status.UNATTAINED
    assert fast.alpha == pytest.approx(1 + gain, rel=1e-6)
    assert fast.variances[0] <= b


def test_where_every_rate_is_admissible():
    fast = fastest_observer(
        LinearSystem([[0, 1], [0, 0.0]], [[1.0, 0]], np.diag([0, 1.0]), [[0.0]]), [[0, 1.0]], 0.6
    )
    assert fast.status is Status.UNBOUNDED
    assert fast.alpha == fast.limit == np.inf
    assert fast.rate > 0
    assert fast.variances[0] <= 0.6


@pytest.mark.parametrize("drive", [0.0, 1.0])
def test_a_mode_that_does_not_show_bounds_the_rate(drive):
    system = LinearSystem(np.diag([-1.0, -2.0]), [[1.0, 0.0]], drive * np.eye(2), [[1.0]])
    fast = fastest_observer(system, [[1.0, 2.0]], 5.0)
    assert fast.alpha == pytest.approx(2.0, rel=1e-5)
    assert 2.0 <= fast.limit < 2.00001
    # inf beyond the pole; within 1e-7 of it, where rounding might still move it, the dual proves.
    assert fast.needed > 1e3
    assert fast.rate == pytest.approx(2.0, rel=1e-5)


def test_a_rate_that_only_the_solver_believes_is_not_admitted():
    # Two equal modes behind one measurement: their difference keeps its pole at -1, and without
    # noise that drives it the solver takes an inverse covariance near zero for none.
    system = LinearSystem(-np.eye(2), [[1.0, 0.5]], np.zeros((2, 2)), [[1.0]])
    fast = fastest_observer(system, [[1.0, 2.0]], 1.0)
    assert fast.alpha == pytest.approx(1.0, rel=1e-5)
    assert fast.rate == pytest.approx(1.0, rel=1e-5)


def test_a_discrete_constant_that_nothing_drives_is_a_limit():
    system = LinearSystem([[1, 0.1], [0, 1]], [[1.0, 0]], np.diag([1.0, 0]), [[0.0]], dt=1.0)
    found = h2_observer(system, [[1.0, 2.0]])
    assert found.status is Status.UNATTAINED
    assert found.lower_bound == pytest.approx(1.0, abs=1e-5)
    assert found.value > 1.001


def test_the_least_variance_is_a_task_of_a_study():
    p = plant(2, False, 2, 1, 2)
    task = MinimumVarianceTask(
        "least", p.system(), p.M, ("height", "speed"), {"height": "m^2"},
        lambda answer: {"deviation": answer.value**0.5},
    )  # fmt: skip
    solution = Convex("sdp")(task)
    L, P = kalman(p, False)
    variances = np.diag(p.M @ P @ p.M.T)
    found = solution.parameters
    assert solution.status is Status.CONVERGED
    assert solution.value == pytest.approx(variances.sum(), rel=1e-9)
    assert 0 <= solution.value - solution.certificate.lower_bound < 1e-6 * solution.value
    assert found["gain"].value == pytest.approx(L, rel=1e-6)
    poles = np.sort(np.linalg.eigvals(p.A - L @ p.C).real)[::-1]
    assert found["poles"].value == pytest.approx(poles, rel=1e-6)
    assert found["height"].value == pytest.approx(variances[0], rel=1e-8)
    assert found["speed"].value == pytest.approx(variances[1], rel=1e-8)
    assert [found[name].unit for name in ("height", "speed")] == ["m^2", ""]
    assert solution.derived == {"deviation": solution.value**0.5}
    with pytest.raises(ValueError, match="^least is no linear program"):
        Convex("lp")(task)


def test_the_fastest_observer_is_a_task_of_a_study(clean_chain):
    one = np.eye(1)
    task = FastestDecayTask(
        "fast", LinearSystem(-one, one, one, one), one, [1.0], ("sigma_a",), units={"gain": "1/s"}
    )
    solution = Convex("sdp")(task)
    fast = 2 + np.sqrt(2)
    assert solution.status is Status.CONVERGED
    assert solution.value == pytest.approx(1 / fast, rel=1e-6)
    assert solution.certificate.lower_bound <= 1 / fast <= solution.value
    assert solution.certificate.multipliers == {"sigma_a": pytest.approx(1 / np.sqrt(2), rel=1e-4)}
    assert solution.parameters["gain"].unit == "1/s"
    assert solution.parameters["gain"].value.item() == pytest.approx(1 + np.sqrt(2), rel=1e-6)
    with pytest.raises(ValueError, match="^fast is no linear program"):
        Convex("lp")(task)
    # Where the rate is a limit, the value is what the gain at hand keeps.
    limit = FastestDecayTask("bias", chain().system(), chain().M, BOUND, ("bias",))
    answer = limit.answer()
    assert answer.value == pytest.approx(1 / clean_chain.rate, rel=1e-9)
    assert answer.value >= 1 / (2 * ETA) >= answer.lower_bound


@pytest.mark.parametrize("design", [h2_observer, fastest_observer])
def test_what_cannot_be_designed_for_is_refused(design):
    for A, errors, message in [
        (-np.eye(2), [[1.0]], r"^the errors M have the shape \(1, 1\); 2 states need \(k, 2\)$"),
        (-np.eye(2), [[np.nan, 1.0]], "^the errors M hold nan; give finite numbers$"),
        (np.diag([-1.0, 2.0]), [[0, 1.0]], "^no measurement shows the mode 2 1/s along x2, which"),
        (np.diag([-1.0, 0.0]), [[0, 1.0]], "^no measurement shows the constant mode along x2"),
    ]:
        system = LinearSystem(A, [[1.0, 0]], np.eye(2), [[1.0]])
        with pytest.raises(ValueError, match=message):
            design(system, errors, *([1.0] if design is fastest_observer else []))


@both_times
def test_noise_that_states_and_measurements_share(discrete):
    """Against scipy's Riccati equation with the cross covariance."""
    draw = np.random.default_rng(11)
    G = draw.normal(size=(4, 4))
    joint, A, C = G @ G.T, 0.4 * draw.normal(size=(3, 3)), draw.normal(size=(1, 3))
    W, V, S = joint[:3, :3], joint[3:, 3:], joint[:3, 3:]
    found = h2_observer(LinearSystem(A, C, W, V, S=S, dt=1.0 if discrete else None), np.eye(3))
    P = (solve_discrete_are if discrete else solve_continuous_are)(A.T, C.T, W, V, s=S)
    assert found.status is Status.CONVERGED
    assert found.value == pytest.approx(np.trace(P), rel=1e-8)
    assert found.lower_bound <= np.trace(P) * (1 + 1e-11)


def test_bounds_have_to_be_bounds():
    p = plant(1, False, 2, 1)
    for given, message in [
        ([1.0, 2.0], r"^bound has shape \(2,\), but needs \(1,\) or a number$"),
        (0.0, "^bound is 0.0; give positive, finite variances$"),
    ]:
        with pytest.raises(ValueError, match=message):
            fastest_observer(p.system(), p.M, given)
