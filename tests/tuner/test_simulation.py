"""Simulated motion: its parts agree with each other, and its sensors have the errors they say."""

from functools import cache

import numpy as np
import pytest
import scipy.stats
from scipy.spatial.transform import Rotation

from tuner.data.simulation import GRAVITY, Bursts, Sensor, Swing, even_normals, measure, simulate

SWING = Swing(size=(0.4, 0.3, 1.0))
STILL = Swing(size=(0.0, 0.0, 0.0))


@cache
def motion():
    return simulate(seconds=20.0, dt=0.01, seed=3, swing=SWING, bursts=Bursts(4, 3.0))


@cache
def still(seed=3):
    return simulate(
        seconds=40.0, dt=0.01, seed=seed, swing=STILL, bursts=Bursts(6, 3.0, seconds=2.5)
    )


def turns(q):
    return Rotation.from_quat(q, scalar_first=True)


def external(found):
    """Acceleration in the earth, m/s^2."""
    return turns(found.q).apply(np.array(found.force)) - [0.0, 0.0, GRAVITY]


# ------------------------------------------------------------------------------------ motion


def test_shapes_and_a_start_from_rest():
    found = motion()
    assert found.dt == 0.01
    assert [len(part) for part in found[1:]] == [2000] * 5
    assert found.disturbed.dtype == bool
    np.testing.assert_array_equal(found.angles[0], 0.0)
    np.testing.assert_allclose(found.rate[0], 0.0, atol=1e-15)
    np.testing.assert_allclose(found.q[0], [1.0, 0.0, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(found.q, axis=1), 1.0, rtol=1e-14)


def test_attitude_is_yaw_pitch_roll_of_aeronautics():
    """z-y'-x'' between axes forward, right, down and north, east, down; ours turn z up."""
    found = motion()
    flip = Rotation.from_rotvec([np.pi, 0.0, 0.0])
    aeronautic = flip * turns(found.q) * flip.inv()
    expected = Rotation.from_euler("ZYX", found.angles[:, ::-1])
    assert (aeronautic * expected.inv()).magnitude().max() < 1e-14
    assert np.abs(found.angles).max(axis=0) == pytest.approx([1.0, 0.8, 2.5], rel=0.5)


def test_rates_integrate_back_to_the_attitude():
    """Steps over two samples by the rate between them; the error of order dt^2 is 4e-5 rad."""
    found = motion()
    step = 2 * found.dt
    q = turns(found.q[0])
    worst = 0.0
    for k in range(1, len(found.q) - 1, 2):
        q = q * Rotation.from_rotvec(step * found.rate[k])
        worst = max(worst, (q.inv() * turns(found.q[k + 1])).magnitude())
    assert worst < 1e-4


def test_angles_have_the_size_they_are_asked_for():
    """Over many periods of the slowest sine, and over the samples after the start."""
    found = simulate(seconds=2000.0, dt=0.1, seed=1, swing=SWING)
    deviation = found.angles[len(found.angles) // 5 :].std(axis=0)
    np.testing.assert_allclose(deviation, SWING.size, rtol=0.03)  # beats of close frequencies


def test_force_at_rest_is_gravity_in_the_papers_polarity():
    found = motion()
    phi, theta, _ = found.angles.T
    expected = GRAVITY * np.stack(
        [np.sin(theta), np.sin(phi) * np.cos(theta), np.cos(phi) * np.cos(theta)], axis=1
    )
    rest = ~found.disturbed
    assert 0.4 < rest.mean() < 0.9
    np.testing.assert_allclose(found.force[rest], expected[rest], rtol=0, atol=1e-13)
    apart = np.abs(found.force - expected).max(axis=1)
    assert apart[found.disturbed].min() > 0
    np.testing.assert_allclose(external(found)[rest], 0.0, atol=1e-13)


def test_no_bursts_no_disturbance():
    found = simulate(seconds=5.0, dt=0.05, seed=3, swing=SWING)
    assert not found.disturbed.any()
    np.testing.assert_allclose(np.linalg.norm(found.force, axis=1), GRAVITY, rtol=1e-14)


@pytest.mark.parametrize("seed", [3, 4])
def test_bursts_leave_no_speed(seed):
    """A whole sine over a whole number of samples sums to zero, at whatever phase."""
    acceleration = external(still(seed))
    speed = 0.01 * acceleration.cumsum(axis=0)
    assert np.abs(speed).max() > 0.3
    np.testing.assert_allclose(speed[-1], 0.0, atol=1e-12)
    np.testing.assert_array_equal(still(seed).disturbed, np.abs(acceleration).max(axis=1) > 1e-9)


def test_bursts_are_as_large_and_point_where_they_are_told():
    alone = [
        simulate(
            seconds=5.0, dt=0.01, seed=seed, swing=STILL, bursts=Bursts(1, 3.0, axes=(1, 0.5, 0))
        )
        for seed in range(30)
    ]
    peaks = np.array([np.linalg.norm(external(found), axis=1).max() for found in alone])
    assert 0.6 - 1e-3 < peaks.min() < 1.0  # a fifth; its peak may lie between two samples
    assert 2.5 < peaks.max() <= 3.0
    directions = np.array([np.abs(external(found)).max(axis=0) for found in alone])
    np.testing.assert_allclose(directions[:, 2], 0.0, atol=1e-13)
    assert directions[:, 0].sum() > directions[:, 1].sum() > 0
    # one burst lasts 2 s
    np.testing.assert_allclose([0.01 * f.disturbed.sum() for f in alone], 2.0, atol=0.011)


# ----------------------------------------------------------------------------------- numbers


def same(one, other):
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True) if a is not None)


