"""Errors of attitudes and of angles against SciPy's rotations and plain NumPy."""

from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

from objectives import AttitudeRmse, Data, angle_errors, attitude_error, masked, score
from tests.oracles import central_difference
from tests.strategies import seeds

N = 16
PARTS = ("total", "heading", "inclination")
every_part = pytest.mark.parametrize("part", PARTS)
errors = jax.jit(jax.vmap(attitude_error))
rmse = jax.jit(lambda part, q, truth: AttitudeRmse(part)(q, truth), static_argnums=0)
slope = jax.jit(jax.grad(lambda q, part, truth: AttitudeRmse(part)(q, truth)), static_argnums=1)
of_angles = jax.jit(angle_errors)


@dataclass(frozen=True)
class PassOn:
    """A filter whose outputs are its inputs."""

    def init(self, params):
        return None

    def step(self, params, state, inputs):
        return state, inputs


def stacked(turns):
    """Rotations as quaternions with the scalar first, as the project has them."""
    return turns.as_quat(scalar_first=True)


def drawn(rng, scale=np.pi):
    """N estimates that are a turn of about ``scale`` rad, about any axis, from N truths."""
    truth = Rotation.random(N, rng=rng)
    return Rotation.from_rotvec(scale * rng.uniform(-1, 1, (N, 3))) * truth, truth


# ------------------------------------------------------------------------------ one attitude


@given(rng=seeds())
def test_total_is_the_angle_between_them(rng):
    estimate, truth = drawn(rng)
    found = errors(stacked(estimate), stacked(truth)).total
    # entries of a quaternion are rounded at 1e-16, and a few of them enter an angle
    np.testing.assert_allclose(found, (estimate * truth.inv()).magnitude(), rtol=0, atol=2e-15)


@given(rng=seeds())
def test_inclination_is_the_angle_between_the_verticals(rng):
    """Of the sensor's up seen in the earth, whatever the headings; not by quaternions."""
    estimate, truth = drawn(rng)
    a, b = (turn.inv().apply([0.0, 0.0, 1.0]) for turn in (estimate, truth))
    angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
    found = errors(stacked(estimate), stacked(truth)).inclination
    np.testing.assert_allclose(found, angle, rtol=0, atol=1e-14)


@given(rng=seeds())
def test_heading_and_inclination_make_up_the_total(rng):
    """The turn is one about the vertical and one about a horizontal axis: the swing and twist."""
    estimate, truth = drawn(rng)
    found = errors(stacked(estimate), stacked(truth))
    product = np.cos(found.heading / 2) * np.cos(found.inclination / 2)
    np.testing.assert_allclose(product, np.cos(found.total / 2), rtol=0, atol=1e-14)
    # the twist alone, taken off, leaves no heading
    q = stacked(estimate * truth.inv())
    angle = 2 * np.arctan2(q[:, 3], q[:, 0])
    rest = Rotation.from_rotvec(angle[:, None] * [0.0, 0.0, -1.0]) * estimate
    left = errors(stacked(rest), stacked(truth))
    np.testing.assert_allclose(left.heading, 0.0, atol=1e-14)
    np.testing.assert_allclose(left.inclination, found.inclination, rtol=0, atol=1e-14)


@pytest.mark.parametrize("scale", [1e-9, 1e-4, 1.0])
def test_angles_equal_the_arc_cosines_of_the_source(scale):
    """With 40 digits, of which an arc cosine loses half near zero; the filters' form loses none."""
    estimate, truth = (stacked(turns) for turns in drawn(np.random.default_rng(2021), scale))
    found = errors(estimate, truth)
    with mpmath.workdps(40):
        for k in range(N):
            a, b, c, d = (mpmath.mpf(float(v)) for v in estimate[k])
            w, x, y, z = (mpmath.mpf(float(v)) for v in truth[k])
            e = [
                a * w + b * x + c * y + d * z,
                -a * x + b * w - c * z + d * y,
                -a * y + b * z + c * w - d * x,
                -a * z - b * y + c * x + d * w,
            ]
            size = mpmath.sqrt(sum(v**2 for v in e))  # 1 but for the rounding of the entries
            w, z = abs(e[0]) / size, abs(e[3]) / size
            expected = (
                2 * mpmath.acos(w),
                2 * mpmath.atan(z / w),
                2 * mpmath.acos(mpmath.sqrt(w**2 + z**2)),
            )
            # entries of order 1, rounded at 1e-16
            actual = [float(part[k]) for part in found]
            np.testing.assert_allclose(actual, [float(v) for v in expected], rtol=0, atol=1e-15)


