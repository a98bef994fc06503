"""What differences of measurements say of noise: against spectra, Riccati and simulation."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are

from filters import (
    ConstantAcceleration,
    ConstantVelocity,
    Lanes,
    LevelSample,
    LinearKalman,
    LinearModel,
    LocalLevel,
    PositionSample,
    Sample,
    Timed,
    TimedSample,
    Transition,
    Vertical,
    VerticalSample,
)
from filters.declared import assembled
from objectives import ChannelRmse, Data, InnovationLikelihood
from tests.strategies import seeds
from tests.tuner.helpers import OwnLevel
from tuner import Covariance, Fixed, Positive, Problem, Space
from tuner.identifiability.determined import determined, with_known_start
from tuner.identifiability.linear_form import NoiseModel
from tuner.identifiability.rank import rank_of, sentences
from tuner.identifiability.windows import differences

LIKELY = InnovationLikelihood()


def units(n):
    """A basis of the symmetric matrices: diagonal first."""
    places = [(i, i) for i in range(n)] + [(i, j) for i in range(n) for j in range(i)]
    found = []
    for i, j in places:
        matrix = np.zeros((n, n))
        matrix[i, j] = matrix[j, i] = 1.0
        found.append(matrix)
    return found


def spectra(F, H, Q, R, count=40):
    """The spectral density of the measurements for each unknown at 1, one column each: the Fisher
    information of a stationary record has the rank of these (Whittle)."""
    columns = []
    turns = np.exp(1j * np.pi * (np.arange(count) + 0.5) / count)
    shape = [np.linalg.solve(t * np.eye(len(F)) - F, np.eye(len(F))) for t in turns]
    for q, r in zip(Q, R, strict=True):
        each = np.stack([H @ T @ q @ T.conj().T @ H.T + r for T in shape])
        columns.append(np.concatenate([each.real.ravel(), each.imag.ravel()]))
    return np.array(columns).T


def numeric_rank(columns):
    sizes = np.linalg.norm(columns, axis=0)
    values = np.linalg.svd(columns / np.where(sizes > 1e-12, sizes, np.inf), compute_uv=False)
    # A gap, not a threshold: nothing between 1e-5 and 1e-10 may be decided by rounding.
    assert not ((values > 1e-10) & (values < 1e-7)).any()
    return int((values > 1e-8).sum())


@st.composite
def unknown_noise(draw):
    """A stable model, singular or unobservable at times, and what is free of its noise."""
    rng, n, m = draw(seeds()), draw(st.integers(1, 3)), draw(st.integers(1, 2))
    F = rng.normal(size=(n, n))
    F *= 0.8 / np.abs(np.linalg.eigvals(F)).max()
    H = rng.normal(size=(m, n))
    kind = draw(st.sampled_from(["any", "singular", "blind", "slow and fast"]))
    if kind == "singular":
        F[:, 0] = 0.0
    elif kind == "blind" and n > 1:  # the last state is never seen
        F[:-1, -1], H[:, -1] = 0.0, 0.0
    elif kind == "slow and fast":
        F = np.diag([0.95, 0.5, -0.3][:n])
    chosen = draw(st.lists(st.sampled_from(range(n * (n + 1) // 2)), min_size=1, unique=True))
    measured = draw(st.lists(st.sampled_from(range(m)), unique=True))
    Q = [units(n)[i] for i in chosen] + [np.zeros((n, n))] * len(measured)
    R = [np.zeros((m, m))] * len(chosen) + [units(m)[i] for i in measured]
    return F, H, np.array(Q), np.array(R)


def recorded(F, H, Q, R, N=60):
    """A record of such a model; its numbers do not matter for the rank."""
    n, m = len(F), len(H)
    Q, R = (np.concatenate([np.zeros_like(a[:1]), a]) for a in (Q, R))
    z = np.random.default_rng(0).normal(size=(N, m))
    still = np.zeros((N, n))
    return NoiseModel(F[None], Q[None], np.zeros(N, int), still, H, R, np.ones((N, m)), z)


@settings(deadline=None)
@given(unknown_noise())
def test_the_rank_is_that_of_the_fisher_information(model):
    F, H, Q, R = model
    columns = spectra(F, H, Q, R)
    found = rank_of(differences((recorded(F, H, Q, R),)))
    assert found.rank == numeric_rank(columns)
    # And what is said to leave no trace leaves none.
    sizes = np.abs(columns).max(axis=0)
    for row in found.undetermined:
        assert np.abs(columns @ row).max() <= 1e-6 * np.abs(sizes * row).max(initial=1e-300) + 1e-12


def test_what_is_not_determined_changes_no_innovation():
    """Along it the steady innovations and their gains stay, by scipy's Riccati equation."""
    F, H = np.array([[0.9, 0.2], [0.0, 0.0]]), np.array([[1.0, 1.0]])
    Q, R = np.array([*units(2)[:2], np.zeros((2, 2))]), np.array([[[0.0]], [[0.0]], [[1.0]]])
    found = rank_of(differences((recorded(F, H, Q, R),)))
    assert (found.rank, found.undetermined.shape) == (2, (1, 3))

    def steady(theta):
        q, r = np.einsum("p,pij->ij", theta, Q), np.einsum("p,pij->ij", theta, R)
        P = solve_discrete_are(F.T, H.T, q, r)
        S = H @ P @ H.T + r
        return np.concatenate([S.ravel(), (F @ P @ H.T / S).ravel()])

    theta = np.array([1.0, 2.0, 3.0])
    moved = theta + 0.2 * found.undetermined[0] / np.abs(found.undetermined).max()
    np.testing.assert_allclose(steady(moved), steady(theta), rtol=1e-9)
    # And another way they do not stay.
    assert np.abs(steady(np.array([1.0, 2.0, 3.2])) - steady(theta)).max() > 1e-3


