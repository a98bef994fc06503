import time
from pathlib import Path

import numpy as np
import pytest

from tests.tuner.logs_written import sensor_topics, ulog
from tests.tuner.recordings import refusal
from tuner.data.logs.formats import open_table
from tuner.data.reading import read_record

pytest.importorskip("pyulog")
REAL = Path(__file__).parents[2].parent / "shared" / "data" / "formats" / "px4_sample_log_small.ulg"


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "log.ulg"
    path.write_bytes(ulog(sensor_topics(), dropouts=[20, 22]))
    return path


def test_topics_of_one_file_are_clocks_of_one_recording(log):
    (_, _, gyro), _, (_, _, baro) = sensor_topics()
    record = read_record(log, ["omega=gyro.rad:rad/s", "y=gyro.rad[1]:rad/s", "z=baro.alt_m:m"])
    omega, z = record.channels["omega"], record.channels["z"]
    np.testing.assert_array_equal(omega.values, gyro["rad"].astype(float))
    np.testing.assert_array_equal(record.channels["y"].values, omega.values[:, 1])
    np.testing.assert_array_equal(z.values, baro["alt_m"])
    assert (omega.rate_hz, z.rate_hz) == pytest.approx((250.0, 20.0))
    assert z.times[0] - omega.times[0] == pytest.approx(0.01)  # the same clock, in us
    assert omega.clock.source == "column 'gyro.timestamp'"
    assert len(record.sources) == 1
    assert "2 dropouts of the logger, 42 ms in all: samples are missing there" in record.notes


def test_instances_and_other_times(log):
    record = read_record(log, ["a=gyro_1.rad[0]:rad/s", "b=baro.alt_m:m"], time="timestamp:ms")
    assert record.channels["a"].rate_hz == pytest.approx(0.25)
    assert record.channels["b"].rate_hz == pytest.approx(0.02)


def test_columns_of_several_clocks_are_not_one_channel(log):
    sentence = refusal(log, ["x=gyro.clipped,baro.alt_m"])
    assert "columns on several clocks" in sentence
    assert "splits columns on one clock" in refusal(
        log, ["x=gyro.clipped", "y=baro.alt_m"], by="gyro.clipped", reader=_records
    )


def _records(*arguments, **options):
    from tuner.data.reading import read_records

    return read_records(*arguments, **options)


def test_unknown_columns_name_the_near_ones(tmp_path):
    wide = np.zeros(3, [("timestamp", "<u8"), *((f"field{k}", "<f4") for k in range(20))])
    wide["timestamp"] = np.arange(3)
    path = tmp_path / "log.ulg"
    path.write_bytes(ulog([("many", 0, wide)]))
    sentence = refusal(path, ["x=many.feld3"])
    assert "'many.field3'" in sentence
    assert sentence.endswith("tuner columns FILE lists all")


@pytest.mark.parametrize("keep", [10, 40, 300, 1000])
def test_cut_files(tmp_path, log, keep):
    path = tmp_path / "cut.ulg"
    path.write_bytes(log.read_bytes()[:keep])
    if keep < 1000:
        assert refusal(path, ["omega=gyro.rad"]).startswith("cut.ulg: ")
        return
    samples = len(read_record(path, ["omega=gyro.rad"]).channels["omega"].values)
    assert 2 <= samples < 200  # what was written before the end is there


def test_without_the_package_the_extra_is_named(log, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyulog", None)
    assert "pip install 'filter-tuner[ulog]'" in refusal(log, ["omega=gyro.rad"])


def test_large_logs(tmp_path):
    """50 MB in 10 s; here 5 MB, so that the tests stay short."""
    rows = 45_000
    wide = np.zeros(rows, [("timestamp", "<u8"), ("control", "<f4", (24,))])
    wide["timestamp"] = 1000 * np.arange(rows)
    path = tmp_path / "log.ulg"
    path.write_bytes(ulog([("wide", 0, wide)]))
    assert path.stat().st_size > 4.9e6
    start = time.perf_counter()
    assert read_record(path, ["x=wide.control[3]"]).channels["x"].values.shape == (rows,)
    assert time.perf_counter() - start < 5.0  # a tenth of the bytes; the rest is starting Python


@pytest.mark.skipif(not REAL.exists(), reason="no real logs beside the repository")
def test_a_real_flight():
    table = open_table(REAL)
    assert len(table.groups) > 60
    record = read_record(REAL, ["omega=sensor_combined.gyro_rad:rad/s"])
    assert 200 < record.channels["omega"].rate_hz < 210