def test_turns_about_the_vertical_are_heading_and_others_inclination():
    angles = np.linspace(-3.1, 3.1, N)
    truth = Rotation.random(N, rng=np.random.default_rng(5))
    about_z = Rotation.from_rotvec(angles[:, None] * [0.0, 0.0, 1.0])
    level = np.stack([np.cos(np.arange(N)), np.sin(np.arange(N)), np.zeros(N)], axis=1)
    about_level = Rotation.from_rotvec(angles[:, None] * level)
    for turn, heading, inclination in ((about_z, 1, 0), (about_level, 0, 1)):
        found = errors(stacked(turn * truth), stacked(truth))
        np.testing.assert_allclose(found.total, np.abs(angles), rtol=0, atol=1e-14)
        np.testing.assert_allclose(found.heading, heading * np.abs(angles), rtol=0, atol=1e-14)
        np.testing.assert_allclose(
            found.inclination, inclination * np.abs(angles), rtol=0, atol=1e-14
        )


@given(rng=seeds())
def test_a_quaternion_and_its_negative_are_one_attitude(rng):
    estimate, truth = (stacked(turns) for turns in drawn(rng))
    signs = rng.choice([-1.0, 1.0], (2, N, 1))
    for one, other in zip(
        errors(estimate, truth), errors(signs[0] * estimate, signs[1] * truth), strict=True
    ):
        np.testing.assert_array_equal(one, other)


# ---------------------------------------------------------------------------------- a record


@every_part
def test_rmse_is_the_root_mean_square_of_its_part_in_degrees(part):
    estimate, truth = drawn(np.random.default_rng(6))
    estimate, truth = stacked(estimate), stacked(truth)
    angles = np.degrees(getattr(errors(estimate, truth), part))
    expected = np.sqrt(np.mean(angles**2))
    assert float(rmse(part, estimate, truth)) == pytest.approx(expected, rel=1e-14)


def test_rmse_is_of_the_inclination_unless_told_otherwise():
    assert AttitudeRmse() == AttitudeRmse("inclination")


@every_part
def test_masked_samples_do_not_count(part):
    estimate, truth = (stacked(turns) for turns in drawn(np.random.default_rng(7)))
    counts = np.arange(N) % 3 != 0
    kept = masked(jnp.asarray(truth), jnp.asarray(counts))
    np.testing.assert_array_equal(np.isnan(kept).all(axis=1), ~counts)
    np.testing.assert_array_equal(kept[counts], truth[counts])
    angles = np.degrees(getattr(errors(estimate, truth), part))[counts]
    expected = np.sqrt(np.mean(angles**2))
    assert float(rmse(part, estimate, kept)) == pytest.approx(expected, rel=1e-14)
    # one NaN in a row is enough for it not to count
    kept = np.where(counts[:, None] | (np.arange(4) != 2), truth, np.nan)
    assert float(rmse(part, estimate, kept)) == pytest.approx(expected, rel=1e-14)
    assert np.isnan(rmse(part, estimate, np.full((N, 4), np.nan)))


def test_masked_takes_truths_of_any_shape():
    counts = jnp.array([True, False, True])
    for shape in ((3,), (3, 2, 2)):
        kept = np.asarray(masked(jnp.ones(shape), counts))
        assert np.isnan(kept[1]).all()
        np.testing.assert_array_equal(kept[::2], 1.0)


