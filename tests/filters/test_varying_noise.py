"""Noise by the level and by a channel, and coloured noise, against loops and whole covariances."""

import pickle

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.stats import multivariate_normal

from filters import (
    ConstantAcceleration,
    ConstantVelocity,
    ConstantVelocityNoise,
    LevelSample,
    LocalLevel,
    LocalLevelNoise,
    PositionSample,
    Timed,
    TimedSample,
    Vertical,
    channel_facts,
    channel_noise,
    coloured_noise,
    level_noise,
    parameter_facts,
    run,
)

Q, R = 0.04, 0.3


def record(n=40, seed=0):
    draw = np.random.default_rng(seed)
    z = 5 + np.cumsum(0.3 * draw.standard_normal(n))
    z[[0, 7, 8]] = np.nan
    return z


def level_loop(z, r_of):
    """Innovations and variances of a random walk whose measurements' variance is r_of(k, level)."""
    x = p = None
    found = []
    for k, zk in enumerate(z):
        if x is not None:
            p = p + Q
        r = r_of(k, zk if x is None else x)
        if np.isnan(zk):
            found.append((0.0, 0.0))
        elif x is None:
            x, p = zk, r
            found.append((0.0, 0.0))
        else:
            s = p + r
            found.append((zk - x, s))
            x, p = x + p / s * (zk - x), p * r / s
    return np.array(found).T


def ran(cls, sample, **more):
    params = cls.params(jnp.array(Q), jnp.array(R), **{n: jnp.array(v) for n, v in more.items()})
    out = run(cls(1.0), params, sample)[1]
    return out.innovation[:, 0], out.variance[:, 0]


def test_noise_by_the_level_is_that_of_the_loop():
    z = record()
    found = ran(level_noise(LocalLevel), LevelSample(jnp.asarray(z)), slope=0.2)
    wanted = level_loop(z, lambda _, x: (R**0.5 + 0.2 * abs(x)) ** 2)
    np.testing.assert_allclose(found, wanted, rtol=1e-11, atol=1e-13)


def test_noise_by_the_level_and_a_told_deviation():
    z, sigma = record(), np.random.default_rng(1).uniform(0.5, 2, 40)
    sigma[12] = 0.0  # says that there is no measurement
    sample = LevelSample(jnp.asarray(z), jnp.asarray(sigma))
    found = ran(level_noise(LocalLevel), sample, slope=0.2)
    z[12] = np.nan
    wanted = level_loop(z, lambda k, x: (sigma[k] * R**0.5 + 0.2 * abs(x)) ** 2)
    np.testing.assert_allclose(found, wanted, rtol=1e-11, atol=1e-13)


def test_noise_by_a_channel_is_that_of_the_loop():
    z, sigma = record(), np.random.default_rng(1).uniform(0.5, 2, 40)
    sigma[12] = np.nan
    sample = LevelSample(jnp.asarray(z), jnp.asarray(sigma))
    found = ran(channel_noise(LocalLevel), sample, share=0.7)
    z[12] = np.nan
    wanted = level_loop(z, lambda k, _: R + 0.7 * sigma[k] ** 2)
    np.testing.assert_allclose(found, wanted, rtol=1e-11, atol=1e-13)


def test_a_channel_that_is_not_there_is_asked_for():
    with pytest.raises(ValueError, match="--map sigma=COLUMN"):
        ran(channel_noise(LocalLevel), LevelSample(jnp.zeros(3)), share=1.0)


def nats(found):
    y, s = (np.asarray(part)[np.asarray(found[1]) > 0] for part in found)
    return np.sum(y**2 / s + np.log(2 * np.pi * s)) / 2


@pytest.mark.parametrize("tau", [0.3, 2.0, 50.0])
def test_coloured_noise_is_the_density_of_all_differences_at_once(tau):
    """From the first measurement on: a walk and a Markov process, by their whole covariance."""
    z = record()
    found = ran(coloured_noise(LocalLevel, 1.0), LevelSample(jnp.asarray(z)), tau=tau)
    seen = np.flatnonzero(~np.isnan(z))
    k = seen[:, None]
    cov = Q * np.minimum(k, k.T) + R * np.exp(-np.abs(k - k.T) / tau)
    less = np.diff(np.eye(len(seen)), axis=0)
    law = multivariate_normal(np.zeros(len(seen) - 1), less @ cov @ less.T)
    assert nats(found) == pytest.approx(-law.logpdf(less @ z[seen]), rel=1e-9)


def test_coloured_noise_at_varying_times_of_two_axes():
    """Second differences over the times, as of a constant velocity nothing is known at first."""
    draw = np.random.default_rng(2)
    dt = draw.uniform(0.5, 2.0, 12)
    t, q, tau = np.cumsum(dt), 0.2, 1.5
    xy = np.cumsum(draw.standard_normal((12, 2)), axis=0)
    sample = TimedSample(
        jnp.asarray(dt), PositionSample(jnp.asarray(xy[:, 0]), jnp.asarray(xy[:, 1]))
    )
    cls = coloured_noise(ConstantVelocity, 1.0)
    params = cls.params(*map(jnp.array, (q, R, tau)))
    out = run(Timed(cls(1.0, "xy")), params, sample)[1]
    low, gap = np.minimum(t[:, None], t), np.abs(t[:, None] - t)
    start = low - t[0]
    cov = q * (start**3 / 3 + start**2 * gap / 2) + R * np.exp(-gap / tau)
    # Rows that no position and no velocity at the start move.
    moves = np.stack([np.ones(12), t - t[0]])
    basis = np.linalg.svd(moves)[2][2:]
    law = multivariate_normal(np.zeros(10), basis @ cov @ basis.T)
    wanted = -sum(law.logpdf(basis @ axis) for axis in xy.T)
    # The density of these and of what is left after the first two differ by a constant alone.
    first = np.linalg.slogdet(np.stack([np.ones(2), t[:2] - t[0]]))[1]
    whole = np.linalg.slogdet(
        np.stack([np.ones(12), t - t[0]]) @ np.stack([np.ones(12), t - t[0]]).T
    )
    assert nats((out.innovation, out.variance)) == pytest.approx(
        wanted - 2 * (first - whole[1] / 2), rel=1e-9
    )
    assert out.position.shape == (12, 2)
    assert out.velocity.shape == (12, 2)


