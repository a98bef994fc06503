"""Chauhan's filters against plain NumPy, and the properties the notes name."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import run
from filters.dead_reckoning import (
    DeadReckoningKalman,
    DeadReckoningNoise,
    DeadReckoningSample,
    constructed_attitude,
    track_jacobian,
)
from filters.gps_aided import (
    GpsAidedKalman,
    GpsAidedNoise,
    GpsAidedSample,
    euler_angles,
    moved_by,
    turning,
    wrapped,
)
from tests import oracles_chauhan2009 as oracle

QUICK = {"xla_backend_optimization_level": 0}
compiled = jax.jit(run, static_argnums=0, compiler_options=QUICK)
DT, SAME = oracle.T, 1e-12


def every_fourth(values):
    """NaN in all rows but the fourth, the eighth, .."""
    kept = np.full_like(values, np.nan)
    kept[3::4] = values[3::4]
    return jnp.asarray(kept)


def noise(**changed):
    given = oracle.DEFAULTS | changed
    scale = np.zeros(7) if given["scale"] is None else given["scale"]
    variances = np.diag(given["R"])
    numbers = {f"R_{a}": r for a, r in zip(("phi", "theta", "psi"), variances, strict=True)}
    for at, part in ((0, "quaternion"), (6, "bias")):
        numbers |= {f"Q_{part}": given["Q"][at, at], f"floor_{part}": given["floor"]}
        numbers |= {f"P0_{part}": given["P0"][at, at]}
    start = {"q0": given["x0"][:4], "b0": given["x0"][4:]}
    made = numbers | start | {"h": given["h"], "scale": scale}
    return GpsAidedNoise(**{name: jnp.asarray(value, float) for name, value in made.items()})


def example(samples):
    """The notes' example; a long one turns slowly enough to stay away from the vertical."""
    rates, z = oracle.example(samples)
    if samples > 8:
        z[:, 2] = 0.002 * np.arange(1, samples + 1)
    return rates, z


