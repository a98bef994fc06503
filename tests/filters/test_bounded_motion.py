"""The room filter against its equations in plain NumPy, and its rules one by one."""

from functools import cache, partial
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from filters import BoundedMotionKalman, BoundedMotionNoise, ImuSample, RestRule, blocks, run
from tests.oracles import surprise, surprises
from tuner.data.simulation import GRAVITY, Sensor, Swing, measure, simulate

DT, LENGTH, COUNT = 0.02, 4, 60
N, QUIET = COUNT * LENGTH, 150
"""Of every record, for each length is a compilation; and how many samples it rests first."""
RULE = RestRule(seconds=0.5)
ROOM = BoundedMotionKalman(DT, RULE)
START = Rotation.from_rotvec([0.03, -0.02, 1.0])
NOISE = {
    "speed": 0.3,
    "place": 0.2,
    "accelerometer": 0.03,
    "gyroscope": 1e-3,
    "turning": 5e-3,
    "bias": 2e-4,
    "matrix0": 1e-2,
    "bias0": 0.02,
    "tilt0": 0.03,
    "lead": 0.0,
    "gravity": GRAVITY,
    "q0": START.as_quat(scalar_first=True),
}
# Without the compiler's optimisation, which changes no formula and takes most of the time.
compiled = jax.jit(run, static_argnums=0, compiler_options={"xla_backend_optimization_level": 0})


@cache
def record():
    """Specific force and rate, ``(N, 3)``: 3 s of rest, then a fast swing."""
    motion = simulate(
        seconds=(N - QUIET) * DT, dt=DT, seed=4, swing=Swing((0.5, 0.4, 0.8), 0.3, 1.0)
    )
    whole = motion._replace(
        force=np.vstack([np.tile([0.0, 0.0, GRAVITY], (QUIET, 1)), motion.force]),
        rate=np.vstack([np.zeros((QUIET, 3)), motion.rate]),
    )
    sensed = measure(
        whole,
        gyroscope=Sensor(2e-3, (0.02, -0.01, 0.015)),
        accelerometer=Sensor(0.02),
        seed=5,
    )
    return np.asarray(sensed.acc), np.asarray(sensed.gyr)


def filtered(force, rate, **settings):
    """Outputs with one row a sample, the calibration after each block, and the last state."""
    params = BoundedMotionNoise(**{k: jnp.asarray(v, float) for k, v in (NOISE | settings).items()})
    cut = blocks(ImuSample(jnp.asarray(force), jnp.asarray(rate)), LENGTH)
    state, found = jax.tree.map(np.asarray, compiled(ROOM, params, cut))
    return state, found._replace(att=found.att.reshape(-1, 4))


def turns(q):
    return Rotation.from_quat(q, scalar_first=True)


def level_force(rotation):
    return np.tile(rotation.inv().apply([0.0, 0.0, GRAVITY]), (N, 1))


# --------------------------------------------------------------------------------- the oracle


