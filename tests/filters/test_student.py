"""Weights of Student's t against loops in NumPy and distributions of SciPy."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.stats import chi2

from filters import (
    ConstantVelocity,
    ConstantVelocityNoise,
    LevelSample,
    LinearKalman,
    LocalLevel,
    LocalLevelNoise,
    PositionSample,
    Sample,
    Student,
    measured_entries,
    run,
)
from filters.student import spread
from tests.filters.test_gated import JUDGED, found, pair, quickly

FAST = [c for c in JUDGED if c.name in ("local level, deviations", "vertical", "gravity, adaptive")]


@pytest.mark.parametrize("case", FAST, ids=lambda case: case.name)
def test_without_tails_it_changes_nothing(case):
    params, inputs, parts = found(case)
    student = Student(case.filter, parts, nu=1e9)
    both = quickly(lambda: [run(f, params, inputs)[1] for f in (case.filter, student)])
    plain, outputs = both()
    for name in plain._fields:
        np.testing.assert_allclose(
            getattr(outputs, name), getattr(plain, name), rtol=1e-12, atol=1e-12, err_msg=name
        )
    assert (outputs.weight == 1).all()


def pair_loop(z, nu):
    """Two sensors of one level, R enlarged so that the innovations have s / w; joint updates."""
    H, R, x, p, out = np.ones((2, 1)), 0.25 * np.eye(2), 0.0, 1.0, []
    for sample in z:
        p = p + 0.01
        S, y = p * H @ H.T + R, sample - x
        w = min(1.0, 2 * (nu + 2) / (nu * spread(nu, 2) + y @ np.linalg.solve(S, y)))
        S = S / w  # so is R: S / w - H p H'
        K = p * H.T @ np.linalg.inv(S)
        x, p = x + (K @ y).item(), p - (K @ S @ K.T).item()
        out.append((x, p, w))
    return np.array(out).T


def test_the_update_is_that_with_larger_variances():
    z = 0.5 * np.random.default_rng(3).standard_normal((60, 2))
    z[20, 0], z[40] = 40.0, (9.0, 9.0)
    record, model = Sample(jnp.asarray(z)), pair(0.25 * jnp.ones(2))
    student = Student(LinearKalman(), measured_entries(LinearKalman(), model, record), 4.0)
    outputs = run(student, model, record)[1]
    x, p, w = pair_loop(z, 4.0)
    np.testing.assert_allclose(outputs.x[:, 0], x, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(outputs.P[:, 0, 0], p, rtol=1e-10)
    np.testing.assert_allclose(outputs.weight[:, 1], w, rtol=1e-12)
    assert np.asarray(outputs.rejected)[[20, 40]].all()
    np.testing.assert_allclose(outputs.variance * outputs.weight, outputs.predicted, rtol=1e-12)


def test_a_jump_is_followed():
    z = np.zeros(300)
    z[100:] = 1000.0
    noise, record = LocalLevelNoise(jnp.array(0.01), jnp.array(1.0)), LevelSample(jnp.asarray(z))
    outputs = run(Student(LocalLevel(1.0), (((0, 0),),), 4.0), noise, record)[1]
    assert abs(float(outputs.level[-1]) - 1000) < 1


def test_what_starts_the_filter_is_taken_whole():
    """An axis begins while the other one is far off."""
    x, y = np.zeros(20), np.full(20, np.nan)
    x[10], y[10:] = 1e3, 5.0
    record = PositionSample(jnp.asarray(x), jnp.asarray(y))
    noise = ConstantVelocityNoise(jnp.array(0.1), jnp.array(1.0))
    student = Student(ConstantVelocity(1.0, "xy"), (((0, 0),), ((1, 0),)), 4.0)
    outputs = run(student, noise, record)[1]
    np.testing.assert_allclose(outputs.position[10:, 1], 5.0, rtol=1e-9)


@pytest.mark.parametrize(("nu", "m"), [(1.0, 1), (4.0, 1), (4.0, 3), (30.0, 2)])
def test_normal_innovations_fit_the_scale(nu, m):
    squares = chi2(m).ppf((np.arange(200000) + 0.5) / 200000)
    assert np.mean((nu + m) * squares / (nu * spread(nu, m) + squares)) == pytest.approx(m, 1e-4)


def test_the_gradient_is_that_of_differences():
    z = np.random.default_rng(5).standard_normal(50)
    z[20] = 30.0

    def loss(logs):
        noise = LocalLevelNoise(*jnp.exp(logs))
        out = run(Student(LocalLevel(1.0), (((0, 0),),)), noise, LevelSample(jnp.asarray(z)))[1]
        return (out.level**2).sum()

    at, h = jnp.log(jnp.array([0.1, 1.0])), 1e-6
    quick = quickly(loss)
    slope = [(quick(at + h * e) - quick(at - h * e)) / (2 * h) for e in np.eye(2)]
    np.testing.assert_allclose(quickly(jax.jacfwd(loss))(at), slope, rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "words"),
    [({"nu": 0.5}, "tails that nothing outweighs"), ({"parts": ((),)}, "nothing to weigh")],
)
def test_what_is_no_student_is_refused(change, words):
    with pytest.raises(ValueError, match=words):
        Student(LocalLevel(1.0), **{"parts": (((0, 0),),)} | change)
