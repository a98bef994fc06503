"""Modes that keep a filter from having a steady state: found in any units, named, taken out."""

import numpy as np
import pytest
import scipy.linalg

from objectives import (
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
    models = {False: (A, W), True: van_loan(A, W, 5.0)}
    for discrete, (F, Q) in models.items():
        (mode,) = undriven_modes(F, Q, discrete=discrete)
        assert mode.words(VERTICAL) == "the constant mode along A_B"
        assert unseen_modes(F, SEEN * units, discrete=discrete) == ()
        part = without_undriven(F, Q, SEEN * units, discrete=discrete)
        np.testing.assert_allclose(part.T @ part.T.T, np.diag([0.0, 1.0, 1.0]), atol=1e-12)
        assert undriven_modes(part.A, part.W, discrete=discrete) == ()


@pytest.mark.parametrize(
    ("Ts", "K2", "K3"),
    [(5.0, 0.113031, 0.793028), (1.0, 0.0877796, 0.375874), (0.5, 0.0682930, 0.244442)],
)
def test_vertical_channel_has_the_published_gains(Ts, K2, K3):
    F, Q = van_loan(vertical(1e-12), np.diag([0.0, 0.04, 0.0]), Ts)
    found = steady_kalman(F, SEEN, Q, R, discrete=True, states=VERTICAL)
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
    for discrete, F in ((False, A), (True, scipy.linalg.expm(0.01 * A))):
        modes = undriven_modes(F, W, discrete=discrete)
        assert {mode.words(names).split("along ")[1] for mode in modes} == {"slope", "offset"}
        part = without_undriven(F, W, C, discrete=discrete)
        np.testing.assert_allclose(np.abs(part.T), [[0.0], [0.0], [1.0]], atol=1e-12)


def test_hidden_modes_are_found_in_any_coordinates():
    draw = np.random.default_rng(4)
    turn = np.linalg.qr(draw.standard_normal((4, 4)))[0]
    inner = np.diag([0.3, 0.0, -1.0, -2.0])
    C = np.array([[0.0, 1.0, 1.0, 1.0]])
    A, C = turn @ inner @ turn.T, C @ turn.T
    (mode,) = unseen_modes(A, C, discrete=False)
    assert mode.eigenvalue == pytest.approx(0.3, abs=1e-12)
    assert abs(np.dot(mode.direction, turn[:, 0])) == pytest.approx(1.0, abs=1e-12)
    part = without_unseen(A, np.eye(4), C, discrete=False)
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(part.A).real), [-2, -1, 0], atol=1e-12)
    B = turn @ np.diag([1.0, 0.0, 1.0, 0.0]) @ turn.T
    (constant,) = undriven_modes(A, B, discrete=False)  # the stable one needs no noise
    assert abs(np.dot(constant.direction, turn[:, 1])) == pytest.approx(1.0, abs=1e-12)


def test_a_weak_drive_and_a_slow_decay_count():
    A = np.diag([0.0, -1e-6, -1.0])
    drive = lambda q: np.diag([q, 0.0, 1.0])  # noqa: E731
    assert len(undriven_modes(A, drive(0.0), discrete=False)) == 1
    assert undriven_modes(A, drive(1e-18), discrete=False) == ()
    assert unseen_modes(A, np.array([[1.0, 0.0, 0.0]]), discrete=False) == ()


def test_an_oscillation_is_named_once():
    A = np.array([[0.0, 2.0], [-2.0, 0.0]])
    (mode,) = undriven_modes(A, np.zeros((2, 2)), discrete=False)
    assert mode.words(["a", "b"]) == "the mode 0+2j 1/s along a, b"
    found = steady_kalman(A, np.eye(2), np.zeros((2, 2)), np.eye(2), discrete=False)
    assert not found.gain.any()


def test_steady_continuous_filter_of_a_random_walk():
    two = steady_kalman(np.zeros((2, 2)), np.eye(2), np.diag([4.0, 0.0]), np.eye(2), discrete=False)
    np.testing.assert_allclose(two.gain, np.diag([2.0, 0.0]), atol=1e-13)
    np.testing.assert_allclose(two.poles, [-2.0], rtol=1e-13)


GOOD = {"A": np.eye(2), "C": np.eye(2), "W": np.eye(2), "V": np.eye(2)}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"C": np.eye(3)}, r"A \(2, 2\), C \(3, 3\), W \(2, 2\) and V \(2, 2\) do not fit"),
        ({"W": np.diag([1.0, -0.5])}, "W is not positive semi-definite: .* eigenvalue is -0.5"),
        ({"V": np.diag([1.0, 0.0])}, "V is not positive definite: its smallest eigenvalue is 0"),
        ({"V": np.array([[1.0, 0.5], [0.0, 1.0]])}, "V is not symmetric"),
        ({"A": np.full((2, 2), np.nan)}, "not finite"),
        ({"C": np.array([[1.0, 0.0]]), "V": np.eye(1)}, "shows the constant mode along b, which"),
    ],
    ids=["shapes", "W", "V", "asymmetric", "nan", "unseen"],
)
def test_refusals_name_the_matter(change, sentence):
    model = GOOD | change
    with pytest.raises(ValueError, match=sentence):
        steady_kalman(**model, discrete=True, states=["a", "b"])


def test_names_have_to_fit():
    with pytest.raises(ValueError, match="1 names for 2 states"):
        Mode(1.0, (1.0, 0.0), "undriven", True).words(["a"])
