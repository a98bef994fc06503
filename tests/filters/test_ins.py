"""The error-state INS against a loop in NumPy and against what a simulated flight hides."""

from dataclasses import replace
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from filters import ErrorStateIns, InsNoise, InsSample, Timed, TimedSample, parameter_facts, run
from filters.ins_aiding import AIDS
from tests.filters.ins_flight import G, flight, recorded

TYPICAL = {name: fact.typical for name, fact in parameter_facts(ErrorStateIns).items()}
NOISE = TYPICAL | {"q_gyr": 1e-5, "q_gyr_bias": 1e-8, "q_acc_bias": 1e-5}
NOISE |= {"tilt0": 0.005, "heading0": 0.03}
"""Noisier than usual, so that biases move within half a minute; a start that is nearly linear: 0.2
rad of heading times a velocity not yet known would be no small error of the speed."""
FILTER = ErrorStateIns(flight().dt)
compiled = jax.jit(run, static_argnums=0)


def params(values, dtype=float):
    return InsNoise(**{name: jnp.asarray(values[name], dtype) for name in InsNoise._fields})


def sample(recording, dtype=float):
    return jax.tree.map(lambda leaf: jnp.asarray(leaf, dtype), recording)


# An oracle that knows the equations only: its Jacobians are differences of them.


def moved(x, gyr, acc, dt, g):
    """The equations of motion; x is (attitude, gyroscope bias, accelerometer bias, v, p)."""
    q, bg, ba, v, p = x
    half = Rotation.from_rotvec((gyr - bg) * dt / 2)
    ahead = v + ((q * half).apply(acc - ba) - g) * dt
    return (q * half * half, bg, ba, ahead, p + (v + ahead) * dt / 2)


def plus(x, e):
    """The state with an error, ``(15,)``, or with each of several, ``(n, 15)``."""
    turned = Rotation.from_rotvec(e[..., :3]) * x[0]
    return (turned, *(part + e[..., 3 * i : 3 * i + 3] for i, part in enumerate(x[1:], start=1)))


def minus(x, y):
    turn = (x[0] * y[0].inv()).as_rotvec()
    return np.concatenate([turn, *(a - b for a, b in zip(x[1:], y[1:], strict=True))], axis=-1)


def derivative(function, h=1e-3):
    """By the 15 errors: central differences of the fourth order, wrong by about h^4 = 1e-12."""
    e = h * np.eye(15)
    near, far = function(e) - function(-e), function(2 * e) - function(-2 * e)
    return ((8 * near - far) / (12 * h)).T


def expected(x, mag, up, north):
    """What every number in the order of AIDS should be; the field's direction less itself."""
    q, _, _, v, p = x
    level = q.apply(mag)
    field = north - np.arctan2(level[..., 1], level[..., 0])
    height, speed = up * up * p[..., 2:], q.inv().apply(v)[..., :1]
    return np.concatenate([p, v, height, speed, -field[..., None], v], axis=-1)