def kalman(build, space, z, **data):
    zeros = np.zeros(len(z))
    return Problem("own", space, LinearKalman(), build, LIKELY, Data(Sample(z, **data), zeros))


def two_whites(v):
    """A white state, seen through white noise, beside a random walk that is seen by itself."""
    F, Q = jnp.diag(jnp.array([0.0, 1.0])), jnp.diag(jnp.stack([v["Q11"], v["Q22"]]))
    R = jnp.stack([v["R"], v["R2"]])
    return LinearModel(Transition(F, jnp.eye(2), Q), jnp.eye(2), R, jnp.eye(2), jnp.zeros(2))


def positive(*names, init=1.0):
    return Space.of(**{name: Positive(init, 1e-9, 1e9) for name in names})


def test_what_is_not_determined_is_said():
    draw = np.random.default_rng(3)
    z = np.stack([draw.normal(size=500), np.cumsum(draw.normal(size=500))], axis=1)
    problem = kalman(two_whites, positive("Q11", "Q22", "R", "R2"), z)
    found = determined(problem)
    assert found.rank == 3
    assert found.sentences == (
        "Q11 and R cannot be told apart by what is measured: only Q11 + R is determined; fix one, "
        "--fix R=VALUE",
    )
    assert np.isinf([found.deviations["Q11"], found.deviations["R"]]).all()
    assert found.values["Q11"] + found.values["R"] == pytest.approx(1.0, rel=0.2)
    fixed = kalman(
        two_whites, Space.of(R=Fixed(0.5), **dict(positive("Q11", "Q22", "R2").parameters)), z
    )
    assert determined(fixed).sentences == ()
    assert determined(fixed).values["Q11"] == pytest.approx(0.5, rel=0.4)


def test_sentences():
    names = ("Q11", "Q22", "R")
    assert sentences(rank_of_null([0, 0, 0]), names, names) == ()
    (one,) = sentences(rank_of_null([[0.0, 1.0, 0.0]]), names, names)
    assert one.startswith("Q22 leaves no trace in what is measured: it is not determined; fix it,")
    (two,) = sentences(rank_of_null([[0.5, -1.0, 0.0]]), names, ("", "", ""))
    assert "only Q11 + 0.5 Q22 is determined; fix one" in two
    assert "--fix" not in two
    (three,) = sentences(rank_of_null([[1.0, -1.0, 0.0], [0.0, 1.0, 2.0]]), names, names)
    assert three.startswith("Q11, Q22 and R cannot be told apart by what is measured: only ")
    assert three.endswith(" is determined; fix 2, --fix R=VALUE")


