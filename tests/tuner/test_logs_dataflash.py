import numpy as np
import pytest

from tests.tuner.logs_written import dataflash, flight, flight_text, record
from tests.tuner.recordings import refusal
from tuner.data.logs.formats import open_table
from tuner.data.reading import read_record


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "flight.bin"
    path.write_bytes(flight()[0])
    return path


def test_instances_scales_and_units(log):
    read = read_record(log, ["omega=IMU[1].GyrX", "z=BARO.Alt", "T=BARO.Temp", "lat=GPS.Lat"])
    omega, temperature = read.channels["omega"], read.channels["T"]
    np.testing.assert_array_equal(omega.values, (flight()[1] + 1).astype(float))
    assert (omega.unit, omega.rate_hz) == ("rad/s", pytest.approx(400.0))
    np.testing.assert_allclose(temperature.values, 25.12 + 0.01 * np.arange(5), rtol=1e-12)
    np.testing.assert_allclose(read.channels["lat"].values, np.deg2rad(47.1234567), rtol=1e-7)
    assert read.channels["z"].rate_hz == pytest.approx(20.0)
    assert omega.times[0] - read.channels["z"].times[0] == pytest.approx(1e-6)
    assert "omega: rad/s, as the file says" in read.notes


def test_what_is_stored_is_what_is_read(log):
    table = open_table(log)
    assert table.units["GPS.GMS"] == "ms"  # the number as it stands, and its unit with the factor
    assert table.units["IMU[0].TimeUS"] == "us"
    assert table.load(["MSG.Message"])["MSG.Message"].tolist() == ["hello, world"]
    assert [group.prefix for group in table.groups] == [
        "IMU[0].", "IMU[1].", "BARO.", "GPS.", "MSG.",
    ]  # fmt: skip


def test_text_holds_the_same(tmp_path, log):
    path = tmp_path / "flight.log"
    path.write_text(flight_text(flight()[1]))
    one, other = (
        read_record(file, ["omega=IMU[1].GyrX"]).channels["omega"] for file in (log, path)
    )
    np.testing.assert_allclose(other.values, one.values, rtol=1e-6)  # six digits in text
    np.testing.assert_array_equal(other.times, one.times)
    assert other.unit == "rad/s"
    table = open_table(path)
    assert table.notes == ("1 line without all cells passed over",)
    assert table.load(["MSG.Message"])["MSG.Message"].tolist() == ["hello, world"]


def test_text_that_is_no_number_has_its_line_named(tmp_path):
    path = tmp_path / "flight.log"
    path.write_text(flight_text([0.5, 1.5]).replace("IMU, 1002500, 0, 1.5", "IMU, 1002500, 0, x"))
    sentence = refusal(path, ["omega=IMU[0].GyrX"])
    assert sentence.startswith("flight.log: line 12 has 'x' for 'GyrX' of IMU, not a number")


def test_damage_between_messages_is_passed_over_and_said(tmp_path):
    good = flight()[0]
    path = tmp_path / "flight.bin"
    path.write_bytes(good + b"\xa3\x95\xfe garbage" + record(10, "<u8,u1,<f4", (10**7, 0, 1.0)))
    read = read_record(path, ["omega=IMU[0].GyrX"])
    assert len(read.channels["omega"].values) == 101
    assert "11 bytes between the messages passed over" in read.notes


def test_arrays_and_contradictions(tmp_path):
    path = tmp_path / "log.bin"
    kinds = {"ISBD": ("Qa", "TimeUS,x", [(k, list(range(32))) for k in range(40)])}
    path.write_bytes(dataflash(kinds))
    values = read_record(path, ["x=ISBD.x[31]"]).channels["x"].values
    np.testing.assert_array_equal(values, 31.0)
    path.write_bytes(dataflash({"BAD": ("Qf", "TimeUS,x,y", [(0, 1.0)])}))
    assert "describes none of its messages" in refusal(path, ["x=BAD.x"])
