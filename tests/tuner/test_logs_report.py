import dataclasses
import doctest
import importlib
import json
import pkgutil
import subprocess
import sys

import numpy as np
import pytest

import tuner.data.logs
from tuner.data.logs import describe, parse_mapping, read_log, to_dict

MODULES = [info.name for info in pkgutil.iter_modules(tuner.data.logs.__path__, "tuner.data.logs.")]


@pytest.fixture
def log(tmp_path):
    rng = np.random.default_rng(6)
    times = np.delete(np.arange(1000), [5, 50, 60, 70, 80, 90, 500, 501]) / 100
    turn = np.clip(np.round(100 * np.sin(times)), -90, 200) + 0.0
    np.savez(tmp_path / "turn.npz", t=times, gyr=turn, acc=rng.normal(size=len(times)))
    texts = ("omega=gyr*0.01:deg/s", "acc=acc")
    mappings = [parse_mapping(text, ["omega", "acc"]) for text in texts]
    return read_log(tmp_path / "turn.npz", mappings)


def test_description_of_a_log(log):
    lines = describe(log)
    assert lines[:2] == [
        "turn.npz: 992 samples, 9.99 s at 100 Hz (time column 't')",
        "time 't': even, 7 gaps (rows count from 0), longest 0.03 s",
    ]
    assert lines[2] == "  0.02 s after row 4"
    assert lines[7] == "  and 2 more"
    table = lines[8:11]
    assert [line.split()[0] for line in table] == ["channel", "omega", "acc"]
    assert len({len(line) for line in table}) == 1
    assert table[1].split()[1:3] == ["gyr*0.01", "deg/s"]
    assert table[1].endswith("0.01")
    assert table[2].endswith("-")
    assert lines[11].startswith("omega: ")
    assert "saturated" in lines[11]
    assert len(lines) == 12


def test_description_of_findings_lacks_only_the_name(log):
    assert ["turn.npz: " + describe(log.findings)[0], *describe(log.findings)[1:]] == describe(log)


def test_description_of_an_uneven_clock(log):
    uneven = dataclasses.replace(log.findings, jitter=0.123, gaps=())
    assert "time 't': jitter up to 12 % of a step, no gaps" in describe(uneven)


def test_dictionary_is_json(log):
    plain = to_dict(log)
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    assert plain["name"] == "turn.npz"
    assert plain["sha256"] == log.sha256
    assert plain["gaps"][0] == [4, pytest.approx(0.02)]
    assert [channel["name"] for channel in plain["channels"]] == ["omega", "acc"]
    assert to_dict(log.findings) == {k: v for k, v in plain.items() if k not in ("name", "sha256")}


@pytest.mark.parametrize("name", MODULES)
def test_examples_in_docstrings(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_import_is_light():
    heavy = "{'jax', 'scipy', 'h5py', 'matplotlib'}"
    code = f"import sys, tuner.data.logs; sys.exit(bool({heavy} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