def rank_of_null(rows):
    from tuner.identifiability.rank import Rank

    null = np.array(rows, float).reshape(-1, 3) if np.any(rows) else np.zeros((0, 3))
    return Rank(3 - len(null), null)


# Estimates, against simulations.


def facts_of(cls, **init):
    return Space.of_filter(cls, **{k: Positive(v, 1e-12, 1e12) for k, v in init.items()})


def within(found, truth, sigmas=4.0):
    for name, value in truth.items():
        assert abs(found.values[name] - value) < sigmas * found.deviations[name], name
        assert found.deviations[name] < value, name  # and it says something


def level(q, R, dt, seed, x0=1000.0):
    draw = np.random.default_rng(seed)
    walk = x0 + np.cumsum(np.sqrt(q * dt) * draw.normal(size=len(dt)))
    return walk + np.sqrt(R) * draw.normal(size=len(dt))


def test_a_level_with_gaps_and_uneven_steps():
    dt = 0.1 + 2.0 * np.random.default_rng(1).random(3000)
    z = level(0.3, 2.0, dt, 2)
    z[np.random.default_rng(3).random(3000) < 0.3] = np.nan
    z[1000:1400] = np.nan
    data = Data(TimedSample(dt, LevelSample(z)), np.zeros(3000))
    problem = Problem("level", facts_of(LocalLevel), Timed(LocalLevel(1.0)), None, LIKELY, data)
    within(determined(problem), {"q": 0.3, "R": 2.0})


def test_several_recordings_and_what_does_not_count():
    lanes = np.stack(
        [level(0.3, 2.0, np.ones(400), seed, 50.0 * seed) for seed in range(5)], axis=1
    )
    lanes[250:, 3] = np.nan
    truth = np.zeros((400, 5, 1))
    lanes[:, 4] = 1e6 * np.random.default_rng(0).normal(size=400)
    truth[:, 4] = np.nan
    data = Data(LevelSample(lanes), truth)
    problem = Problem("level", facts_of(LocalLevel), Lanes(LocalLevel(1.0), 5), None, LIKELY, data)
    within(determined(problem), {"q": 0.3, "R": 2.0})


@pytest.mark.parametrize(("cls", "order"), [(ConstantVelocity, 2), (ConstantAcceleration, 3)])
def test_positions_with_deviations_of_their_own(cls, order):
    draw, dt, q, R = np.random.default_rng(order), 0.5, 0.5, 4.0
    filter = cls(dt, "xy")
    space = facts_of(cls, q=1.0, R=1.0)
    form = filter.linear(assembled(cls, {"q": q, "R": R}))
    F, Q = np.asarray(form.transition.F), np.asarray(form.transition.Q)
    root, x, sigma = np.linalg.cholesky(Q), np.zeros(len(F)), 0.5 + draw.random(1500)
    z = []
    for s in sigma:
        x = F @ x + root @ draw.normal(size=len(F))
        z.append(np.asarray(form.H) @ x + s * np.sqrt(R) * draw.normal(size=2))
    z = np.array(z)
    z[draw.random(z.shape) < 0.1] = np.nan
    data = Data(PositionSample(z[:, 0], z[:, 1], None, sigma), np.zeros(1500))
    within(determined(Problem("track", space, filter, None, LIKELY, data)), {"q": q, "R": R})


def climbing(samples, seed, every=5, dt=0.02):
    """An accelerometer with an offset that wanders, and a barometer at a fifth of its rate."""
    draw, chain = np.random.default_rng(seed), np.zeros(3)
    acc, baro = [], []
    F = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1.0]])
    Q = 0.5 * np.array([[dt**3 / 3, dt**2 / 2, 0], [dt**2 / 2, dt, 0], [0, 0, 0.0]])
    Q[2, 2] = 1e-3 * dt
    root = np.linalg.cholesky(Q + 1e-30 * np.eye(3))
    for k in range(samples):
        wave = 2.0 * np.sin(0.01 * k)
        baro.append(300 + chain[0] + 0.3 * draw.normal() if k % every == 0 else np.nan)
        acc.append(wave)
        chain = F @ chain + np.array([dt**2 / 2, dt, 0]) * wave + root @ draw.normal(size=3)
    return np.array(acc), np.array(baro)


