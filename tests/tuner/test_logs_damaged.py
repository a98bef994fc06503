"""Cut, changed and made-up bytes in every format: read, or refused in one sentence."""

import io
import struct
import zipfile

import numpy as np
import pytest

from tests.tuner.logs_written import flight, flight_text, sensor_topics, ulog
from tests.tuner.test_logs_mat_objects import FILE
from tuner.data.logs import LogError
from tuner.data.logs.formats import open_table


def packed():
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("a.csv", "b.csv"):
            archive.writestr(name, "t,x\n" + "".join(f"{k},{k % 7}\n" for k in range(90)))
    return stream.getvalue()


WRITTEN = {
    "dataflash": lambda: flight()[0],
    "dataflash as text": lambda: flight_text(flight()[1]).encode(),
    "mat": lambda: FILE,
    "zip": packed,
}
APART = {
    "ulog": lambda: ulog(sensor_topics(40)),
    "rosbag": lambda: b"#ROSBAG V2.0\n" + bytes(range(256)) * 8,
    "mcap": lambda: b"\x89MCAP0\r\n\x01" + struct.pack("<Q", 1 << 60) + bytes(200),
    "hdf5": lambda: b"\x89HDF\r\n\x1a\n" + bytes(range(256)) * 8,
    "sqlite": lambda: b"SQLite format 3\0" + bytes(range(256)) * 8,
}


def changed(data, rng):
    """Cut, or with some bytes changed, doubled or taken out; the first 16 stay."""
    data = bytearray(data)
    kind, at = rng.integers(4), int(rng.integers(16, len(data)))
    if kind == 0:
        return bytes(data[:at])
    if kind == 1:
        return bytes(data[:at] + data[at + int(rng.integers(1, 40)) :])
    if kind == 2:
        return bytes(data[:at] + data[max(16, at - 60) : at] + data[at:])
    for place in rng.integers(16, len(data), rng.integers(1, 6)):
        data[place] = rng.choice([0, 1, 127, 128, 255, int(rng.integers(256))])
    return bytes(data)


def read_or_refused(path, data):
    path.write_bytes(data)
    try:
        table = open_table(path)
        table.load(table.names)
    except LogError as error:
        sentence = str(error)
        assert sentence.startswith("log")
        assert "\n" not in sentence
        assert str(path.parent) not in sentence


@pytest.mark.parametrize("kind", WRITTEN)
def test_changed_bytes(tmp_path, kind):
    data, rng = WRITTEN[kind](), np.random.default_rng(11)
    for _ in range(60):
        read_or_refused(tmp_path / "log", changed(data, rng))


@pytest.mark.parametrize("kind", APART)
def test_changed_bytes_in_a_process_apart(tmp_path, kind):
    data, rng = APART[kind](), np.random.default_rng(12)
    for _ in range(2):
        read_or_refused(tmp_path / "log", changed(data, rng))


def element(kind, body):
    return struct.pack("<II", kind, len(body)) + body + bytes(-len(body) % 8)


def matrix(kind, shape, *rest, name=b"x"):
    flags = element(6, struct.pack("<II", kind, 0))
    sizes = element(5, np.array(shape, "<i4").tobytes())
    return element(14, flags + sizes + element(1, name) + b"".join(rest))


def nested(depth):
    inner = matrix(6, (1, 1), element(9, bytes(8)))
    for _ in range(depth):
        inner = matrix(1, (1, 1), inner)
    return inner


@pytest.mark.parametrize(
    ("body", "part"),
    [
        (nested(100), "nested more than 24 deep"),
        (matrix(6, (1 << 30, 1 << 30), element(9, bytes(8))), "too many or too few numbers"),
        (matrix(6, (-1, 1), element(9, bytes(8))), "impossible size"),
        (matrix(6, [1] * 40, element(9, bytes(8))), "impossible size"),
        (matrix(2, (9, 9), element(5, b"\x20\0\0\0"), element(1, bytes(32))), "too few values"),
        (matrix(6, (1, 1), element(9, bytes(8)))[:-4], "ends too early"),
    ],
)
def test_hostile_mat_files(tmp_path, body, part):
    path = tmp_path / "log.mat"
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + body)
    with pytest.raises(LogError, match=part):
        open_table(path)


def test_mat_files_that_would_unpack_to_gigabytes(tmp_path, monkeypatch):
    import zlib

    monkeypatch.setattr("tuner.limits.UNPACKED", 1 << 16)
    body = zlib.compress(matrix(6, (1, 1 << 20), element(9, bytes(1 << 23))))
    path = tmp_path / "log.mat"
    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM"
    path.write_bytes(head + struct.pack("<II", 15, len(body)) + body)
    with pytest.raises(LogError, match="more than a hundredfold"):
        open_table(path)