def loop(recording, n, dt):
    """The whole filter in the textbook's form: a solve for all numbers of a sample, Joseph's P."""
    g = np.array([0.0, 0.0, n["gravity"]])
    start = [n["tilt0"], n["tilt0"], n["heading0"]]
    for name in ("gyr_bias0", "acc_bias0", "velocity0", "position0"):
        start += 3 * [n[name]]
    P, fixed, x = np.diag(np.square(start)), np.zeros(3, bool), None
    names = ["R_gps", "R_gps", "R_gps_up", *3 * ["R_gps_vel"], "R_baro", "R_speed", "R_mag"]
    R = np.array([n[name] for name in [*names, *3 * ["R_still"]]])
    gyr, acc, found = np.zeros(3), np.zeros(3), []
    north = np.pi / 2 - n["declination"]
    for k in range(len(recording.gyr)):
        gyr = np.where(np.isnan(recording.gyr[k]), gyr, recording.gyr[k])
        acc = np.where(np.isnan(recording.acc[k]), acc, recording.acc[k])
        mag = recording.mag[k]
        if x is None:
            if np.isnan(recording.acc[k]).any():
                continue
            shortest, _ = Rotation.align_vectors([0, 0, 1], acc)
            turn = np.pi / 2 - n["heading"]
            if not np.isnan(mag).any():
                level = shortest.apply(mag)
                turn = north - np.arctan2(level[1], level[0])
            q = Rotation.from_rotvec([0, 0, turn]) * shortest
            x, mag = (q, *np.zeros((4, 3))), np.full(3, np.nan)
        else:
            before, rate, force = x, gyr, acc

            def ahead(e, before=before, rate=rate, force=force):
                at = moved(before, rate, force, dt, g)
                return minus(moved(plus(before, e), rate, force, dt, g), at)

            F = derivative(ahead)
            W = np.zeros((15, 15))
            for block, q in ((0, "q_gyr"), (3, "q_gyr_bias"), (6, "q_acc_bias"), (9, "q_acc")):
                W[block : block + 3, block : block + 3] = n[q] * dt * np.eye(3)
            W[12:, 12:] = n["q_acc"] * dt**3 / 3 * np.eye(3)
            W[9:12, 12:] = W[12:, 9:12] = n["q_acc"] * dt**2 / 2 * np.eye(3)
            P, x = F @ P @ F.T + W, moved(before, gyr, acc, dt, g)
        gps = recording.gps[k].copy()
        for i in np.flatnonzero(~fixed & ~np.isnan(gps)):
            p = x[4].copy()
            p[i] = gps[i]
            x, fixed[i], gps[i] = (*x[:4], p), True, np.nan
            P[12 + i] = P[:, 12 + i] = 0.0
            P[12 + i, 12 + i] = R[i]
        still = np.zeros(3) if recording.still[k] == 1 else np.full(3, np.nan)
        seen = 0.0 if not np.isnan(mag).any() else np.nan
        z = np.array([*gps, *recording.gps_vel[k], recording.baro[k], recording.speed[k]])
        z = np.concatenate([z, [seen], still])
        at = x
        field = np.nan_to_num(mag, nan=1.0)
        H = derivative(lambda e, at=at, field=field: expected(plus(at, e), field, 1.0, north))
        y = z - expected(x, field, 1.0, north)
        y[8] = np.angle(np.exp(1j * y[8]))
        there = ~np.isnan(y)
        H, y, S = H[there], y[there], np.diag(R[there])
        K = np.linalg.solve(H @ P @ H.T + S, H @ P).T
        nis = y @ np.linalg.solve(H @ P @ H.T + S, y) if len(y) else 0.0
        keep = np.eye(15) - K @ H
        P, x = keep @ P @ keep.T + K @ S @ K.T, plus(x, K @ y)
        found.append((x[0].as_quat(scalar_first=True), *x[1:], P.copy(), nis))
    return [np.array(part) for part in zip(*found, strict=True)]


N = 300


def holed(seed):
    """Everything missing at times: the start of the forces, rates, parts of fixes, the field.

    So it is for N samples. The others make it as long as the recordings of the other tests, with
    which it shares a compilation.
    """
    rng = np.random.default_rng(seed)
    recording, truth = recorded(rng, NOISE)
    recording = InsSample(*(np.array(part) for part in recording))
    recording.acc[:2, 1] = np.nan
    recording.gyr[:N][rng.random(N) < 0.1, 0] = np.nan
    recording.acc[10 + np.flatnonzero(rng.random(N - 10) < 0.1)] = np.nan
    recording.gps[11, 2] = np.nan
    recording.gps[1, 2] = np.nan
    recording.still[100:104] = 1.0
    return recording, truth


def test_equals_a_loop_of_its_equations():
    recording, truth = holed(1)
    n = NOISE | {"heading": truth.heading, "declination": 0.1, "heading0": 0.4}
    q, bg, ba, v, p, P, nis = loop(InsSample(*(part[:N] for part in recording)), n, FILTER.dt)
    out = compiled(FILTER, params(n), sample(recording))[1]
    out = jax.tree.map(lambda leaf: np.asarray(leaf)[:N], out)
    late = slice(len(out.att) - len(q), None)
    assert len(out.att) - len(q) == 2
    np.testing.assert_array_equal(out.att[:2, 1:3], 0.0)  # level, as long as nothing is known
    sign = np.sign((out.att[late] * q).sum(axis=1))[:, None]
    # Differences leave 1e-12 in each Jacobian; 300 samples and gains of order one.
    np.testing.assert_allclose(out.att[late] * sign, q, rtol=0, atol=1e-9)
    for one, other in ((out.gyr_bias, bg), (out.acc_bias, ba), (out.velocity, v)):
        np.testing.assert_allclose(one[late], other, rtol=0, atol=1e-8)
    np.testing.assert_allclose(out.position[late], p, rtol=0, atol=1e-8)
    size = np.sqrt(np.einsum("nii->ni", P))
    scaled = (out.P[late] - P) / (size[:, :, None] * size[:, None, :])
    np.testing.assert_allclose(scaled, 0.0, rtol=0, atol=1e-8)
    # One number after another or all at once: the same sum of squares.
    squares = np.where(out.variance > 0, out.innovation**2 / (out.variance + 1e-300), 0.0)
    np.testing.assert_allclose(squares.sum(axis=1)[late], nis, rtol=1e-7, atol=1e-9)


