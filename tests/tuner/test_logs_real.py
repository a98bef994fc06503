"""Real logs, where they lie beside the repository; they are never part of it."""

from pathlib import Path

import numpy as np
import pytest

from tuner.data.logs import describe, parse_mapping, read_log

DATA = Path(__file__).parents[2].parent / "shared" / "data"
CHANNELS = ("omega", "theta", "acc")

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="no real logs beside the repository")


def read(name, *maps, **options):
    return read_log(DATA / name, [parse_mapping(text, CHANNELS) for text in maps], **options)


def test_static_gyroscope():
    log = read("static_adis16405_100hz/adis_16405_imu1.npz", "omega=gyr_degs[0]*gyr_lsb:deg/s")
    (omega,) = log.findings.channels
    assert (log.findings.samples, log.rate_hz) == (1_000_000, 100.0)
    assert log.findings.rate_source == "scalar 'fs'"
    assert 0.34 < omega.std < 0.44
    assert (omega.resolution, omega.saturated) == (0.05, 0)


def test_compressed_text_with_lost_samples():
    log = read("imu_samples/xio_fusion_sensor_data.csv.gz", "omega=Gyroscope X (deg/s)", "acc=5:g")
    assert log.findings.time_column == "Time (s)"
    assert log.rate_hz == pytest.approx(99.2, abs=0.1)
    assert len(log.findings.gaps) == 10
    assert all(channel.saturated == 0 for channel in log.findings.channels)


def test_float32_is_widened():
    log = read("imu_samples/vqf_test_imu_data.npz", "omega=gyr[0]:rad/s")
    assert "float32" in log.findings.channels[0].note


def test_river_by_the_year():
    log = read("tuning_benchmarks/nile.csv", "theta=volume", time="year")
    assert (log.findings.samples, log.rate_hz, log.findings.gaps) == (100, 1.0, ())


def test_matlab_version_5():
    paths = sorted((DATA / "broad" / "data_mat").glob("*.mat"))
    assert paths
    for path in paths[:2]:
        log = read(path, "omega=imu_gyr[0]:rad/s", "acc=imu_acc[2]:m/s^2", "theta=movement")
        assert log.rate_hz == pytest.approx(2000 / 7)
        assert all(np.isfinite(values).all() for values in log.channels.values())
        assert all(channel.saturated == 0 for channel in log.findings.channels)
        assert len(describe(log)) == 5