def filtered(filter, samples, draws=None, **changed):
    rates, z = example(samples)
    drawn = None
    if draws is not None:
        drawn = np.zeros((samples, 7))
        drawn[3::4] = draws[: samples // 4]
        drawn = jnp.asarray(drawn)
    inputs = GpsAidedSample(jnp.asarray(rates), every_fourth(z), drawn)
    return compiled(filter, noise(**changed), inputs)[1]


def test_the_example_of_the_notes():
    """(q2 of the notes is .00641111; no reading of them gives that, see the oracle.)"""
    found = filtered(GpsAidedKalman(DT), 8)
    for value, printed in zip(found.x[-1], oracle.REPRODUCE_X, strict=True):
        digits = len(printed.split(".")[1])
        assert round(float(value), digits) == float(printed)
    assert round(float(jnp.trace(found.P[-1])), 7) == float(oracle.REPRODUCE_TRACE)


VARIANTS = {
    "constant": ({}, 8, {}),
    "kinematics": ({"kinematics": "printed"}, 8, {"kinematics": "printed"}),
    "propagation": ({"propagation": "printed"}, 8, {"propagation": "printed"}),
    "euler": ({"euler": "unit"}, 8, {"euler": "unit"}),
    "projection": ({"projected": False}, 8, {"projection": "none"}),
    "fuzzy": ({"law": "fuzzy"}, 80, {}),
    "edge": ({"law": "fuzzy", "slope": "edge"}, 80, {"slope": "edge", "h": 0.5}),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_every_variant_is_the_textbook_loop(name):
    ours, samples, theirs = VARIANTS[name]
    h = theirs.get("h", 0.0)
    found = filtered(GpsAidedKalman(DT, **ours), samples, h=h)
    wanted = oracle.run(*example(samples), ours.get("law", "constant"), **theirs)
    np.testing.assert_allclose(found.x, wanted["x"], rtol=0, atol=SAME)
    np.testing.assert_allclose(found.P, wanted["P"], rtol=0, atol=SAME)
    np.testing.assert_allclose(found.Q, wanted["Q"], rtol=0, atol=SAME)
    np.testing.assert_allclose(found.residual[3::4], wanted["residual"], rtol=0, atol=SAME)


def test_the_random_law_takes_its_draws():
    draws, scale = np.abs(np.sin(np.arange(140))).reshape(20, 7), np.full(7, 0.01)
    found = filtered(GpsAidedKalman(DT, law="random"), 80, draws, scale=scale)
    wanted = oracle.run(*example(80), "random", scale=scale, draws=draws)
    np.testing.assert_allclose(found.x, wanted["x"], rtol=0, atol=SAME)
    np.testing.assert_allclose(found.Q, wanted["Q"], rtol=0, atol=SAME)
    with pytest.raises(ValueError, match="the random law needs uniform numbers"):
        filtered(GpsAidedKalman(DT, law="random"), 8, scale=scale)


@pytest.mark.parametrize("slope", ["center", "edge"])
@pytest.mark.parametrize("law", ["fuzzy", "random"])
def test_the_laws_stay_in_single_precision(law, slope):
    rates, z = example(8)
    inputs = GpsAidedSample(jnp.asarray(rates), every_fourth(z), jnp.ones((8, 7)))
    narrow = jax.tree.map(lambda leaf: leaf.astype(jnp.float32), (noise(), inputs))
    found = jax.eval_shape(partial(run, GpsAidedKalman(DT, law=law, slope=slope)), *narrow)
    assert {leaf.dtype for leaf in jax.tree.leaves(found)} == {jnp.dtype("float32")}


def test_a_constant_rate_turns_by_the_step_s_arc_tangent():
    """And the printed kinematics turns twice as far: 79.9 deg for 40."""
    rate = np.radians(10.0)
    samples = GpsAidedSample(
        jnp.tile(jnp.array([0.0, 0.0, rate]), (16, 1)), jnp.full((16, 3), jnp.nan)
    )
    for kinematics, half in (("half", 0.5), ("printed", 1.0)):
        found = compiled(GpsAidedKalman(DT, kinematics=kinematics), noise(), samples)[1]
        turned = 16 * 2 * np.arctan(half * rate * DT)
        np.testing.assert_allclose(found.angles[-1], [0.0, 0.0, turned], atol=1e-12)
    assert f"{np.degrees(turned):.1f}" == oracle.PRINTED_TURN


def test_covariance_stays_positive_for_an_hour_at_100_hz():
    """1.5 rad/s about x, which makes the printed propagation indefinite within a minute."""
    ticks = 360_000
    rates = jnp.tile(jnp.array([1.5, 0.0, 0.0]), (ticks, 1))
    t = 0.01 * jnp.arange(1, ticks + 1)
    roll = (1.5 * t + jnp.pi) % (2 * jnp.pi) - jnp.pi
    seen = (jnp.arange(ticks) % 100 == 99)[:, None]
    z = jnp.where(seen, jnp.stack([roll, 0 * t, 0 * t], axis=1), jnp.nan)
    filter = GpsAidedKalman(0.01, every=100)

    def worst(params, inputs):
        """The least entry of an LDL' over all ticks, relative; no matrix is kept."""
        P = run(filter, params, inputs)[1].P[::97]
        return P, jnp.isfinite(P).all()

    P, finite = jax.jit(worst)(noise(), GpsAidedSample(rates, z))
    values = np.linalg.eigvalsh(np.asarray(P))
    assert bool(finite)
    assert (values[:, 0] >= -1e-14 * values[:, -1]).all()


def test_after_an_update_nothing_is_known_along_the_quaternion():
    found = filtered(GpsAidedKalman(DT), 8)
    for k in (3, 7):
        q, P = np.asarray(found.x[k, :4]), np.asarray(found.P[k])
        assert np.abs(P[:, :4] @ q).max() < 1e-17
        values = np.linalg.eigvalsh(P)
        assert values[0] >= -1e-17
        assert values[1] > 1e-6 * values[-1]  # rank 6


def test_angles_and_their_helpers():
    rng = np.random.default_rng(0)
    for _ in range(5):
        q, w = rng.normal(size=4), rng.normal(size=3)
        np.testing.assert_allclose(euler_angles(jnp.asarray(q)), oracle.euler(q), atol=1e-14)
        slope = jax.jacfwd(euler_angles)(jnp.asarray(q))
        np.testing.assert_allclose(slope, oracle.euler_jacobian(q), atol=1e-12)
        assert np.abs(slope @ q).max() < 1e-13
        np.testing.assert_allclose(turning(jnp.asarray(w)), oracle.omega(w))
        np.testing.assert_allclose(moved_by(jnp.asarray(q)), oracle.xi(q))
    np.testing.assert_allclose(
        wrapped(jnp.radians(jnp.array([350.0, 100.0, -190.0]))), np.radians([-10, 100, 170])
    )


# --- position and the constructed attitude ------------------------------------------------------


def test_position_is_the_textbook_loop():
    rng = np.random.default_rng(1)
    speed, angles = rng.uniform(5, 9, 12), 0.3 * rng.normal(size=(12, 3))
    z = rng.normal(size=(12, 3))
    z[::2] = np.nan
    R, Q = np.array([4.0, 4.0, 9.0]), np.diag([0.5, 1e-3, 1e-3, 4e-3])
    x, P, wanted = np.zeros(3), np.eye(3), []
    for V, attitude, position in zip(speed, angles, z, strict=True):
        x, P = oracle.position_predict(x, P, V, attitude, Q, DT)
        if not np.isnan(position).any():
            x, P = oracle.position_update(x, P, position, np.diag(R))
        wanted.append((x, P))
    numbers = (*R[1:], Q[0, 0], Q[1, 1], Q[3, 3])
    given = DeadReckoningNoise(*map(jnp.asarray, numbers), jnp.zeros(3), jnp.ones(()))
    samples = DeadReckoningSample(*map(jnp.asarray, (speed, angles, z)))
    found = compiled(DeadReckoningKalman(DT), given, samples)[1]
    np.testing.assert_allclose(found.position, [x for x, _ in wanted], atol=SAME)
    np.testing.assert_allclose(found.P, [P for _, P in wanted], atol=SAME)


def test_track_jacobian_is_that_of_the_velocity():
    def velocity(u):
        (_, ct, cp), (_, st, sp) = jnp.cos(u[1:]), jnp.sin(u[1:])
        return u[0] * jnp.stack([ct * cp, ct * sp, -st])

    u = jnp.array([7.0, 0.2, -0.3, 1.1])
    np.testing.assert_allclose(track_jacobian(u[0], u[1:]), jax.jacfwd(velocity)(u), atol=1e-14)


construct = jax.jit(partial(constructed_attitude, dt=1.0, gravity=oracle.GRAVITY))


def test_constructed_attitude():
    rng = np.random.default_rng(2)
    for _ in range(10):
        p = np.cumsum(3 * rng.normal(size=(3, 3)) + [10.0, 3.0, 0.0], axis=0)
        a = np.array([0.0, 0.0, -oracle.GRAVITY]) + rng.normal(size=3)
        np.testing.assert_allclose(construct(p, a), oracle.constructed_attitude(p, a), atol=SAME)


def test_constructed_attitude_where_there_is_none():
    rest, moving = np.zeros((3, 3)), np.cumsum(np.full((3, 3), [5.0, 0.0, 0.0]), axis=0)
    assert np.isnan(construct(rest, np.array([0.0, 0.0, -oracle.GRAVITY]))).all()
    assert np.isnan(construct(moving, np.array([20.0, 0.0, -oracle.GRAVITY]))).all()
