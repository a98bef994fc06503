"""Real logs, where they lie beside the repository; they are never part of it."""

from pathlib import Path

import numpy as np
import pytest

from tuner.data.findings import find, saturation
from tuner.data.reading import read_record

DATA = Path(__file__).parents[2].parent / "shared" / "data"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="no real logs beside the repository")


def read(name, *maps, **options):
    return read_record(DATA / name, maps, **options)


def saturated(record):
    return [saturation(s.values) for s in record.channels.values()]


def test_static_gyroscope():
    record = read("static_adis16405_100hz/adis_16405_imu1.npz", "omega=gyr_degs[0]*gyr_lsb")
    omega = record.channels["omega"]
    assert (record.sources[0].samples, omega.rate_hz) == (1_000_000, 100.0)
    assert omega.clock.source == "scalar 'fs'"
    found = find(omega.values)
    assert 0.34 < found.std < 0.44
    assert (found.resolution, found.saturated) == (0.05, 0)


def test_compressed_text_with_lost_samples():
    name = "imu_samples/xio_fusion_sensor_data.csv.gz"
    record = read(name, "omega=Gyroscope X (deg/s)", "acc=5:g")
    omega, acc = record.channels["omega"], record.channels["acc"]
    assert omega.clock.source == "column 'Time (s)'"
    assert omega.rate_hz == pytest.approx(99.2, abs=0.1)
    assert len(omega.clock.gaps) == 10
    assert (omega.unit, acc.unit, acc.source) == ("rad/s", "m/s^2", "Accelerometer X (g)")
    assert saturated(record) == [0, 0]


def test_float32_is_widened():
    record = read("imu_samples/vqf_test_imu_data.npz", "omega=gyr[0]:rad/s")
    assert "float32" in record.notes[0]


def test_river_by_the_year():
    theta = read("tuning_benchmarks/nile.csv", "theta=volume", time="year").channels["theta"]
    assert (len(theta.values), theta.rate_hz, theta.clock.gaps) == (100, 1.0, ())


def test_matlab_version_5():
    paths = sorted((DATA / "broad" / "data_mat").glob("*.mat"))
    assert paths
    for path in paths[:2]:
        record = read(path, "omega=imu_gyr[0]:rad/s", "acc=imu_acc[2]:m/s^2", "theta=movement")
        for signal in record.channels.values():
            assert signal.rate_hz == pytest.approx(2000 / 7)
            assert np.isfinite(signal.values).all()
        assert saturated(record) == [0, 0, 0]
