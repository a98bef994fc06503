"""The unscented Kalman filter against the textbook's loop of weights and an inverse."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filters import (
    ExtendedModel,
    ExtendedSample,
    LinearKalman,
    LinearModel,
    Sample,
    Transition,
    UnscentedKalman,
    run,
)
from filters.small_linalg import semidefinite_root
from tests.oracles import central_difference
from tests.strategies import covariance, seeds

N = 20
compiled = jax.jit(run, static_argnums=0)


# A vehicle with speed and yaw rate, x = (east, north, heading), that is sighted from a mast: range,
# bearing and compass. f brings the heading back within half a turn.


def driven(p, x, u):
    ahead = jnp.stack([x[0] + u[0] * jnp.cos(x[2]), x[1] + u[0] * jnp.sin(x[2])])
    heading = x[2] + u[1]
    return jnp.append(ahead, heading - 2 * jnp.pi * jnp.round(heading / (2 * jnp.pi)))


def shaken(p, x, u):
    return p * (1 + 0.1 * x[0] ** 2) * jnp.array([[1, 0.2, 0], [0.2, 1, 0], [0, 0, 0.5]], x.dtype)


def sighted(p, x, u):
    return jnp.stack([jnp.sqrt(x[0] ** 2 + x[1] ** 2), jnp.arctan2(x[1], x[0]), x[2]])


MEASURED, KEPT = (False, True, True), (False, False, True)


def driven_by_numpy(x, u):
    x = x + np.array([u[0] * np.cos(x[2]), u[0] * np.sin(x[2]), u[1]], x.dtype)
    x[2] = within(x[2])
    return x


def sighted_by_numpy(x):
    return np.array([np.sqrt(x[0] ** 2 + x[1] ** 2), np.arctan2(x[1], x[0]), x[2]])


def within(angle):
    turn = 2 * np.arctan2(angle * 0, angle * 0 - 1)  # of the argument's precision
    return angle - turn * np.round(angle / turn)


def apart(a, b, angles):
    return np.where(angles, within(a - b), a - b)


def cholesky(P):
    """Row by row; a variance that is all explained leaves a column of zeros."""
    n = len(P)
    L = np.zeros_like(P)
    for j in range(n):
        left = P[j, j] - sum(L[j, k] ** 2 for k in range(j))
        if left <= 1e-14 * P[j, j]:
            continue
        L[j, j] = np.sqrt(left)
        for i in range(j + 1, n):
            L[i, j] = (P[i, j] - sum(L[i, k] * L[j, k] for k in range(j))) / L[j, j]
    return L


def points_of(x, P, alpha, beta, kappa):
    """The sigma points and their weights for means and for covariances."""
    n = len(x)
    scaled = alpha**2 * (n + kappa) - n
    root = np.sqrt(n + scaled) * cholesky(P)
    points = [x, *(x + root[:, i] for i in range(n)), *(x - root[:, i] for i in range(n))]
    mean = np.full(2 * n + 1, 1 / (2 * (n + scaled)), x.dtype)
    mean[0] = scaled / (n + scaled)
    spread = mean.copy()
    spread[0] += 1 - alpha**2 + beta
    return points, mean, spread


def textbook(q, R, x, P, z, u, alpha, beta, kappa):
    """Sums of weighted points; an angle's mean is found from the angle of the first."""
    xs, Ps, densities = [], [], []
    for k in range(len(z)):
        Q = q * (1 + 0.1 * x[0] ** 2) * np.array([[1, 0.2, 0], [0.2, 1, 0], [0, 0, 0.5]])
        points, wm, wc = points_of(x, P, alpha, beta, kappa)
        moved = [driven_by_numpy(point, u[k]) for point in points]
        x = moved[0] + sum(w * apart(m, moved[0], KEPT) for w, m in zip(wm, moved, strict=True))
        off = [apart(m, x, KEPT) for m in moved]
        P = sum(w * np.outer(d, d) for w, d in zip(wc, off, strict=True)) + Q

        points, wm, wc = points_of(x, P, alpha, beta, kappa)
        seen = [sighted_by_numpy(point) for point in points]
        mean = seen[0] + sum(w * apart(s, seen[0], MEASURED) for w, s in zip(wm, seen, strict=True))
        off = [apart(s, mean, MEASURED) for s in seen]
        S = sum(w * np.outer(d, d) for w, d in zip(wc, off, strict=True)) + np.diag(R)
        C = sum(w * np.outer(point - x, d) for w, point, d in zip(wc, points, off, strict=True))
        there = ~np.isnan(z[k])
        y = apart(z[k], mean, MEASURED)[there]
        S, C = S[np.ix_(there, there)], C[:, there]
        inverse = np.linalg.inv(S.astype(float))
        K = C @ inverse
        x, P = x + K @ y, P - K @ S @ K.T
        densities.append(float(y @ inverse @ y) + np.log(np.linalg.det(S.astype(float))))
        xs.append(x)
        Ps.append(P)
    return np.array(xs, float), np.array(Ps, float), np.array(densities)