def errors(out, truth):
    """True less estimated, in the filter's states, ``(N, 15)``."""
    estimated = Rotation.from_quat(out.att, scalar_first=True)
    parts = [
        (truth.attitude * estimated.inv()).as_rotvec(),
        truth.gyr_bias - out.gyr_bias,
        truth.acc_bias - out.acc_bias,
        truth.velocity - out.velocity,
        truth.position - out.position,
    ]
    return np.hstack(parts)


RUNS = 40
QUIET = NOISE | {
    name: value * (0.04 if name[0] in "qR" else 0.2)
    for name, value in NOISE.items()
    if name[0] in "qR" or name.endswith("0")
}
"""A fifth of all deviations: as noisy as above the linearisation costs 4 % of consistency, as noisy
as this 0.2 %; the limits below are 11 % wide."""
several = jax.jit(jax.vmap(lambda p, s: run(FILTER, p, s)[1]))


@cache
def flights():
    """Recordings and truths of all runs."""
    return [recorded(np.random.default_rng(seed), QUIET) for seed in range(RUNS)]


def monte_carlo(believed):
    """NEES of all states at every sample of every run, ``(RUNS, N)``, and NIS with its count."""
    made = flights()
    lanes = jax.tree.map(lambda *parts: jnp.stack(parts), *(sample(each) for each, _ in made))
    values = [params(believed | {"heading": truth.heading}) for _, truth in made]
    given = jax.tree.map(lambda *parts: jnp.stack(parts), *values)
    out = jax.tree.map(np.asarray, several(given, lanes))
    one = [jax.tree.map(lambda leaf, i=i: leaf[i], out) for i in range(RUNS)]
    e = np.stack([errors(each, truth) for each, (_, truth) in zip(one, made, strict=True)])
    nees = np.einsum("rni,rni->rn", e, np.linalg.solve(out.P, e[..., None])[..., 0])
    seen = out.variance > 0
    return nees, (out.innovation[seen] ** 2 / out.variance[seen]).sum(), seen.sum()


def within(total, degrees):
    low, high = chi2.ppf([0.025, 0.975], degrees)
    return low <= total <= high


def test_nees_and_nis_lie_within_their_intervals():
    nees, nis, count = monte_carlo(QUIET)
    inside = [within(column.sum(), 15 * RUNS) for column in nees.T]
    assert not inside[0]  # The flights begin 100 m from where the filter does, till the first fix.
    assert np.mean(inside[1:]) > 0.9  # of 95 % on average, and errors last
    assert inside[-1]
    assert within(nis, count)


@pytest.mark.parametrize("name", ["q_acc", "R_gps", "R_mag"])
def test_nis_tells_a_wrong_noise(name):
    _, nis, count = monte_carlo(QUIET | {name: 4 * QUIET[name]})
    assert not within(nis, count)


def test_north_east_down_is_the_same_filter():
    recording, truth = recorded(np.random.default_rng(3), NOISE)
    body, earth = np.diag([1.0, -1, -1]), np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
    turned = recording._replace(
        gyr=recording.gyr @ body,
        acc=recording.acc @ body,
        mag=recording.mag @ body,
        gps=recording.gps @ earth,
        gps_vel=recording.gps_vel @ earth,
    )
    given = params(NOISE | {"heading": truth.heading, "declination": 0.2})
    enu = compiled(FILTER, given, sample(recording))[1]
    ned = compiled(replace(FILTER, frame="ned"), given, sample(turned))[1]
    # The same sums with other signs, over 600 samples.
    close = {"rtol": 0, "atol": 1e-9}
    np.testing.assert_allclose(ned.position @ earth, enu.position, **close)
    np.testing.assert_allclose(ned.velocity @ earth, enu.velocity, **close)
    np.testing.assert_allclose(ned.gyr_bias @ body, enu.gyr_bias, **close)
    R_ned, R_enu = (
        Rotation.from_quat(np.asarray(out.att), scalar_first=True).as_matrix() for out in (ned, enu)
    )
    np.testing.assert_allclose(earth.T @ R_ned @ body, R_enu, **close)
    np.testing.assert_allclose(
        np.abs(ned.innovation[:, 6:9]), np.abs(enu.innovation[:, 6:9]), **close
    )