def skewed(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def transition(axes, turned, force, span):
    """Errors of attitude, bias, speed, place and matrix, from the sums over a block.

    True attitude is exp(turn) R, true rate (1 - M)(measured - b); the attitude's error grows
    evenly through a block, so half of it acts on the speed.
    """
    F, push = np.eye(21), skewed(force)
    F[0:3, 3:6], F[0:3, 12:21] = -axes, -turned
    F[6:9, 0:3], F[6:9, 3:6], F[6:9, 12:21] = -push, push @ axes / 2, push @ turned / 2
    F[9:12, 0:3], F[9:12, 6:9] = -span / 2 * push, span * np.eye(3)
    return F


def still_for(quiet, force, rate):
    """The low passes of rate and force, and how long both have kept near them."""
    share = 1 - np.exp(-DT / RULE.memory)
    low_rate = quiet[0] + share * (rate - quiet[0])
    low_force = quiet[1] + share * (force - quiet[1])
    still = (
        np.linalg.norm(rate - low_rate) < RULE.rate
        and np.linalg.norm(force - low_force) < RULE.force
        and np.abs(low_rate).max() < RULE.rate
    )
    return low_rate, low_force, quiet[2] + DT if still else 0.0


def measured(s, nav, mean_rate, bias, resting, span):
    """Rows of H, what they measure and its variance: no speed, no place, and no rate at rest."""
    sigma = RULE.speed if resting else s["speed"]
    H = [*np.eye(21)[9:12], *np.eye(21)[6:9]]
    z = [*-nav[2], *-nav[1]]
    r = [s["place"] ** 2 / span] * 3 + [sigma**2 / span] * 3
    if resting:
        H += [*np.eye(21)[3:6]]
        z += [*(mean_rate - bias)]
        r += [RULE.bias**2 / span] * 3
    return np.array(H), np.array(z), np.diag(r)


def textbook(force, rate, **settings):
    """All measurements of a block at once, with an inverse; attitudes as scipy's rotations."""
    s, span = NOISE | settings, LENGTH * DT
    nav = (turns(s["q0"]), np.zeros(3), np.zeros(3))
    bias, matrix, quiet = np.zeros(3), np.zeros((3, 3)), (np.zeros(3), np.zeros(3), 0.0)
    sizes = [s["tilt0"]] * 3 + [s["bias0"]] * 3 + [0.01] * 6 + [s["matrix0"]] * 9
    P = np.diag(np.square(sizes))
    found = SimpleNamespace(q=[], bias=[], matrix=[], rest=[], rate=[], surprise=[])
    for begin in range(0, N, LENGTH):
        attitude, speed, place = nav
        axes, turned, push, square = np.zeros((3, 3)), np.zeros((3, 9)), np.zeros(3), 0.0
        for f, w in zip(force[begin : begin + LENGTH], rate[begin : begin + LENGTH], strict=True):
            known = (w - bias) - matrix @ (w - bias)
            attitude = attitude * Rotation.from_rotvec(known * DT)
            R = attitude.as_matrix()
            speed = speed + (R @ f - [0.0, 0.0, s["gravity"]]) * DT
            place = place + speed * DT
            axes, push, square = axes + DT * R, push + DT * R @ f, square + DT * known @ known
            turned = turned + DT * np.kron(R, known[None, :])
            quiet = still_for(quiet, f, w)
            ahead = attitude * Rotation.from_rotvec(known * s["lead"])
            found.q.append(ahead.as_quat(scalar_first=True))
            found.rate.append(known)
        turn = s["gyroscope"] ** 2 * span + s["turning"] ** 2 * square
        W = [turn, s["bias"] ** 2 * span, s["accelerometer"] ** 2 * span, 0.0]
        F = transition(axes, turned, push, span)
        P = F @ P @ F.T + np.diag([*np.repeat(W, 3), *np.zeros(9)])
        resting = quiet[2] > RULE.seconds
        mean = rate[begin : begin + LENGTH].mean(axis=0)
        H, z, r = measured(s, (attitude, speed, place), mean, bias, resting, span)
        S = H @ P @ H.T + r
        K = P @ H.T @ np.linalg.inv(S)
        found.surprise.append(surprise(z, S))
        x, P = K @ z, (np.eye(21) - K @ H) @ P
        nav = (Rotation.from_rotvec(x[0:3]) * attitude, speed + x[6:9], place + x[9:12])
        bias, matrix = bias + x[3:6], matrix + x[12:21].reshape(3, 3)
        for column, value in (("bias", bias), ("matrix", matrix), ("rest", resting)):
            getattr(found, column).append(value)
    columns = {name: np.array(rows) for name, rows in vars(found).items()}
    return SimpleNamespace(**columns, P=P, speed=nav[1], place=nav[2])


@cache
def oracle():
    return textbook(*record())


@cache
def plain():
    return filtered(*record())


# Sequential updates in Joseph's form against a joint inverse: here they agree to 3e-15, and the
# smallest wrong term of the transition is seen at 1e-9.
near = partial(np.testing.assert_allclose, rtol=0, atol=1e-9)


def test_is_the_textbooks_navigation():
    state, found = plain()
    rest = oracle().rest
    # the low pass of the force needs 1.5 s to come within 0.5 m/s^2 of g, and then it has to last
    assert 8 <= rest.sum() <= 20
    assert not rest[: QUIET // (2 * LENGTH)].any()
    assert not rest[-5:].any()
    np.testing.assert_array_equal(found.rest, rest)
    sign = np.sign((found.att * oracle().q).sum(axis=1, keepdims=True))
    near(found.att * sign, oracle().q)
    near(found.bias, oracle().bias)
    near(found.matrix, oracle().matrix)
    np.testing.assert_array_equal((found.variance > 0).sum(axis=1), np.where(rest, 9, 6))
    near(surprises(found.innovation, found.variance), oracle().surprise)
    near(state.at.speed, oracle().speed)
    near(state.at.place, oracle().place)
    near(state.P, oracle().P)


def test_samples_one_by_one_are_blocks_of_one():
    force, rate = (part[:LENGTH] for part in record())
    params = BoundedMotionNoise(**{k: jnp.asarray(v, float) for k, v in NOISE.items()})
    samples = ImuSample(jnp.asarray(force), jnp.asarray(rate), jnp.asarray(rate))
    state, alone = compiled(ROOM, params, samples)
    same, cut = compiled(ROOM, params, blocks(samples, 1))
    for one, other in zip(jax.tree.leaves(state), jax.tree.leaves(same), strict=True):
        near(one, other, atol=1e-14)
    near(alone.att, cut.att[:, 0], atol=1e-14)
    assert alone.att.shape == (LENGTH, 4)


def test_a_missing_rate_is_no_turn():
    force, rate = (np.array(part[: 2 * LENGTH]) for part in record())
    rate[LENGTH + 3] = np.nan
    filled = np.where(np.isnan(rate), 0.0, rate)
    still = NOISE | {"bias0": 0.0, "bias": 0.0}  # else the bias is no longer zero, as it begins
    params = BoundedMotionNoise(**{k: jnp.asarray(v, float) for k, v in still.items()})
    found = [
        compiled(ROOM, params, blocks(ImuSample(jnp.asarray(force), jnp.asarray(w)), LENGTH))[1].att
        for w in (rate, filled)
    ]
    near(*found, atol=1e-14)


def test_the_record_shows_every_part():
    """What agrees above is not zero: rest finds the bias, and the swing the matrix."""
    state, found = plain()
    resting = np.flatnonzero(found.rest)
    np.testing.assert_allclose(found.bias[resting[-1]], [0.02, -0.01, 0.015], atol=1e-3)
    assert np.abs(found.bias[resting[0] - 1] - [0.02, -0.01, 0.015]).max() > 3e-3
    assert np.abs(found.matrix).max() > 1e-5
    assert np.linalg.eigvalsh(state.P).min() > 0
    np.testing.assert_array_equal(state.P, state.P.T)


def test_a_lead_moves_the_output_only():
    (state, found), (other, ahead) = plain(), filtered(*record(), lead=0.015)
    for one, two in zip(jax.tree.leaves(state), jax.tree.leaves(other), strict=True):
        np.testing.assert_array_equal(one, two)
    np.testing.assert_array_equal(found.matrix, ahead.matrix)
    turned = (turns(found.att).inv() * turns(ahead.att)).as_rotvec()
    # the rate that dead reckoning takes, which agrees with the textbook's to 1e-9
    near(turned, 0.015 * oracle().rate)
    assert np.abs(turned).max() > 0.01


def test_blocks_cut_and_drop_the_remainder():
    numbers = np.arange(33.0).reshape(11, 3)
    cut = blocks(ImuSample(jnp.asarray(numbers), jnp.asarray(-numbers), jnp.asarray(numbers)), 4)
    for leaf, sign in zip(cut, (1, -1, 1), strict=True):
        assert leaf.shape == (2, 4, 3)
        np.testing.assert_array_equal(leaf.reshape(8, 3), sign * numbers[:8])
    assert blocks(ImuSample(jnp.asarray(numbers), jnp.asarray(numbers)), 4).mag is None
    assert blocks(ImuSample(jnp.zeros((3, 3)), jnp.zeros((3, 3))), 4).gyr.shape == (0, 4, 3)


def test_missing_accelerations_leave_everything_finite():
    """Rows, single numbers and a whole block, the first one included, whatever the start."""
    force, rate = record()
    gaps = force.copy()
    gaps[:LENGTH], gaps[60:90], gaps[200, 1] = np.nan, np.nan, np.nan
    for settings in ({}, {"q0": np.zeros(4)}):
        state, found = filtered(gaps, rate, **settings)
        for leaf in jax.tree.leaves((state, found)):
            assert np.isfinite(leaf).all()
        np.testing.assert_allclose(np.linalg.norm(found.att, axis=1), 1.0, rtol=1e-14)
        assert np.linalg.eigvalsh(state.P).min() > 0


def test_without_accelerations_it_is_the_gyroscopes_alone():
    """Nothing pushes then, so speed and place stay zero and correct nothing in motion."""
    rng = np.random.default_rng(7)
    rate = rng.normal(size=(N, 3))
    _, found = filtered(np.full((N, 3), np.nan), rate)
    attitude = START
    for w in rate:
        attitude = attitude * Rotation.from_rotvec(w * DT)
    assert not found.rest.any()
    # 240 products of quaternions
    assert (attitude.inv() * turns(found.att[-1])).magnitude() < 1e-12


@pytest.mark.parametrize("angle", [0.0, 40.0, -100.0, 179.0, 180.0])
def test_zeros_as_start_level_by_the_first_block(angle):
    truth = Rotation.from_rotvec(np.radians(angle) * np.array([1.0, 0.0, 0.0]))
    force, still = level_force(truth), np.zeros((N, 3))
    state, found = filtered(force, still, q0=np.zeros(4))
    up = turns(found.att).apply(force / GRAVITY)
    # the length of a sum of four, and of 240 quaternions that nothing turns
    near(up, np.tile([0.0, 0.0, 1.0], (N, 1)), atol=1e-12)
    near(state.at.place, 0.0, atol=1e-12)
    assert found.rest[-1]


def test_the_first_block_is_averaged():
    """The mean of its forces is level, not the first of them."""
    force = level_force(Rotation.identity())
    force[:LENGTH] += np.array([[2.0, 1, 0], [-1, 1, 0], [1, -3, 0], [-2, 1, 0]])
    _, found = filtered(force, np.zeros((N, 3)), q0=np.zeros(4))
    near(turns(found.att[:LENGTH]).magnitude(), 0.0, atol=1e-12)


def pushed():
    force = level_force(Rotation.identity())
    force[::2, 0] += 1.0
    force[1::2, 0] -= 1.0
    return force


@pytest.mark.parametrize(
    ("rate", "force", "resting"),
    [
        (0.03, level_force(Rotation.identity()), True),
        (0.1, level_force(Rotation.identity()), False),
        (0.0, pushed(), False),
    ],
    ids=["a bias", "a slow turn", "shaken"],
)
def test_rest_is_neither_a_steady_turn_nor_shaking(rate, force, resting):
    """What is steady and small is a bias; what is steady and larger a turn."""
    _, found = filtered(force, np.tile([0.0, 0.0, rate], (N, 1)))
    assert found.rest[-1] == resting
    # at rest it is measured to 5e-4 / sqrt(seconds)
    assert found.bias[-1, 2] == pytest.approx(rate if resting else 0.0, abs=2e-3)
