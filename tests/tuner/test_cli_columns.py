import json

import numpy as np
import pytest

from tests.tuner.logs_written import flight
from tuner.cli import invoke


def test_what_a_log_holds(tmp_path, capsys):
    path = tmp_path / "flight.bin"
    path.write_bytes(flight()[0])
    assert invoke(["columns", str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "flight.bin: ArduPilot DataFlash log"
    assert "100 rows, 400 Hz, 0.2475 s, time: column 'IMU[0].TimeUS'" in lines
    assert "  IMU[0].GyrX    float32   rad/s" in lines


def test_the_same_as_json(tmp_path, capsys):
    path = tmp_path / "log.csv"
    path.write_text("t,x,mode\n0.0,1,on\n0.5,2,off\n1.0,3,on\n")
    assert invoke(["columns", str(path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    numbers, texts = told["clocks"]
    assert (told["schema"], told["file"]) == ("tuner.columns/1", "log.csv")
    assert (numbers["rows"], numbers["rate_hz"], numbers["seconds"]) == (3, 2.0, 1.0)
    assert [column["name"] for column in numbers["columns"]] == ["t", "x"]
    assert [column["name"] for column in texts["columns"]] == ["mode"]


def test_lengths_without_times(tmp_path, capsys):
    path = tmp_path / "log.npz"
    np.savez(path, a=np.zeros((5, 3)), b=np.zeros(4), fs=2.0)
    assert invoke(["columns", str(path)]) == 0
    out = capsys.readouterr().out
    assert "5 rows, 2 Hz, 2 s, time: scalar 'fs'\n  a[0..2]  float64" in out
    assert "single values and texts\n  fs  float64" in out
    np.savez(path, a=np.zeros(5))
    assert invoke(["columns", str(path)]) == 0
    assert "no times are known: give --rate HZ or --time COLUMN" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["none.csv", "empty.csv"])
def test_what_cannot_be_read(tmp_path, capsys, name):
    (tmp_path / "empty.csv").touch()
    assert invoke(["columns", str(tmp_path / name)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"tuner: {name}: ")
