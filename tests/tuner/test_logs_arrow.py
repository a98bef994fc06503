import sys

import numpy as np
import pytest

from tests.tuner.recordings import refusal
from tuner.data.reading import read_record

RATES = np.random.default_rng(6).normal(size=50)


def test_without_pyarrow_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    (tmp_path / "log.parquet").write_bytes(b"PAR1")
    sentence = refusal(tmp_path / "log.parquet", ["x=y"])
    assert "pip install 'filter-tuner[arrow]'" in sentence


@pytest.fixture(params=["parquet", "feather"])
def log(tmp_path, request):
    pa = pytest.importorskip("pyarrow", reason="pyarrow takes 170 MB; pip install pyarrow")
    from pyarrow import feather, parquet

    stamps = pa.array(1_700_000_000_000_000_000 + 5_000_000 * np.arange(50), pa.timestamp("ns"))
    columns = {
        "when": stamps,
        "gyro": [None, *RATES[1:]],
        "imu": [{"acc": {"x": float(k)}} for k in range(50)],
        "pair": pa.array([[k, 2.0 * k] for k in range(50)], pa.list_(pa.float64(), 2)),
        "name": ["a"] * 50,
    }
    path = tmp_path / f"log.{request.param}"
    write = parquet.write_table if request.param == "parquet" else feather.write_feather
    write(pa.table(columns), path)
    return path


def test_columns_of_both_formats(log):
    record = read_record(log, ["w=gyro:rad/s", "a=imu.acc.x:m/s^2", "p=pair[1]:m"])
    w = record.channels["w"]
    np.testing.assert_array_equal(w.values, np.append(np.nan, RATES[1:]))
    np.testing.assert_array_equal(record.channels["a"].values, np.arange(50.0))
    np.testing.assert_array_equal(record.channels["p"].values, 2.0 * np.arange(50))
    assert w.rate_hz == pytest.approx(200.0)
    assert "the time is 'when', a column of time stamps in ns" in record.notes
    assert "holds text" in refusal(log, ["x=name"])


def test_damaged_files(log):
    log.write_bytes(log.read_bytes()[:200])
    assert "file is damaged" in refusal(log, ["w=gyro"])
