import hashlib
import io
import json
import os
import struct
import subprocess
import sys
import tomllib
import zipfile

import numpy as np
import pytest
from hypothesis import given
from scipy.io import loadmat, savemat

from tests.tuner.export_cases import EDGES, gyroscope, nasty, tuned, tuned_filters
from tuner.data.mat import variables
from tuner.export import FORMATS, Quantity, dump, load, suffix


@pytest.mark.parametrize("format", FORMATS)
@pytest.mark.parametrize("case", [nasty, gyroscope, tuned])
def test_reads_back_what_it_wrote(case, format):
    assert load(dump(case(), format), format) == case()


@given(tuned=tuned_filters())
def test_reads_back_anything(tuned):
    for format in FORMATS:
        data = dump(tuned, format)
        assert load(data, format) == tuned
        assert dump(load(data, format), format) == data


def test_equality_is_to_the_bit():
    zero, other = (tuned(Quantity("R", np.array(x), "")) for x in (0.0, -0.0))
    assert zero != other
    assert len({zero, other, tuned(Quantity("R", np.array(0.0), ""))}) == 2


def test_arrays_of_jax_are_taken_and_kept_read_only():
    import jax.numpy as jnp

    import filters  # noqa: F401  # switches float64 on

    given = jnp.eye(2, dtype=float)
    kept = Quantity("P0", given, "").value
    assert kept.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        kept[0, 0] = 2.0


def test_another_process_writes_the_same_bytes():
    program = (
        "import hashlib, json\n"
        "from tests.tuner.export_cases import nasty\n"
        "from tuner.export import FORMATS, dump\n"
        "print(json.dumps([hashlib.sha256(dump(nasty(), f)).hexdigest() for f in FORMATS]))\n"
    )
    ours = [hashlib.sha256(dump(nasty(), format)).hexdigest() for format in FORMATS]
    environment = os.environ | {"PYTHONHASHSEED": "1", "TZ": "Asia/Tokyo", "PYTHONPATH": "."}
    command = [sys.executable, "-c", program]
    theirs = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert json.loads(theirs.stdout) == ours


def test_no_file_holds_the_time():
    with zipfile.ZipFile(io.BytesIO(dump(gyroscope(), "npz"))) as archive:
        assert {member.date_time[0] for member in archive.infolist()} == {1980}
    text = dump(gyroscope(), "mat")[:116]
    assert text.rstrip() == b"MATLAB 5.0 MAT-file, written by filter-tuner"


def test_importing_it_imports_no_heavy_library():
    program = (
        "import sys, tuner; before = set(sys.modules)\n"
        "import tuner.export\n"
        "new = {name.partition('.')[0] for name in set(sys.modules) - before}\n"
        "print(*sorted(new & {'jax', 'scipy', 'pydantic', 'matplotlib'}))\n"
    )
    command = [sys.executable, "-c", program]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    assert ran.stdout.split() == []


def test_suffixes():
    assert [suffix(format) for format in FORMATS] == [
        ".json", ".toml", ".npz", ".csv", ".mat", ".m", ".h",
    ]  # fmt: skip


def test_numpy_users_find_arrays():
    with np.load(io.BytesIO(dump(gyroscope(), "npz")), allow_pickle=False) as archive:
        assert archive["P0"].tolist() == [[0.5, 0.25], [0.25, 2.0]]
        assert archive["R"].shape == ()


def test_matlab_users_find_variables():
    vector = Quantity("v", np.array(EDGES), "m")
    found = loadmat(io.BytesIO(dump(tuned(vector, *gyroscope().quantities), "mat")))
    assert found["R"].shape == (1, 1)
    assert found["R"][0, 0] == 1.9148e-10
    assert found["P0"].tolist() == [[0.5, 0.25], [0.25, 2.0]]
    assert found["v"].shape == (len(EDGES), 1)
    assert found["v"].tobytes() == np.array(EDGES).tobytes()


def test_matlab_users_find_the_metadata():
    found = loadmat(io.BytesIO(dump(gyroscope(), "mat")), squeeze_me=True)
    meta = found["tuner_meta"]
    assert meta["units"].item()["R"].item() == "(rad/s)^2"
    assert meta["convention"].item() == "discrete"
    assert meta["dt"].item() == 1e-4
    assert meta["states"].item().tolist() == ["omega", "epsilon"]
    assert meta["provenance"].item()["solver"].item() == "grid"
    assert meta["versions"].item().tolist()[1] == ["jax", "0.10.2"]


def test_reads_what_matlab_saved_again():
    """Compressed, whole numbers in bytes, text in UTF-16: what MATLAB makes of it."""
    found = loadmat(io.BytesIO(dump(gyroscope(), "mat")), mat_dtype=True)
    again = {name: value for name, value in found.items() if not name.startswith("__")}
    stream = io.BytesIO()
    savemat(stream, again, do_compression=True)
    assert load(stream.getvalue(), "mat") == gyroscope()


def element(order, kind, body):
    padding = bytes(-len(body) % 8)
    return struct.pack(f"{order}II", kind, len(body)) + body + padding


def variable(order, name, kind, shape, numbers):
    flags = element(order, 6, struct.pack(f"{order}II", kind, 0))
    sizes = element(order, 5, struct.pack(f"{order}{len(shape)}i", *shape))
    small = struct.pack(f"{order}I4s", 1 | len(name) << 16, name)
    return element(order, 14, flags + sizes + small + numbers)


@pytest.mark.parametrize(("order", "mark"), [("<", b"\0\1IM"), (">", b"\1\0MI")])
def test_reads_packed_numbers_and_wide_text_of_either_byte_order(order, mark):
    utf16 = element(order, 4, "µ".encode("utf-16-le" if order == "<" else "utf-16-be"))
    packed = element(order, 1, bytes([1, 2, 3, 4]))
    data = b"MATLAB 5.0 MAT-file".ljust(124) + mark
    data += variable(order, b"n", 6, (2, 2), packed) + variable(order, b"t", 4, (1, 1), utf16)
    matrices, texts = variables(data + variable(order, b"s", 5, (1, 1), packed))
    assert matrices["n"].tolist() == [[1.0, 3.0], [2.0, 4.0]]
    assert texts == {"t": "µ"}


def test_toml_and_json_may_be_written_by_hand():
    document = json.loads(dump(gyroscope(), "json"))
    document["quantities"][2]["value"] = [[1, 0], [0, 1]]
    read = load(json.dumps(document, indent=4).encode(), "json")
    assert read.quantities[2].value.tobytes() == np.eye(2).tobytes()
    assert tomllib.loads(dump(gyroscope(), "toml").decode())["provenance"]["seed"] == 7


def test_rows_of_csv_may_be_sorted_in_another_way():
    lines = dump(gyroscope(), "csv").decode().splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith('"name"')) + 1
    turned = "\r\n".join([*lines[:start], *reversed(lines[start:])]).encode("utf-8-sig")
    assert load(turned, "csv") == gyroscope()
