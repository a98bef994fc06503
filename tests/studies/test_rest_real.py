"""The study on a real sensor that lay still for hours; skipped where the recording is not."""

from pathlib import Path

import numpy as np
import pytest

from studies.rest import STUDY
from studies.rest.curve import read_noise
from studies.rest.settings import Settings
from tuner import Record
from tuner.data.allan import allan_curve
from tuner.data.stillness import find_motion

FILE = (
    Path(__file__).resolve().parents[3] / "shared/data/static_adis16405_100hz/adis_16405_imu1.npz"
)
pytestmark = pytest.mark.skipif(not FILE.exists(), reason=f"there is no {FILE}")
DEVIATIONS = {0.01: 0.32, 0.1: 0.125, 1.0: 0.041, 10.0: 0.0133, 100.0: 0.0075}
FAR = 500.0, 0.0076  # by 19 differences of blocks side by side, which scatter by a fifth


@pytest.fixture(scope="module")
def sensor():
    with np.load(FILE) as data:
        gyr = data["gyr_degs"] * float(data["gyr_lsb"])
        return {"gyr": gyr, "acc": data["acc_g"] * float(data["acc_lsb"])}


def test_published_allan_deviations(sensor):
    curve = allan_curve(sensor["gyr"][:, 0], 100.0)
    for tau, deviation in DEVIATIONS.items():
        found = np.exp(np.interp(np.log(tau), np.log(curve.taus), np.log(curve.deviations)))
        assert found == pytest.approx(deviation, rel=0.05), tau
    blocks = sensor["gyr"][:, 0].reshape(20, -1).mean(axis=1)
    assert np.sqrt(np.mean(np.diff(blocks) ** 2) / 2) == pytest.approx(FAR[1], rel=0.01)
    at = int(np.searchsorted(curve.taus, FAR[0]))
    assert curve.lows[at] < FAR[1] < curve.highs[at]
    noise = read_noise(curve)
    assert noise.white.value == pytest.approx(0.041, rel=0.05)
    floor = noise.instability.value * np.sqrt(2 * np.log(2) / np.pi)
    assert floor == pytest.approx(0.007, rel=0.05)


def test_hours_of_bias_walk_are_no_motion(sensor):
    for values in sensor.values():
        for axis in values.T:
            assert find_motion(axis, 100.0) is None


def test_minutes_and_hours_make_the_same_filter(sensor):
    """The limits of 20 single minutes hold the hours' density as often as 95 % ones do."""

    def rest(values):
        record = Record.of({"z": values}, rate_hz=100.0, units={"z": "deg/s"})
        (found,) = STUDY.plan(Settings(settles_s=1.0), (record,), 0, "").case
        return found

    gyr = sensor["gyr"][:, 0]
    hours = rest(gyr)
    minutes = [rest(gyr[k : k + 6_000]) for k in range(0, 1_000_000, 50_000)]
    for minute in minutes:
        assert minute.gain == pytest.approx(hours.gain, rel=0.01)
    held = sum(minute.white.low < hours.white.value < minute.white.high for minute in minutes)
    assert held >= 17  # of 20; fewer would be by chance in 2 of 100 cases