def test_a_known_input_between_measurements():
    acc, baro = climbing(6000, 1)
    space = facts_of(Vertical, q_acc=1.0, q_bias=1e-3, R_baro=1.0)
    data = Data(VerticalSample(acc, baro), np.zeros(6000))
    problem = Problem("vertical", space, Vertical(0.02), None, LIKELY, data)
    found = determined(problem)
    within(found, {"R_baro": 0.09, "q_acc": 0.5})
    # Without the input the same would be noise.
    blind = Data(VerticalSample(0 * acc, baro), np.zeros(6000))
    other = determined(Problem("vertical", space, Vertical(0.02), None, LIKELY, blind))
    assert other.values["q_bias"] > 10 * max(found.values["q_bias"], found.deviations["q_bias"])


def deviations(v):
    F = jnp.array([[1.0, 0.1], [0.0, 0.95]])
    R = jnp.stack([v["sigma"] ** 2])
    return LinearModel(
        Transition(F, jnp.eye(2), v["Q"]), jnp.eye(1, 2), R, jnp.eye(2), jnp.zeros(2)
    )


def test_a_covariance_and_a_deviation():
    draw, Q = np.random.default_rng(8), np.array([[0.5, 0.2], [0.2, 0.8]])
    x, z, F, root = np.zeros(2), [], np.array([[1.0, 0.1], [0.0, 0.95]]), np.linalg.cholesky(Q)
    for _ in range(4000):
        x = F @ x + root @ draw.normal(size=2)
        z.append([x[0] + 1.5 * draw.normal()])
    space = Space.of(
        Q=Covariance(((1.0, 0.0), (0.0, 1.0)), low=1e-6, high=1e6), sigma=Positive(1.0, 1e-6, 1e6)
    )
    found = determined(kalman(deviations, space, np.array(z)))
    # Of a covariance behind one measurement one number is open: a known limit of such models.
    assert found.entries == ("Q11", "Q12", "Q22", "sigma^2")
    assert found.rank == numeric_rank(
        spectra(
            F,
            np.eye(1, 2),
            [*(units(2)[i] for i in (0, 2, 1)), np.zeros((2, 2))],
            [*[np.zeros((1, 1))] * 3, np.eye(1)],
        )
    )
    assert abs(found.values["sigma^2"] - 2.25) < 4 * found.deviations["sigma^2"]
    P = np.array(
        [[found.values["Q11"], found.values["Q12"]], [found.values["Q12"], found.values["Q22"]]]
    )
    assert np.linalg.eigvalsh(P)[0] >= -1e-12 * np.trace(P)


def test_units_of_measurements_states_and_time_do_not_matter():
    draw, N = np.random.default_rng(4), 400
    z = np.cumsum(np.cumsum(draw.normal(size=N))) + 3.0 * draw.normal(size=N)
    F, Q = np.array([[1.0, 1.0], [0.0, 1.0]]), np.diag([0.0, 1.0])

    def found(size, clock, state):
        S = np.diag([size, state / clock])  # the second state in a unit of its own

        def build(v):
            noise = S @ Q @ S.T * v["q"]
            model = Transition(jnp.asarray(S @ F @ np.linalg.inv(S)), jnp.eye(2), noise)
            H = jnp.asarray(size * np.eye(1, 2) @ np.linalg.inv(S))
            return LinearModel(model, H, v["R"][None], jnp.eye(2), jnp.zeros(2))

        space = Space.of(q=Positive(1.0, 1e-9, 1e9), R=Positive(size**2, 1e-30, 1e30))
        return determined(kalman(build, space, size * z[:, None]))

    plain = found(1.0, 1.0, 1.0)
    others = ((1e-9, 1.0, 1.0), (1e9, 1e-9, 1.0), (1.0, 1.0, 1e9), (1.0, 1e9, 1.0))
    for size, clock, state in others:
        other = found(size, clock, state)
        assert other.values["q"] == pytest.approx(plain.values["q"], rel=1e-7)
        assert other.values["R"] / size**2 == pytest.approx(plain.values["R"], rel=1e-7)
        assert other.rank == 2