def test_same_seed_same_numbers():
    def made(seed, noise_seed):
        found = simulate(seconds=3.0, dt=0.05, seed=seed, swing=SWING, bursts=Bursts(1, 2.0))
        sensor = Sensor(0.1, (0.1, 0.2, 0.3), 0.05)
        return found, measure(found, gyroscope=sensor, accelerometer=sensor, seed=noise_seed)

    (found, sample), (again, repeated) = made(1, 2), made(1, 2)
    assert same(found, again)
    assert same(sample[:2], repeated[:2])
    other, _ = made(5, 2)
    assert not np.array_equal(found.angles, other.angles)
    assert not np.array_equal(found.force, other.force)
    twin, noisy = made(1, 3)
    assert same(found, twin)
    for one, two in zip(sample[:2], noisy[:2], strict=True):
        assert np.abs(np.asarray(one) - np.asarray(two)).min() > 0


# ----------------------------------------------------------------------------------- sensors


def test_perfect_sensors_measure_the_truth():
    sample = measure(motion(), gyroscope=Sensor(), accelerometer=Sensor(), seed=1)
    np.testing.assert_array_equal(sample.gyr, motion().rate)
    np.testing.assert_array_equal(sample.acc, motion().force)
    assert sample.mag is None


def test_noise_and_bias_are_as_large_as_they_say_and_the_two_sensors_independent():
    found = motion()
    gyroscope = Sensor(0.02, (0.1, -0.2, 0.3))
    accelerometer = Sensor(0.5, (1.0, 2.0, -3.0))
    sample = measure(found, gyroscope=gyroscope, accelerometer=accelerometer, seed=7)
    errors = [np.asarray(sample.gyr) - found.rate, np.asarray(sample.acc) - found.force]
    for error, sensor in zip(errors, (gyroscope, accelerometer), strict=True):
        # 2000 samples: a deviation is known to 1/sqrt(4000) = 1.6 %, a mean to noise/45
        np.testing.assert_allclose(error.std(axis=0), sensor.noise, rtol=0.06)
        np.testing.assert_allclose(error.mean(axis=0), sensor.bias, atol=4 * sensor.noise / 45)
    correlation = np.corrcoef(np.hstack(errors).T)
    # of 2000 independent samples: 0.022 is one deviation
    assert np.abs(correlation - np.eye(6)).max() < 0.09


