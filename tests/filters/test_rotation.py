"""Quaternions against SciPy's rotations, which have the scalar last unless told otherwise."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from filters.rotation import (
    conjugate,
    cross,
    from_rotation_vector,
    level,
    multiply,
    normalise,
    rotate,
    rotate_back,
)
from tests.strategies import seeds

SAME = 1e-15  # a few products of numbers of order 1
times, turned, turned_back, crossed, turning, levelled, slope = (
    jax.jit(function)
    for function in (
        multiply,
        rotate,
        rotate_back,
        cross,
        from_rotation_vector,
        level,
        jax.jacfwd(from_rotation_vector),
    )
)
backwards = jax.jit(jax.jacrev(from_rotation_vector))


def q(rotation):
    return rotation.as_quat(scalar_first=True)


@given(rng=seeds())
def test_product_is_scipys(rng):
    a, b = Rotation.random(2, rng=rng)
    found, expected = times(q(a), q(b)), q(a * b)
    np.testing.assert_allclose(found * np.sign(found @ expected), expected, rtol=0, atol=SAME)
    # as an algebra too: no unit length is taken for granted
    np.testing.assert_allclose(times(2 * q(a), -3 * q(b)), -6 * found, rtol=0, atol=6 * SAME)


@given(rng=seeds())
def test_vectors_turn_as_scipys_do(rng):
    turn, v = Rotation.random(rng=rng), rng.normal(size=3)
    atol = 3 * SAME * np.abs(v).max()
    np.testing.assert_allclose(turned(q(turn), v), turn.apply(v), rtol=0, atol=atol)
    np.testing.assert_allclose(turned_back(q(turn), v), turn.inv().apply(v), rtol=0, atol=atol)
    there = turned_back(q(turn), turned(q(turn), v))
    np.testing.assert_allclose(there, v, rtol=0, atol=atol)


@given(rng=seeds())
def test_conjugate_is_the_inverse_and_cross_is_numpys(rng):
    a = Rotation.random(rng=rng)
    found = times(q(a), conjugate(jnp.asarray(q(a))))
    np.testing.assert_allclose(found, [1.0, 0.0, 0.0, 0.0], rtol=0, atol=SAME)
    u, v = rng.normal(size=(2, 3))
    np.testing.assert_allclose(crossed(u, v), np.cross(u, v), rtol=0, atol=1e-15 * 10)


def test_normalise():
    v = jnp.array([3.0, 0.0, -4.0, 0.0])
    np.testing.assert_allclose(normalise(v), [0.6, 0.0, -0.8, 0.0], rtol=1e-15)


@given(rng=seeds(), angle=st.sampled_from([1e-12, 1e-6, 1e-3, 0.00999, 0.0101, 1.0, np.pi, 6.0]))
def test_rotation_vector_is_scipys(rng, angle):
    """On both sides of the angle of 0.01 rad where series end."""
    axis = rng.normal(size=3)
    v = angle * axis / np.linalg.norm(axis)
    found = np.asarray(turning(v))
    half = np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * v / angle])
    np.testing.assert_allclose(found, half, rtol=0, atol=SAME)
    np.testing.assert_allclose(found[1:], half[1:], rtol=1e-14)  # small ones keep their digits
    expected = q(Rotation.from_rotvec(v))  # with the one or the other sign
    np.testing.assert_allclose(found * np.sign(found @ expected), expected, rtol=0, atol=SAME)
    assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("derivative", [slope, backwards])
def test_slope_of_the_rotation_vector_at_zero(derivative):
    expected = np.vstack([np.zeros((1, 3)), np.eye(3) / 2])
    np.testing.assert_array_equal(derivative(jnp.zeros(3)), expected)


@pytest.mark.parametrize("angle", [1e-12, 1e-3, 0.00999, 0.0101, np.pi])
def test_slope_of_the_rotation_vector(angle):
    """d cos(a/2) = -sin(a/2)/2 n' and d (sin(a/2) n) = cos(a/2)/2 n n' + sin(a/2)/a (I - n n')."""
    n = np.array([2.0, -1.0, 2.0]) / 3
    sine, cosine, along = np.sin(angle / 2), np.cos(angle / 2), np.outer(n, n)
    expected = np.vstack([-sine / 2 * n, cosine / 2 * along + sine / angle * (np.eye(3) - along)])
    for derivative in (slope, backwards):
        found = derivative(jnp.asarray(angle * n))
        # the series' derivative ends at a^5 / 1e4, 1e-14 at 0.01 rad
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)


def check_level(a, atol):
    found = np.asarray(levelled(a))
    assert np.linalg.norm(found) == pytest.approx(1.0, abs=atol)
    np.testing.assert_allclose(
        turned(found, a), [0.0, 0.0, np.linalg.norm(a)], rtol=0, atol=atol * np.linalg.norm(a)
    )
    assert found[3] == 0.0  # the turn's axis is horizontal
    return found


@given(rng=seeds(), size=st.sampled_from([1e-3, 1.0, 9.81]))
def test_level_turns_the_acceleration_upright(rng, size):
    a = rng.normal(size=3)
    a *= size / np.linalg.norm(a)
    # 1 + z loses digits near the vertical below: none of these is within 0.01 of it
    found = check_level(a, 1e-13)
    # the shortest turn is by the angle to the vertical
    assert 2 * np.arccos(found[0]) == pytest.approx(np.arccos(a[2] / size), abs=1e-7)


@pytest.mark.parametrize(
    "a", [[0, 0, 9.81], [0, 0, -9.81], [9.81, 0, 0], [0, -9.81, 0], [3.0, 4.0, 0.0]], ids=str
)
def test_level_at_corners(a):
    check_level(np.array(a, float), 1e-15)


def test_level_upside_down_is_half_a_turn_about_x():
    np.testing.assert_array_equal(levelled(jnp.array([0.0, 0.0, -9.81])), [0.0, 1.0, 0.0, 0.0])


@pytest.mark.parametrize("off", [0.0, 1e-5, 2e-4, 1e-3])
def test_level_near_upside_down_in_float(off):
    """The vertical's cosine is -1 there; of the spacing of its numbers an angle of 5e-4 is left."""
    a = np.array([0.0, -9.81 * np.sin(off), -9.81 * np.cos(off)], np.float32)
    found = np.asarray(levelled(jnp.asarray(a)))
    assert found.dtype == np.float32
    up = turned(found.astype(float), a.astype(float))
    np.testing.assert_allclose(up, [0, 0, 9.81], rtol=0, atol=1e-2)


@pytest.mark.parametrize("off", [1e-2, 1e-4, 3e-5, 1e-6])
def test_level_near_upside_down(off):
    """1 + z is rounded at 1e-16 and 5e-9 at the least: 1e-8; below 4.5e-5 rad it is x's half turn.

    There the acceleration stays as far from the vertical as it was: by that angle.
    """
    a = 9.81 * np.array([0.6 * np.sin(off), -0.8 * np.sin(off), -np.cos(off)])
    check_level(a, 2 * off if off < 4.5e-5 else 1e-7)