@every_part
def test_gradient_equals_central_differences_beside_masked_samples(part):
    estimate, truth = (stacked(turns) for turns in drawn(np.random.default_rng(8)))
    truth[::4] = np.nan
    difference = central_difference(
        lambda q: float(rmse(part, q.reshape(N, 4), truth)), estimate.ravel(), 1e-5
    )
    found = np.asarray(slope(jnp.asarray(estimate), part, jnp.asarray(truth)))
    np.testing.assert_array_equal(found[::4], 0.0)
    # h^2 = 1e-10 of truncation and eps/h = 2e-11 of rounding, on values of 100 deg
    np.testing.assert_allclose(found.ravel(), difference, rtol=1e-6, atol=1e-6)


@every_part
def test_gradient_is_finite_where_single_errors_are_zero(part):
    estimate, truth = (stacked(turns) for turns in drawn(np.random.default_rng(9)))
    estimate[:4] = truth[:4] = np.eye(4)[0]  # zero to the bit
    found = np.asarray(slope(jnp.asarray(estimate), part, jnp.asarray(truth)))
    assert np.isfinite(found).all()
    assert np.abs(found[4:]).max() > 0.1


@every_part
def test_gradient_is_finite_where_all_errors_are_zero(part):
    level = jnp.broadcast_to(jnp.eye(4)[0], (N, 4))
    assert float(rmse(part, level, level)) == 0.0
    assert np.isfinite(slope(level, part, level)).all()


class Outputs(NamedTuple):
    """Of a filter that has more to say than its attitude."""

    bias: np.ndarray
    att: np.ndarray


@every_part
def test_in_the_time_loop_it_is_the_same_number(part):
    estimate, truth = (stacked(turns) for turns in drawn(np.random.default_rng(10)))
    truth[::5] = np.nan
    whole = float(rmse(part, estimate, truth))
    # a filter that returns what it is given
    found = score(PassOn(), AttitudeRmse(part), None, Data(estimate, truth))
    # the order of the sum differs: N roundings
    assert float(found) == pytest.approx(whole, rel=1e-14)
    outputs = Outputs(np.zeros(N), estimate)
    assert float(AttitudeRmse(part)(outputs, truth)) == pytest.approx(whole, rel=1e-14)


@every_part
def test_records_side_by_side_are_one_long_record(part):
    estimate, truth = (stacked(turns) for turns in drawn(np.random.default_rng(11)))
    truth[5] = np.nan
    side = estimate.reshape(N // 2, 2, 4), truth.reshape(N // 2, 2, 4)
    whole = float(rmse(part, estimate, truth))
    assert float(AttitudeRmse(part)(*side)) == pytest.approx(whole, rel=1e-14)
    found = score(PassOn(), AttitudeRmse(part), None, Data(*side))
    assert float(found) == pytest.approx(whole, rel=1e-14)


def test_outputs_without_an_attitude_are_refused():
    class Biases(NamedTuple):
        bias: np.ndarray

    with pytest.raises(ValueError, match="^Biases has no att, the attitude as a quaternion; score"):
        AttitudeRmse()(Biases(np.zeros((N, 3))), np.zeros((N, 4)))


# ------------------------------------------------------------------------------ single angles


@given(rng=seeds())
def test_angle_errors_equal_numpy(rng):
    estimates, truth = rng.normal(size=(2, N, 2))
    truth[rng.uniform(size=(N, 2)) < 0.3] = np.nan
    truth[0] = 0.0
    error = np.degrees(estimates - truth)
    S, M = of_angles(estimates, truth)
    np.testing.assert_allclose(S, np.nanmean(error**2, axis=0), rtol=1e-13)
    np.testing.assert_allclose(M, np.nanmax(np.abs(error), axis=0), rtol=1e-13)