def test_white_noise_is_coloured_noise_without_memory():
    z = jnp.asarray(record())
    cls = coloured_noise(ConstantVelocity, 1.0)
    params = cls.params(*map(jnp.array, (Q, R, 1e-3)))
    coloured = run(cls(1.0), params, PositionSample(z))[1]
    plain = run(ConstantVelocity(1.0), ConstantVelocityNoise(*params[:2]), PositionSample(z))[1]
    for name in plain._fields:
        np.testing.assert_allclose(
            getattr(coloured, name), getattr(plain, name), rtol=1e-9, atol=1e-9
        )


def test_two_measurements_of_one_time_are_one():
    cls = coloured_noise(LocalLevel, 1.0)
    params = cls.params(*map(jnp.array, (Q, R, 2.0)))
    dt = jnp.array([0.0, 1.0, 0.0, 1.0])
    sample = TimedSample(dt, LevelSample(jnp.array([1.0, 2.0, 5.0, 3.0])))
    out = run(Timed(cls(1.0)), params, sample)[1]
    assert (out.variance[:, 0] > 0).tolist() == [False, True, False, True]
    assert np.isfinite(out.level).all()


def test_no_slope_and_no_memory_are_the_filter_itself():
    z = LevelSample(jnp.asarray(record()))
    plain = run(LocalLevel(1.0), LocalLevelNoise(jnp.array(Q), jnp.array(R)), z)[1]
    found = ran(level_noise(LocalLevel), z, slope=0.0)
    np.testing.assert_allclose(found, (plain.innovation[:, 0], plain.variance[:, 0]), rtol=1e-12)


MADE = [level_noise, channel_noise, lambda base: coloured_noise(base, 0.1)]
BASES = [LocalLevel, ConstantVelocity, ConstantAcceleration]


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("make", MADE)
def test_facts_are_those_of_the_filter_and_one_more(make, base):
    cls = make(base)
    assert cls is make(base)
    more = parameter_facts(cls).keys() - parameter_facts(base).keys()
    assert len(more) == 1
    for part in ("inputs", "states", "outputs"):
        assert channel_facts(cls, part) == channel_facts(base, part)
    assert cls(dt=0.1) == cls(dt=0.1)
    assert hash(cls(dt=0.1)) == hash(cls(dt=0.1))
    assert pickle.loads(pickle.dumps(cls(dt=0.1))) == cls(dt=0.1)
    assert list(cls.derived) == ["Q"]
    params = cls.params(*(jnp.asarray(1.0) for _ in cls.params._fields))
    assert list(cls(dt=0.1).derive(params)) == ["Q"]


def test_parts_go_around_one_another():
    cls = level_noise(coloured_noise(LocalLevel, 1.0))
    assert list(parameter_facts(cls)) == ["q", "R", "tau", "slope"]
    z = record()
    found = ran(cls, LevelSample(jnp.asarray(z)), tau=1e-3, slope=0.2)
    wanted = level_loop(z, lambda _, x: (R**0.5 + 0.2 * abs(x)) ** 2)
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-12)


def test_axes_are_those_that_are_given():
    filter = level_noise(ConstantVelocity)(0.1).given(frozenset("xy"))
    assert filter.axes == "xy"
    with pytest.raises(ValueError, match="dt is -1; give a positive"):
        level_noise(LocalLevel)(-1)


@pytest.mark.parametrize("make", MADE)
def test_a_filter_that_takes_no_deviations_is_refused(make):
    with pytest.raises(ValueError, match="Vertical takes no deviation of each measurement"):
        make(Vertical)


def test_levels_of_several_axes_are_distances():
    draw = np.random.default_rng(4)
    xy = 20 + np.cumsum(draw.standard_normal((8, 2)), axis=0)
    cls = level_noise(ConstantVelocity)
    params = cls.params(*map(jnp.array, (0.1, R, 0.3)))
    sample = PositionSample(*map(jnp.asarray, xy.T))
    out = run(cls(1.0, "xy"), params, sample)[1]
    lengths = [np.hypot(*xy[0]), *(np.hypot(*place) for place in np.asarray(out.position)[:-1])]
    sigma = 1 + 0.3 / R**0.5 * np.array(lengths)
    plain = run(
        ConstantVelocity(1.0, "xy"),
        ConstantVelocityNoise(*params[:2]),
        sample._replace(sigma=jnp.asarray(sigma)),
    )[1]
    np.testing.assert_allclose(out.variance, plain.variance, rtol=1e-10)
    assert np.ptp(lengths) > 0.5