def test_it_is_a_start_of_the_search():
    z = level(0.01, 1.0, np.ones(600), 7)
    data = Data(LevelSample(z), np.zeros(600))
    space = facts_of(LocalLevel, q=1e9, R=1e-9)
    problem = Problem("level", space, LocalLevel(1.0), None, LIKELY, data)
    started = with_known_start(problem)
    first, known = started.starts(2, seed=0)
    assert first == pytest.approx(problem.space.start())
    values = problem.parameters(known)
    assert values["R"] == pytest.approx(1.0, rel=0.3)
    assert 1e-3 < values["q"] < 0.1


def test_where_nothing_of_noise_is_left_it_begins_at_the_deviation():
    """A straight line: no noise moves it, and 0 is no start on a logarithmic axis."""
    z = 3.0 + np.random.default_rng(1).normal(size=300)
    data = Data(LevelSample(z), np.zeros(300))
    found = determined(Problem("still", facts_of(LocalLevel), LocalLevel(1.0), None, LIKELY, data))
    assert found.values["q"] < 1e-3
    assert 1e-6 < np.exp(found.start[0]) < 0.1


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"filter": OwnLevel(0.1)}, "has no known linear model"),
        ({"objective": ChannelRmse("level")}, "not judged by the likelihood"),
        ({"data": Data(LevelSample(np.ones(1)), np.zeros(1))}, "too few to determine the noise"),
        (
            {"data": Data(LevelSample(np.r_[1.0, np.full(8, np.nan)]), np.zeros(9))},
            "too few to determine",
        ),
    ],
)
def test_refusals(change, words):
    data = Data(LevelSample(np.arange(9.0)), np.zeros(9))
    problem = Problem("level", Space.of_filter(LocalLevel), LocalLevel(1.0), None, LIKELY, data)
    with pytest.raises(ValueError, match=words):
        determined(replace(problem, **change))


def test_what_is_no_noise_is_refused_and_a_product_of_two():
    def turning(v):
        model = Transition(v["a"] * jnp.eye(1), jnp.eye(1), v["q"] * jnp.eye(1))
        return LinearModel(model, jnp.eye(1), v["R"][None], jnp.eye(1), jnp.zeros(1))

    def product(v):
        model = Transition(jnp.eye(1), jnp.eye(1), v["q"] * v["R"] * jnp.eye(1))
        return LinearModel(model, jnp.eye(1), v["R"][None], jnp.eye(1), jnp.zeros(1))

    z = np.arange(20.0)[:, None]
    with pytest.raises(ValueError, match="a changes how the state moves or is measured"):
        determined(kalman(turning, positive("a", "q", "R", init=0.5), z))
    with pytest.raises(ValueError, match="linear neither in q nor in its square"):
        determined(kalman(product, positive("q", "R", init=0.5), z))


def test_outliers_long_gaps_and_exact_numbers_do_not_decide():
    draw, N = np.random.default_rng(1), 400
    t = np.cumsum(0.5 + draw.random(N))
    t[200:] += 1e6
    z = level(0.3, 2.0, np.diff(t, prepend=t[0]) % 1e5, 2)
    z[70] = 1e10
    data = Data(TimedSample(np.diff(t, prepend=t[0]), LevelSample(z)), np.zeros(N))
    problem = Problem("level", facts_of(LocalLevel), Timed(LocalLevel(1.0)), None, LIKELY, data)
    found = determined(problem)
    assert found.rank == 2
    assert found.values["q"] + found.values["R"] < 10
    line = PositionSample(1e3 + 0.1 * np.arange(200.0))
    still = Data(line, np.zeros(200))
    space = facts_of(ConstantVelocity)
    exact = Problem("line", space, ConstantVelocity(0.1), None, LIKELY, still)
    assert max(determined(exact).values.values()) < 1e-20  # rounding squared


def test_records_that_are_hardly_any():
    """Two measurements leave one difference, three leave both numbers."""
    for z, rank in ((np.array([1.0, 2.0]), 1), (np.array([1.0, 2.0, 2.5]), 2), (np.ones(9), 2)):
        data = Data(LevelSample(z), np.zeros(len(z)))
        problem = Problem("few", facts_of(LocalLevel), LocalLevel(1.0), None, LIKELY, data)
        found = determined(problem)
        assert found.rank == rank
        assert np.isfinite(found.start).all()
        assert np.isfinite(list(found.values.values())).all()