def drawn(rng):
    q, R = np.exp(rng.normal() - 5), np.exp(rng.normal(size=3) - 4)
    u = np.stack([0.2 + 0.1 * rng.normal(size=N), 0.4 + 0.2 * rng.normal(size=N)], axis=1)
    x0, z = np.array([-2.0, 0.3, 2.5]), []
    P0 = 0.02 * covariance(rng, 3, rng.integers(0, 4))
    x = x0 + np.sqrt(np.diag(P0)) * rng.normal(size=3)
    for one in u:
        x = driven_by_numpy(x, one)
        z.append(sighted_by_numpy(x) + np.sqrt(R) * rng.normal(size=3))
    z = np.array(z)
    z[:, 1:] += 2 * np.pi * rng.integers(-1, 2, size=(N, 2))  # whatever turn is told
    z[rng.uniform(size=(N, 3)) < 0.25] = np.nan
    return q, R, x0, P0, z, u


CONVENTIONS = {
    "ours": ((1.0, 2.0, None), (1.0, 2.0, 0.0)),
    "Julier and Uhlmann": ((1.0, 0.0, 0.5), (1.0, 0.0, 0.5)),
    "cubature": ((1.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
    "near": ((0.3, 2.0, 1.0), (0.3, 2.0, 1.0)),
    "Wan and van der Merwe": ((1e-3, 2.0, 0.0), (1e-3, 2.0, 0.0)),
}


@given(rng=seeds())
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_is_the_textbooks_filter(convention, rng):
    own, written = CONVENTIONS[convention]
    q, R, x0, P0, z, u = drawn(rng)
    model = ExtendedModel(*(jnp.asarray(part) for part in (q, R, x0, P0)))
    inputs = ExtendedSample(jnp.asarray(z), jnp.asarray(u))
    filter = UnscentedKalman(driven, shaken, sighted, *own, MEASURED, KEPT)
    last, out = compiled(filter, model, inputs)
    # The textbook's weights of +-1e6 cost the textbook's sums six digits: so in 80 bits.
    exact = [np.asarray(part, np.longdouble) for part in (q, R, x0, P0, z, u)]
    x, P, density = textbook(*exact, *written)
    # Curvature is a second difference over alpha^2: eps / alpha^2 a sample, and 20 of them.
    tolerance = 1e-10 if own[0] > 0.1 else 1e-7
    scale = max(1.0, np.abs(P).max())
    assert np.abs(apart(np.asarray(out.x), x, KEPT)).max() <= tolerance * 5
    np.testing.assert_allclose(out.P, P, rtol=0, atol=tolerance * scale)
    there = ~np.isnan(z)
    variance = np.where(there, out.variance, 1.0)
    found = (np.asarray(out.innovation) ** 2 / variance + np.log(variance)).sum(axis=1)
    np.testing.assert_allclose(found, density, rtol=100 * tolerance, atol=100 * tolerance)
    np.testing.assert_array_equal(last.x, out.x[-1])
    np.testing.assert_array_equal(np.asarray(out.gain)[~there], 0.0)
    np.testing.assert_array_equal(np.asarray(out.innovation)[~there], 0.0)
    np.testing.assert_array_equal(np.asarray(out.variance) == 0, ~there)


def moved(p, x, u):
    return p.transition.F @ x + p.transition.B @ u


def disturbed(p, x, u):
    return p.transition.G @ p.transition.Q @ p.transition.G.T


def measured(p, x, u):
    return p.H @ x


@given(rng=seeds(), rank=st.integers(0, 3))
def test_of_a_linear_model_is_the_linear_filter(rng, rank):
    """For any weights: of a line they make the mean and the covariance, whatever they are."""
    F = rng.normal(size=(3, 3))
    model = LinearModel(
        Transition(
            0.95 * F / np.abs(np.linalg.eigvals(F)).max(),
            rng.normal(size=(3, 1)),
            np.array([[0.3]]),
            rng.normal(size=(3, 1)),
        ),
        rng.normal(size=(2, 3)),
        np.array([0.5, 2.0]),
        covariance(rng, 3, rank),
        rng.normal(size=3),
    )
    model = jax.tree.map(jnp.asarray, model)
    z, u = rng.normal(size=(N, 2)), jnp.asarray(rng.normal(size=(N, 1)))
    z[rng.uniform(size=(N, 2)) < 0.3] = np.nan
    plain = compiled(LinearKalman(), model, Sample(jnp.asarray(z), u=u))
    unscented = compiled(
        UnscentedKalman(moved, disturbed, measured),
        ExtendedModel(model, model.R, model.x0, model.P0),
        ExtendedSample(jnp.asarray(z), u),
    )
    for one, other in zip(jax.tree.leaves(unscented), jax.tree.leaves(plain), strict=True):
        scale = max(1.0, np.abs(np.asarray(other)).max())
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-11 * scale)


def test_of_squares_mean_and_variance_are_those_of_a_normal_distribution():
    """x^2 of x ~ N(a, p) has the mean a^2 + p and the variance 4 a^2 p + 2 p^2: beta 0, kappa 2."""
    a, p = 1.5, 0.3
    filter = UnscentedKalman(
        lambda q, x, u: x**2, lambda q, x, u: jnp.zeros((1, 1)), lambda q, x, u: x, 1.0, 0.0
    )
    model = ExtendedModel(None, jnp.ones(1), jnp.array([a]), jnp.array([[p]]))
    _, out = filter.step(model, filter.init(model), ExtendedSample(jnp.array([jnp.nan])))
    assert float(out.x[0]) == pytest.approx(a**2 + p, rel=1e-14)
    assert float(out.P[0, 0]) == pytest.approx(4 * a**2 * p + 2 * p**2, rel=1e-14)


def bent(p, x, u):
    return jnp.einsum("ijk,j,k->i", p[0], x, x) / 10


def bowed(p, x, u):
    return jnp.einsum("ijk,j,k->i", p[1], x, x)


def unmoved(p, x, u):
    return jnp.zeros((5, 5))


@given(rng=seeds())
def test_from_beta_alpha_squared_on_no_covariance_is_indefinite(rng):
    """However strongly f and h bend."""
    model = 3 * rng.normal(size=(5, 5, 5)), 3 * rng.normal(size=(4, 5, 5))
    given = ExtendedModel(model, np.full(4, 1e-6), rng.normal(size=5), np.eye(5))
    inputs = ExtendedSample(jnp.asarray(rng.normal(size=(3, 4))))
    out = compiled(UnscentedKalman(bent, unmoved, bowed), jax.tree.map(jnp.asarray, given), inputs)[
        1
    ]
    values = np.linalg.eigvalsh(out.P)
    assert (values[:, 0] >= -1e-12 * values[:, -1]).all()
    assert (np.asarray(out.variance) > 0).all()


# --- the root ----------------------------------------------------------------------------------


@given(rng=seeds(), n=st.sampled_from([1, 2, 5, 9]), scale=st.integers(-12, 12))
def test_root_is_lower_triangular_and_makes_the_covariance(rng, n, scale):
    P = 10.0**scale * covariance(rng, n, rng.integers(0, n + 1))
    root = np.asarray(jax.jit(semidefinite_root)(P))
    np.testing.assert_array_equal(root, np.tril(root))
    np.testing.assert_allclose(root @ root.T, P, rtol=0, atol=1e-13 * n * np.abs(P).max())


def test_root_is_choleskys_where_there_is_one():
    P = covariance(np.random.default_rng(1), 9, 9)
    np.testing.assert_allclose(semidefinite_root(P), np.linalg.cholesky(P), rtol=0, atol=1e-13)


@pytest.mark.parametrize("rank", [0, 2])
def test_derivatives_are_finite_at_any_rank(rank):
    """And right: the filter's output is a smooth function of the start's size and of Q."""
    rng = np.random.default_rng(rank)
    P0 = 0.1 * covariance(rng, 3, rank)
    z, u = rng.normal(size=(5, 3)) + np.array([2.0, 0.0, 0.0]), 0.3 * rng.normal(size=(5, 2))

    def value(point):
        model = ExtendedModel(point[0], jnp.ones(3), jnp.array([-2.0, 0.3, 1.0]), point[1] * P0)
        filter = UnscentedKalman(driven, shaken, sighted, angles=MEASURED)
        out = run(filter, model, ExtendedSample(jnp.asarray(z), jnp.asarray(u)))[1]
        return (out.x**2).sum() + (out.P**2).sum() + (out.innovation**2).sum()

    point = np.array([0.1, 1.0])
    found = jax.jit(jax.grad(value))(point)
    known = central_difference(lambda p: float(jax.jit(value)(p)), point, 1e-5)
    np.testing.assert_allclose(found, known, rtol=1e-7, atol=1e-7 * np.abs(known).max())
    ahead = jax.jvp(value, (jnp.asarray(point),), (jnp.ones(2),))[1]
    np.testing.assert_allclose(ahead, found.sum(), rtol=1e-10)


# --- what is refused ----------------------------------------------------------------------------


@pytest.mark.parametrize("alpha", [0.0, -1.0, np.nan, np.inf])
def test_alpha_is_checked(alpha):
    with pytest.raises(ValueError, match="^UnscentedKalman: alpha is .*; give a positive number"):
        UnscentedKalman(driven, shaken, sighted, alpha=alpha)


@pytest.mark.parametrize("kappa", [-3.0, -4.0, np.nan, np.inf])
def test_kappa_is_checked(kappa):
    model = ExtendedModel(None, jnp.ones(3), jnp.zeros(3), jnp.eye(3))
    filter = UnscentedKalman(driven, shaken, sighted, kappa=kappa)
    with pytest.raises(ValueError, match="kappa is .* for 3 states; give more than -3, or None"):
        filter.init(model)


def test_there_is_a_word_for_every_state():
    model = ExtendedModel(jnp.asarray(0.1), jnp.ones(3), jnp.zeros(3), jnp.eye(3))
    filter = UnscentedKalman(driven, shaken, sighted, turning=(True,))
    with pytest.raises(ValueError, match="^angles has 1 entries for 3 numbers"):
        run(filter, model, ExtendedSample(jnp.ones((N, 3)), jnp.ones((N, 2))))