def test_the_magnetometer_or_the_parameter_gives_the_heading():
    """A sensor level in ned whose x axis points to compass 60 deg, by a field 10 deg east."""
    at_rest = np.tile([0.0, 0.0, -G], (5, 1))
    north = Rotation.from_euler("Z", 60, degrees=True).inv()
    field = north.apply([np.cos(np.radians(10)), np.sin(np.radians(10)), 2.0])
    filter = ErrorStateIns(0.1, "ned")
    given = params(TYPICAL | {"declination": np.radians(10.0), "heading": np.radians(60.0)})
    for mag in (np.tile(field, (5, 1)), None, np.full((5, 3), np.nan)):
        aid = None if mag is None else jnp.asarray(mag)
        out = run(filter, given, InsSample(jnp.zeros((5, 3)), jnp.asarray(at_rest), mag=aid))[1]
        yaw = Rotation.from_quat(np.asarray(out.att[-1]), scalar_first=True).as_euler("ZYX")[0]
        assert np.degrees(yaw) == pytest.approx(60.0, abs=1e-9)


def test_a_channel_without_samples_is_as_none():
    recording, truth = recorded(np.random.default_rng(4), NOISE)
    given = params(NOISE | {"heading": truth.heading})
    empty = {name: np.full_like(getattr(recording, name), np.nan) for name in ("speed", "mag")}
    silent = recording._replace(**empty, still=np.zeros(len(recording.gyr)))
    none = recording._replace(speed=None, mag=None, still=None)
    one, other = (compiled(FILTER, given, sample(each))[1] for each in (silent, none))
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-12)  # fused in another order


def test_standing_still_says_so():
    """Velocity stays below what R_still says, and the biases show, where without they do not."""
    N, bias = 400, np.array([0.002, -0.003, 0.001])
    still = InsSample(jnp.tile(bias, (N, 1)), jnp.tile(jnp.array([0.0, 0.0, G]), (N, 1)))
    given = params(TYPICAL | {"tilt0": 1e-3})
    flagged = run(ErrorStateIns(0.05), given, still._replace(still=jnp.ones(N)))[1]
    free = run(ErrorStateIns(0.05), given, still)[1]
    assert np.abs(flagged.velocity[-1]).max() < 0.01 < np.abs(free.velocity[-1]).max()
    np.testing.assert_allclose(flagged.gyr_bias[-1, :2], bias[:2], atol=3e-4)
    np.testing.assert_array_equal(free.gyr_bias, 0.0)


def test_innovations_are_0_where_nothing_is_measured_and_a_first_fix_is_no_surprise():
    recording, _ = recorded(np.random.default_rng(5), NOISE)
    out = compiled(FILTER, params(NOISE), sample(recording))[1]
    columns = [recording.gps, recording.gps_vel, recording.baro[:, None], recording.speed[:, None]]
    seen = ~np.isnan(np.hstack([*columns, recording.mag[:, :1], np.full((600, 3), np.nan)]))
    assert seen.shape[1] == len(AIDS)
    assert seen[1, :3].all()
    seen[1, :3] = False  # it begins the position
    np.testing.assert_array_equal(np.asarray(out.variance) > 0, seen)
    np.testing.assert_array_equal(np.asarray(out.innovation) != 0, seen)
    np.testing.assert_array_equal(out.P[1, 12:, :12], 0.0)


def test_without_gps_a_first_height_begins_the_height():
    recording, _ = recorded(np.random.default_rng(7), NOISE)
    inputs = sample(recording)._replace(gps=None)
    out, high = (
        compiled(FILTER, params(NOISE), inputs._replace(baro=inputs.baro + more))[1]
        for more in (0.0, 500.0)
    )
    first = int(np.flatnonzero(~np.isnan(recording.baro[1:]))[0]) + 1
    assert out.variance[first, AIDS.index("baro")] == 0
    # Above sea level or above the ground: nothing but the height differs, to the digits of 500 m.
    for one, other in zip(out, high, strict=True):
        if one is not out.position:
            np.testing.assert_allclose(one, other, rtol=0, atol=1e-8)
    np.testing.assert_allclose(high.position[first:, 2] - out.position[first:, 2], 500, atol=1e-8)


def test_single_precision_and_varying_sample_times():
    recording, truth = recorded(np.random.default_rng(6), NOISE)
    n = NOISE | {"heading": truth.heading}
    double = compiled(FILTER, params(n), sample(recording))[1]
    single = compiled(FILTER, params(n, np.float32), sample(recording, np.float32))[1]
    assert {leaf.dtype for leaf in single} == {np.dtype("float32")}
    # 600 samples at 1e-7 of 100 m and more.
    np.testing.assert_allclose(single.position, double.position, rtol=0, atol=5e-3)
    times = TimedSample(jnp.full(600, FILTER.dt), sample(recording))
    timed = compiled(Timed(ErrorStateIns(9.0)), params(n), times)[1]
    np.testing.assert_allclose(timed.att, double.att, rtol=0, atol=1e-11)
