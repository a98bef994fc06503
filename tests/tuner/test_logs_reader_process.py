"""What a reader does in its own process becomes one sentence here."""

import sys
from pathlib import Path

import numpy as np
import pytest

from tests.tuner.recordings import refusal
from tuner.data.logs.reader_process import Reader, open_in_process

READER = Reader("made_up_reader", "made-up log", "numpy", "none")

SOURCE = """
import os, signal, sys
import numpy as np
from tuner.data.logs.contents import Contents, Group
from tuner.data.logs.error import LogError

def contents(path):
    kind = path.read_text()
    print("readers may print", file=sys.stdout)
    if kind == "signal":
        os.kill(os.getpid(), signal.SIGSEGV)
    if kind == "exit":
        sys.exit(3)
    if kind == "index":
        [][7]
    if kind == "recursion":
        contents(path)
    if kind == "memory":
        np.ones(1 << 40)
    if kind == "assert":
        assert False
    if kind == "names":
        raise OSError(f"{path}: two\\nlines")
    if kind == "refused":
        raise LogError("the log is refused; write another")
    return Contents("made-up log", [Group("a.", {"x": 0, "y": 2}, 3, "x", "ms")])

def load(path, names):
    found = {"a.x": np.arange(3), "a.y": np.arange(6.0).reshape(3, 2), "a.z": np.array([{}])}
    return {name: found[name] for name in names}
"""


@pytest.fixture(autouse=True)
def reader(tmp_path, monkeypatch):
    (tmp_path / "made_up_reader.py").write_text(SOURCE)
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])


def opened(path: Path, kind: str):
    path = path / "some.log"
    path.write_text(kind)
    return open_in_process(path, READER)


def test_arrays_come_back_as_they_were(tmp_path):
    table = opened(tmp_path, "good")
    assert table.names == ("a.x", "a.y")
    found = table.load(["a.y", "a.x"])
    np.testing.assert_array_equal(found["a.y"], np.arange(6.0).reshape(3, 2))
    assert found["a.x"].dtype == np.int64
    assert table.load([]) == {}


@pytest.mark.parametrize(
    ("kind", "part"),
    [
        ("signal", "its reader was ended by signal 11"),
        ("exit", "SystemExit: 3"),
        ("index", "IndexError: list index out of range"),
        ("recursion", "RecursionError"),
        ("memory", "MemoryError: Unable to allocate 8.00 TiB"),
        ("assert", "AssertionError"),
        ("names", "OSError: some.log: two lines"),
    ],
)
def test_whatever_goes_wrong_is_one_sentence(tmp_path, kind, part):
    sentence = refusal(tmp_path, kind, reader=opened)
    assert sentence.startswith("some.log: the made-up log file is damaged (")
    assert part in sentence


def test_its_own_refusals_stay_as_they_are(tmp_path):
    sentence = refusal(tmp_path, "refused", reader=opened)
    assert sentence == "some.log: the log is refused; write another"


def test_objects_cannot_come_back(tmp_path):
    table = opened(tmp_path, "good")
    assert "made-up log file is damaged" in refusal(["a.z"], reader=table.load)


def test_time_is_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr("tuner.data.logs.reader_process._SECONDS", 1)
    (tmp_path / "made_up_reader.py").write_text("while True: pass")
    sentence = refusal(tmp_path, "good", reader=opened)
    assert "its reader was ended by signal" in sentence or "not read within 2 s" in sentence