@pytest.mark.parametrize("dt", [0.01, 0.1])
def test_walk_reaches_its_deviation_after_one_second(dt):
    """And half of it after a quarter; of 1500 walks, whose deviation is known to 1.8 %."""
    start = np.zeros((round(1 / dt), 3))
    walks = np.array([Sensor(walk=0.3).measure(start, dt, seed) for seed in range(500)])
    assert walks[:, -1].std() == pytest.approx(0.3, rel=0.06)
    after = round(0.25 / dt)
    expected = 0.3 * np.sqrt(after * dt)
    assert walks[:, after - 1].std() == pytest.approx(expected, rel=0.06)


# ----------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("seconds", "dt"),
    [
        (0.0, 0.01),
        (-1.0, 0.01),
        (1.0, 0.0),
        (1.0, -0.1),
        (0.1, 0.2),
        (np.nan, 0.01),
        (1.0, np.nan),
        (np.inf, 0.01),
        (np.inf, np.inf),
    ],
)
def test_times_that_are_none(seconds, dt):
    with pytest.raises(ValueError, match=r"s in steps of .* is not a motion; give positive times"):
        simulate(seconds=seconds, dt=dt, seed=0, swing=STILL)


def test_one_sample_is_a_motion():
    found = simulate(seconds=0.1, dt=0.1, seed=0, swing=SWING)
    np.testing.assert_array_equal(found.angles, np.zeros((1, 3)))
    np.testing.assert_allclose(found.force, [[0.0, 0.0, GRAVITY]])


def test_pitch_near_the_vertical():
    with pytest.raises(ValueError, match=r"pitch reaches \d+ deg, where roll and yaw are one"):
        simulate(seconds=60.0, dt=0.1, seed=0, swing=Swing(size=(0.1, 1.2, 0.1)))


def test_swing_that_is_no_number():
    with pytest.raises(ValueError, match="swing"):
        simulate(seconds=5.0, dt=0.1, seed=0, swing=Swing(size=(0.1, np.nan, 0.1)))


@pytest.mark.parametrize("count", [7, 100])
def test_even_normals_are_normal_and_their_mean_squares_exact(count):
    drawn = np.stack([even_normals(count, 6, seed) for seed in range(50)])
    np.testing.assert_allclose(drawn.mean(axis=1), 0.0, atol=1e-12)
    squares = np.einsum("rci,rcj->rij", drawn, drawn) / count
    np.testing.assert_allclose(squares, np.broadcast_to(np.eye(6), squares.shape), atol=1e-12)
    assert len(np.unique(drawn[:, 0, 0])) == 50


def test_even_normals_have_the_distribution():
    """Each quantile of a hypercube holds one; many that were turned are still as good."""
    few = np.array([even_normals(5, 6, seed) for seed in range(20)])
    ranks = np.floor(5 * scipy.stats.norm.cdf(few))
    np.testing.assert_array_equal(np.sort(ranks, axis=1)[..., 0], np.tile(np.arange(5), (20, 1)))
    many = even_normals(2000, 2, 0)
    assert scipy.stats.kstest(many[:, 0], "norm").statistic < 0.01


def test_turn_on_bias_is_drawn_anew_and_changes_nothing_else():
    still, draws = np.zeros((3, 3)), []
    for seed in range(500):
        plain = Sensor(noise=0.1, walk=0.3).measure(still, 0.1, seed)
        found = Sensor(noise=0.1, walk=0.3, turn_on=2.0).measure(still, 0.1, seed) - plain
        # the same in every sample, but for the rounding of a sum near 1
        np.testing.assert_allclose(found, np.tile(found[0], (3, 1)), rtol=0, atol=1e-14)
        draws.append(found[0])
    # 1500 normal numbers: their deviation is known to 1.8 %
    assert np.std(draws) == pytest.approx(2.0, rel=0.06)
