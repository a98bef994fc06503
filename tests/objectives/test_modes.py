"""Modes that keep a filter from having a steady state: found in any units, named, taken out."""

import numpy as np
import pytest
import scipy.linalg

from objectives import (
    LinearSystem,
    Mode,
    steady_kalman,
    undriven_modes,
    unseen_modes,
    without_undriven,
    without_unseen,
)
from tests.oracles_ha1981 import van_loan

VERTICAL = ["A_B", "dV", "dh"]
SEEN = np.array([[0.0, 0.0, 1.0]])
R = np.array([[3.24]])


def vertical(k):
    return np.array([[0.0, 0.0, 0.0], [1.0, 0.0, k], [0.0, 1.0, 0.0]])


@pytest.mark.parametrize("units", [np.ones(3), np.array([1e-6, 1.0, 1e6])], ids=["SI", "mixed"])
@pytest.mark.parametrize("k", [0.0, 3.07e-6])
def test_vertical_channel_has_an_undriven_constant(k, units):
    A = vertical(k) / units[:, None] * units
    W = np.diag([0.0, 0.04, 0.0]) / np.outer(units, units)
    for dt, (F, Q) in {None: (A, W), 5.0: van_loan(A, W, 5.0)}.items():
        system = LinearSystem(F, SEEN * units, Q, R, dt=dt, states=VERTICAL)
        (mode,) = undriven_modes(system)
        assert mode.words(VERTICAL) == "the constant mode along A_B"
        assert unseen_modes(system) == ()
        part = without_undriven(system)
        np.testing.assert_allclose(part.T @ part.T.T, np.diag([0.0, 1.0, 1.0]), atol=1e-12)
        assert set(part.system.states) == {"dV", "dh"}
        assert undriven_modes(part.system) == ()


@pytest.mark.parametrize(
    ("Ts", "K2", "K3"),
    [(5.0, 0.113031, 0.793028), (1.0, 0.0877796, 0.375874), (0.5, 0.0682930, 0.244442)],
)
def test_vertical_channel_has_the_published_gains(Ts, K2, K3):
    F, Q = van_loan(vertical(1e-12), np.diag([0.0, 0.04, 0.0]), Ts)
    found = steady_kalman(LinearSystem(F, SEEN, Q, R, dt=Ts, states=VERTICAL))
    np.testing.assert_allclose(found.gain[:, 0], [0.0, K2, K3], rtol=3e-6, atol=1e-12)
    np.testing.assert_allclose(found.gain, found.updated @ SEEN.T / R, rtol=1e-10, atol=1e-14)
    assert [mode.words(VERTICAL) for mode in found.removed] == ["the constant mode along A_B"]
    assert not found.predicted[0].any()
    assert np.abs(found.poles).max() < 1


def test_an_undriven_ramp_is_two_states():
    A = np.zeros((3, 3))
    A[0, 1] = A[2, 0] = 1.0  # offset, its slope, and a driven level that integrates the offset
    W, C = np.diag([0.0, 0.0, 2.0]), np.array([[0.0, 0.0, 1.0]])
    names = ["offset", "slope", "level"]
    for dt, F in ((None, A), (0.01, scipy.linalg.expm(0.01 * A))):
        system = LinearSystem(F, C, W, R, dt=dt)
        modes = undriven_modes(system)
        assert {mode.words(names).split("along ")[1] for mode in modes} == {"slope", "offset"}
        part = without_undriven(system)
        np.testing.assert_allclose(np.abs(part.T), [[0.0], [0.0], [1.0]], atol=1e-12)


def test_hidden_modes_are_found_in_any_coordinates():
    draw = np.random.default_rng(4)
    turn = np.linalg.qr(draw.standard_normal((4, 4)))[0]
    inner = np.diag([0.3, 0.0, -1.0, -2.0])
    C = np.array([[0.0, 1.0, 1.0, 1.0]])
    A, C = turn @ inner @ turn.T, C @ turn.T
    system = LinearSystem(A, C, np.eye(4), R)
    (mode,) = unseen_modes(system)
    assert mode.eigenvalue == pytest.approx(0.3, abs=1e-12)
    assert abs(np.dot(mode.direction, turn[:, 0])) == pytest.approx(1.0, abs=1e-12)
    left = without_unseen(system).system
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(left.A).real), [-2, -1, 0], atol=1e-12)
    B = turn @ np.diag([1.0, 0.0, 1.0, 0.0]) @ turn.T
    (constant,) = undriven_modes(LinearSystem(A, C, B, R))  # the stable one needs no noise
    assert abs(np.dot(constant.direction, turn[:, 1])) == pytest.approx(1.0, abs=1e-12)


def test_a_weak_drive_and_a_slow_decay_count():
    A = np.diag([0.0, -1e-6, -1.0])
    drive = lambda q: LinearSystem(A, [[1.0, 0.0, 0.0]], np.diag([q, 0.0, 1.0]), R)  # noqa: E731
    assert len(undriven_modes(drive(0.0))) == 1
    assert undriven_modes(drive(1e-18)) == ()
    assert unseen_modes(drive(0.0)) == ()


def test_an_oscillation_is_named_once():
    A = np.array([[0.0, 2.0], [-2.0, 0.0]])
    system = LinearSystem(A, np.eye(2), np.zeros((2, 2)), np.eye(2))
    (mode,) = undriven_modes(system)
    assert mode.words(["a", "b"]) == "the mode 0+2j 1/s along a, b"
    assert not steady_kalman(system).gain.any()


def test_steady_continuous_filter_of_a_random_walk():
    walks = LinearSystem(np.zeros((2, 2)), np.eye(2), np.diag([4.0, 0.0]), np.eye(2))
    two = steady_kalman(walks)
    np.testing.assert_allclose(two.gain, np.diag([2.0, 0.0]), atol=1e-13)
    np.testing.assert_allclose(two.poles, [-2.0], rtol=1e-13)


@pytest.mark.parametrize(
    ("C", "V", "sentence"),
    [
        ([[1.0, 0.0]], [[1.0]], "no measurement shows the constant mode along b, which does not"),
        (np.eye(2), np.diag([1.0, 0.0]), "a measurement has no noise .* give its noise"),
        (np.eye(2), np.ones((2, 2)), "a measurement has no noise"),
    ],
    ids=["unseen", "noiseless", "the same noise"],
)
def test_refusals_name_the_matter(C, V, sentence):
    system = LinearSystem(np.zeros((2, 2)), C, np.eye(2), V, states=["a", "b"])
    with pytest.raises(ValueError, match=sentence):
        steady_kalman(system)


def test_names_have_to_fit():
    with pytest.raises(ValueError, match="1 names for 2 states"):
        Mode(1.0, (1.0, 0.0), "undriven", True).words(["a"])
