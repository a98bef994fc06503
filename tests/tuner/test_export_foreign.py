"""Files that are damaged, or of another kind, are refused in one sentence."""

import contextlib
import json
import pickle
import random

import numpy as np
import pytest

from tests.tuner.export_cases import gyroscope, tuned
from tuner.export import FORMATS, ExportError, dump, load, suffix, write


def refused(data, format):
    with pytest.raises(ExportError) as raised:
        load(data, format)
    sentence = str(raised.value)
    assert sentence.startswith(f"no tuned filter can be read as {format} (")
    assert sentence.endswith("); export it again")
    assert "\n" not in sentence
    assert len(sentence) < 300
    return sentence.removeprefix(f"no tuned filter can be read as {format} (").partition(");")[0]


@pytest.mark.parametrize("format", FORMATS)
def test_files_of_other_kinds(format):
    others = [dump(gyroscope(), other) for other in FORMATS if other != format]
    for data in (b"", b"\0", b"\xff\xfe", b"{}", b"[]", b"a,b\n1,2\n", pickle.dumps([1]), *others):
        refused(data, format)


@pytest.mark.parametrize("format", FORMATS)
def test_files_cut_short(format):
    data = dump(gyroscope(), format)
    for end in range(0, len(data.rstrip()), 7):
        refused(data[:end], format)


@pytest.mark.parametrize("format", FORMATS)
def test_damaged_files_are_read_or_refused(format):
    data = dump(gyroscope(), format)
    rng = random.Random(0)
    for _ in range(300):
        bad = bytearray(data)
        for _ in range(rng.choice([1, 3, 10])):
            bad[rng.randrange(len(bad))] = rng.choice([0, 255, rng.randrange(256)])
        with contextlib.suppress(ExportError):
            load(bytes(bad), format)


@pytest.mark.parametrize("format", FORMATS)
def test_another_schema(format):
    data = dump(gyroscope(), format)
    for old, new in ((b"tuner.tuned/1", b"tuner.tuned/2"), (_wide(1), _wide(2))):
        data = data.replace(old, new)
    if format == "npz":
        assert "CRC" in refused(data, format)
    else:
        reason = refused(data, format)
        assert reason == "its schema is 'tuner.tuned/2' and not 'tuner.tuned/1'"


def _wide(version):
    return f"tuner.tuned/{version}".encode("utf-32-le")


_SECONDS = "give a positive number of seconds, or 0 for a continuous model"


def changed(**fields):
    return json.dumps(json.loads(dump(gyroscope(), "json")) | fields).encode()


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"extra": 1}, "the head should not have 'extra'"),
        ({"dt": "1"}, f"the sample time is '1'; {_SECONDS}"),
        ({"dt": float("nan")}, f"the sample time is nan; {_SECONDS}"),
        ({"states": "ab"}, "the list of states is missing or not a list"),
        ({"versions": [1]}, "the list of versions is missing or not a mapping"),
        ({"versions": {"jax": 1}}, "the version of 'jax' is 1; give text"),
        ({"provenance": None}, "the provenance is missing or not a mapping"),
        ({"quantities": {}}, "the list of quantities is missing or not a list"),
        ({"quantities": []}, "there are no quantities; give at least one"),
        ({"quantities": [1]}, "a quantity is missing or not a mapping"),
        ({"quantities": [{"name": "R"}]}, "a quantity lacks 'meaning', 'unit', "
         "'value'"),
    ],
)  # fmt: skip
def test_documents_that_are_wrong(fields, reason):
    assert refused(changed(**fields), "json") == reason


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        ("1.0", "'1.0' is not a number"),
        ([True], "True is not a number"),
        (None, "None is not a number"),
        ([[1], [1, 2]], "'R' has rows of different lengths; give a full array"),
        ([], "'R' is empty; give at least one number"),
        (10**400, "int too large to convert to float"),
        (float("inf"), "'R' holds NaN or infinity; give finite numbers"),
    ],
)
def test_values_that_are_wrong(value, reason):
    quantity = {"name": "R", "value": value, "unit": "", "meaning": ""}
    assert refused(changed(quantities=[quantity]), "json") == reason


def test_a_document_that_is_nested_too_deep():
    refused(b"[" * 100_000, "json")
    refused(b"x = " + b"[" * 100_000, "toml")


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        (b'"name","row"', b'"name","line"',
         "its columns are not name,row,column,value,unit,meaning"),
        (b'"P0",1,1,2.0', b'"P0",1,2,2.0', "'P0' has rows missing or twice"),
        (b'"P0",1,1,2.0', b'"P0",0,0,2.0', "'P0' has rows missing or twice"),
        (b'"P0",1,1,2.0,""', b'"P0",1,1,2.0,"m"', "'P0' has more than one unit or meaning"),
        (b'"P0",1,1,2.0,""', b'"P0",1,1,2.0', "'P0' has a row with too many or too few columns"),
        (b'"P0": [2, 2]', b'"P0": [2, 1000000000]', "'P0' has rows missing or twice"),
        (b'"R",', b'"r",', "the list of shapes lacks 'r'"),
    ],
)  # fmt: skip
def test_tables_that_are_wrong(old, new, reason):
    data = dump(gyroscope(), "csv")
    assert old in data
    assert refused(data.replace(old, new), "csv") == reason


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        (b"#define GYRO_R 1", b"#define GYRO_S 1", "it does not define GYRO_R"),
        (b"#define GYRO_DT 0", b"#define OTHER_DT 0", "it does not define GYRO_DT"),
        (b'"shape": [2, 2]', b'"shape": [4]',
         "'P0' is not of the shape (4,) that is written beside it"),
        (b" * name:", b" * title:", "its first comment does not name a tuned filter"),
        (b"GYRO_R 1.9148e-10", b"GYRO_R system(1)", "Expecting value: line 1 column 1 (char 0)"),
    ],
)  # fmt: skip
def test_headers_that_are_wrong(old, new, reason):
    data = dump(gyroscope(), "c")
    assert old in data
    assert refused(data.replace(old, new), "c") == reason


def test_pickles_are_never_run(tmp_path):
    class Evil:
        def __reduce__(self):
            return (tmp_path.joinpath("ran").touch, ())

    np.savez(tmp_path / "evil.npz", R=np.array([Evil()], object))
    refused((tmp_path / "evil.npz").read_bytes(), "npz")
    refused(pickle.dumps(Evil()), "npz")
    assert not (tmp_path / "ran").exists()


def test_single_precision_is_refused(tmp_path):
    with np.load(write(gyroscope(), tmp_path / "gyro.npz", "npz")) as archive:
        arrays = dict(archive) | {"R": np.float32(1.0)}
    np.savez(tmp_path / "single.npz", **arrays)
    reason = refused((tmp_path / "single.npz").read_bytes(), "npz")
    assert reason == "'R' is float32; give a float64 array"


def test_unknown_formats_are_told_the_near_ones():
    for call in (suffix, lambda name: dump(tuned(), name), lambda name: load(b"", name)):
        with pytest.raises(ExportError, match=r"^there is no format 'jsn'; there are json$"):
            call("jsn")
    with pytest.raises(ExportError) as raised:
        suffix("xyz")
    assert str(raised.value) == f"there is no format 'xyz'; there are {', '.join(FORMATS)}"
