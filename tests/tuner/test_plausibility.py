from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tuner.data.frames import frame_of, rotated
from tuner.data.logs import LogError
from tuner.data.merge import timeline
from tuner.data.plausibility import check_accelerometer, check_plausibility
from tuner.data.record import Record

G = 9.80665
HZ, N = 50.0, 2000
TIMES = np.arange(N) / HZ
XYZ = ("x", "y", "z")


def channel(unit, axes, kind="number"):
    return SimpleNamespace(unit=unit, axes=axes, kind=kind)


INPUTS = {"gyr": channel("rad/s", XYZ), "acc": channel("m/s^2", XYZ)}
OUTPUTS = {"att": channel("", ("w", "x", "y", "z"), "attitude")}


def wandering(seed=0, size=0.6):
    """A sensor that turns: attitude w x y z, rates and specific force, by SciPy's rotations."""
    rng = np.random.default_rng(seed)
    angles = sum(
        size / 2 * np.sin(2 * np.pi * f * TIMES[:, None] + rng.uniform(0, 6, 3))
        for f in (0.1, 0.23)
    )
    turn = Rotation.from_euler("ZYX", angles + np.array([0.7, 0.0, 0.0]))
    rates = (turn[:-1].inv() * turn[1:]).as_rotvec() * HZ
    force = turn.inv().apply([0.0, 0.0, G]) + 0.05 * rng.normal(size=(N, 3))
    gyr = np.vstack([rates, rates[-1:]]) + 0.01 * rng.normal(size=(N, 3))
    return turn.as_quat(scalar_first=True), gyr, force


ATT, GYR, ACC = wandering()


def judged(gyr=GYR, acc=ACC, att=ATT):
    record = Record.of({"gyr": gyr, "acc": acc}, rate_hz=HZ, truth={"att": att})
    return check_plausibility(timeline(record), INPUTS, OUTPUTS)


def refusal(**channels):
    with pytest.raises(LogError) as caught:
        judged(**channels)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("seed", range(5))
def test_what_is_right_gets_no_word(seed):
    att, gyr, acc = wandering(seed)
    assert judged(gyr, acc, att) == ()
    assert judged(gyr, acc, -att) == ()
    shaken = acc + 2.0 * np.random.default_rng(seed).normal(size=acc.shape)
    assert judged(gyr, shaken, att) == ()


@pytest.mark.parametrize(("factor", "unit"), [(1.0, "g"), (1000.0, "mg"), (980.665, "mg or gal")])
def test_accelerometers_in_another_unit(factor, unit):
    sentence = refusal(acc=ACC / G * factor)
    assert f"looks like {unit}" in sentence
    assert f"acc=...:{unit[:2].strip()}" in sentence


@pytest.mark.parametrize(("scale", "factor"), [(0.5, "2.0"), (2.0, "0.50")])
def test_accelerometers_of_another_scale_are_refused(scale, factor):
    sentence = refusal(acc=ACC * scale)
    assert "where 9.8 is right" in sentence
    assert f"acc=...*{factor}" in sentence


def test_gravity_taken_out_is_refused():
    still = 0.02 * np.random.default_rng(3).normal(size=(N, 3))
    with pytest.raises(LogError, match="gravity was taken out of it; map the specific force"):
        check_accelerometer("acc", still, np.full(N, 0.02))


@pytest.mark.parametrize("reads", [0.0, 1.0, 7.0])
def test_a_fall_is_no_other_unit(reads):
    """It reads gravity as a rule, shaken, and is calmest where it falls."""
    flown = ACC + 0.8 * np.random.default_rng(4).normal(size=ACC.shape)
    flown[:100] = [0.0, 0.0, reads]
    (warning,) = judged(acc=flown)
    assert f"reads {reads:.3g} m/s^2 where it is calmest, and " in warning


def test_gyroscopes_in_degrees_under_radians():
    sentence = refusal(gyr=np.degrees(GYR))
    assert "looks like deg/s" in sentence
    assert "gyr=...:deg/s" in sentence


def test_gyroscopes_in_degrees_are_known_by_gravity_alone():
    slow = [wandering(1, size=0.2)[i] for i in (1, 2)]
    record = Record.of({"gyr": np.degrees(slow[0]), "acc": slow[1]}, rate_hz=HZ)
    other = Record.of({"gyr": np.radians(slow[0]), "acc": slow[1]}, rate_hz=HZ)
    assert np.abs(np.degrees(slow[0])).max() < 35.0  # within what a gyroscope can measure
    with pytest.raises(LogError, match="as fast as gravity does .* looks like deg/s"):
        check_plausibility(timeline(record), INPUTS)
    with pytest.raises(LogError, match="rad/s were taken for deg/s"):
        check_plausibility(timeline(other), INPUTS)


def test_gyroscopes_in_degrees_are_known_by_the_truth_alone():
    att, gyr, _ = wandering(2, size=0.2)
    record = Record.of({"gyr": np.degrees(gyr)}, rate_hz=HZ, truth={"att": att})
    with pytest.raises(LogError, match="as much as att, so it looks like deg/s"):
        check_plausibility(timeline(record), INPUTS, OUTPUTS)


def flipped(turn):
    """A half turn about x on the left, the right or both sides, or none."""
    half = Rotation.from_quat([1.0, 0.0, 0.0, 0.0])
    q = Rotation.from_quat(ATT, scalar_first=True)
    return {
        "": q,
        "left": half * q,
        "right": q * half,
        "both": half * q * half,
    }[turn]


@pytest.mark.parametrize("turn", ["", "left", "right", "both"])
@pytest.mark.parametrize("conjugated", [False, True])
@pytest.mark.parametrize("first", [True, False])
def test_truth_in_another_frame_is_told_with_what_would_fit(turn, conjugated, first):
    q = flipped(turn).inv() if conjugated else flipped(turn)
    att = q.as_quat(scalar_first=first)
    if (turn, conjugated, first) == ("", False, True):
        assert frame_of(att, ACC).fits
        return
    sentence = refusal(att=att)
    assert "not up; it fits as" in sentence
    words = sentence.partition("write att=")[2].partition(" ")[0].split(",")
    columns = {f"q{i}": att[:, i] for i in range(4)}
    read = [(-1 if word[0] == "-" else 1) * columns[word.lstrip("-")] for word in words]
    up = rotated(np.stack(read, axis=1), ACC).mean(axis=0)
    # 0.05 m/s^2 of noise, and numbers printed in no digit: what is written is exact.
    np.testing.assert_allclose(up, [0.0, 0.0, G], atol=0.05)


def test_truth_of_turned_axes_is_told_with_the_turn():
    mounted = Rotation.from_euler("y", 40, degrees=True)
    att = (Rotation.from_quat(ATT, scalar_first=True) * mounted).as_quat(scalar_first=True)
    assert "turned by 40 deg about (0.00, -1.00, 0.00)" in refusal(att=att)


def test_truth_of_another_recording_is_told():
    other = Rotation.random(N, rng=np.random.default_rng(5)).as_quat(scalar_first=True)
    assert "belongs to this recording" in refusal(att=other)


def test_a_level_sensor_cannot_tell_and_is_let_pass():
    level = np.tile([0.0, 0.0, G], (N, 1))
    heading = Rotation.from_rotvec(TIMES[:, None] * [0.0, 0.0, 0.3]).as_quat(scalar_first=True)
    still = np.tile([0.0, 0.0, 0.3], (N, 1))
    assert judged(still, level, heading) == ()
    assert frame_of(heading[:5], level[:5]) is None
