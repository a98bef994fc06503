import hashlib
import pickle
import threading
import time
import zipfile

import numpy as np
import pytest

from tests.tuner.recordings import refusal, values
from tuner.data.logs.error import LogError
from tuner.data.reading import read_record

N = 50
NOISE = np.random.default_rng(1).normal(size=(N, 3))


def refused(path, *maps, **options):
    sentence = refusal(path, maps, **options)
    assert sentence.startswith("log.npz: ")
    return sentence


def saved(folder, save=np.savez, **arrays):
    path = folder / "log.npz"
    save(path, **arrays)
    return path


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_arrays_and_scalars(tmp_path, save):
    counts = np.round(100 * NOISE).astype(np.int16)
    path = saved(
        tmp_path, save, gyr=counts, angle=NOISE[:, 1], lsb=np.float64(0.05), other=np.ones(3)
    )
    channels = read_record(path, ["omega=gyr[2]*lsb", "theta=angle*-2"], rate_hz=200).channels
    np.testing.assert_array_equal(channels["omega"].values, counts[:, 2] * 0.05)
    np.testing.assert_array_equal(channels["theta"].values, NOISE[:, 1] * -2)
    assert all(signal.values.flags.c_contiguous for signal in channels.values())
    assert all(signal.clock.source == "--rate" for signal in channels.values())
    np.testing.assert_allclose(channels["theta"].times, np.arange(N) / 200, rtol=1e-15)


@pytest.mark.parametrize(
    "dtype", [np.int8, np.uint16, np.int32, np.int64, np.uint64, ">f8", np.longdouble, np.bool_]
)
def test_number_types(tmp_path, dtype):
    raw = np.arange(N).astype(dtype)
    array = values(saved(tmp_path, x=raw), "omega=x", rate_hz=1)
    assert array.dtype == np.float64
    np.testing.assert_array_equal(array, raw.astype(float))


@pytest.mark.parametrize("dtype", [np.float16, np.float32])
def test_rounded_numbers_are_widened_and_said(tmp_path, dtype):
    record = read_record(saved(tmp_path, x=NOISE.astype(dtype)), ["omega=x:rad/s"], rate_hz=1)
    np.testing.assert_array_equal(
        record.channels["omega"].values, NOISE.astype(dtype).astype(float)
    )
    assert f"omega: {dtype.__name__}, widened" in record.describe()[-1]


@pytest.mark.parametrize("name", ["fs", "rate", "rate_hz", "sampling_rate", "Sample_Rate"])
def test_rate_from_a_scalar(tmp_path, name):
    record = read_record(saved(tmp_path, x=NOISE, **{name: np.array([250])}), ["omega=x"])
    assert record.sources[0].rate_hz == record.channels["omega"].rate_hz == 250.0
    assert record.channels["omega"].clock.source == f"scalar '{name}'"


def test_one_column_needs_no_index(tmp_path):
    path = saved(tmp_path, x=NOISE[:, :1])
    np.testing.assert_array_equal(values(path, "omega=x", rate_hz=1), NOISE[:, 0])


def test_the_format_is_told_by_the_bytes(tmp_path):
    path = saved(tmp_path, x=NOISE[:, 0]).rename(tmp_path / "log.csv")
    np.testing.assert_array_equal(values(path, "omega=x", rate_hz=1), NOISE[:, 0])


BAD = [
    (NOISE, "omega=x,x[0]", ["shape (50, 3)", "x[0] to x[2]"]),
    (NOISE, "omega=x[3]", ["x[0] to x[2]"]),
    (NOISE[:, 0], "omega=x[0]", ["one-dimensional", "leave the index out"]),
    (NOISE.T, "omega=x[0]", ["(3, 50)", "transposed"]),
    (NOISE[..., None], "omega=x", ["3-dimensional"]),
    (np.float64(3), "omega=x", ["single number"]),
    (np.empty(0), "omega=x", ["0 rows", "at least 2"]),
    (NOISE[:, 0] * 1j, "omega=x", ["complex"]),
    (np.array(["a"] * N), "omega=x", ["text"]),
    (np.arange(N).astype("M8[ms]"), "omega=x", ["dates"]),
    (np.arange(N) + 2**53, "omega=x", ["beyond 2**53", "offset"]),
    (NOISE[:, 0], "omega=x*nothing", ["'nothing' is neither a number nor a scalar", "'x'"]),
    (NOISE[:, 0], "omega=x*x", ["'x' is neither a number nor a scalar"]),
    (NOISE[:, 0], "omega=y", ["no column 'y'", "'x', 'zero'"]),
    (NOISE[:, 0], "omega=x*zero", ["scalar 'zero' is 0"]),
    (NOISE[:, 0], "omega=1", ["no column '1'"]),
    (NOISE[:, 0], "omega=x*1e308", ["missing in all 50 rows"]),
]


@pytest.mark.parametrize(("array", "mapped", "parts"), BAD, ids=[" ".join(b[2]) for b in BAD])
def test_bad_arrays_are_refused(tmp_path, array, mapped, parts):
    array = array * 10 if "1e308" in mapped else array
    sentence = refused(saved(tmp_path, x=array, zero=np.float64(0)), mapped, rate_hz=100)
    for part in parts:
        assert part in sentence


def test_missing_samples_are_nan_and_counted(tmp_path):
    x = np.where(np.arange(N) > 40, np.nan, NOISE[:, 0])
    x[3], x[4] = -np.inf, 1e200
    record = read_record(saved(tmp_path, x=x), ["omega=x"], rate_hz=100)
    np.testing.assert_array_equal(
        record.channels["omega"].values, np.where(np.abs(x) < 1e150, x, np.nan)
    )
    assert record.describe()[3].split()[4] == "11"


def test_requests_that_no_file_can_meet(tmp_path):
    path = saved(tmp_path, x=NOISE[:, 0])
    for rate in (0.0, -1.0, np.inf, np.nan):
        sentence = refusal(path, ["omega=x"], rate_hz=rate)
        assert sentence == f"--rate is {rate:g} Hz; it must be positive and finite"
    assert "'omega' is mapped 2 times" in refusal(path, ["omega=x", "omega=x*2"])
    assert "no channel is mapped" in refused(path)


def test_pickles_are_never_run(tmp_path):
    path = saved(tmp_path, x=np.array([{}, None], dtype=object), y=NOISE[:, 0])
    assert "'x' holds a pickle" in refused(path, "omega=x", rate_hz=1)
    np.testing.assert_array_equal(values(path, "omega=y", rate_hz=1), NOISE[:, 0])
    path.write_bytes(pickle.dumps({"x": [1.0, 2.0]}))
    assert "this is a pickle" in refused(path, "omega=x", rate_hz=1)


def test_other_archives_and_arrays(tmp_path):
    path = tmp_path / "log.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("notes.txt", "hello")
    assert "holds none with numbers (notes.txt: " in refused(path, "omega=x")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x.npy", "hello")
    assert "np.savez" in refused(path, "omega=x", rate_hz=1)
    with path.open("wb") as stream:
        np.save(stream, NOISE)
    assert "one array without a name" in refused(path, "omega=x")


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
@pytest.mark.parametrize("damage", ["cut", "flipped"])
def test_damaged_archives(tmp_path, save, damage):
    path = saved(tmp_path, save, x=NOISE[:, 0])
    data = bytearray(path.read_bytes())
    if damage == "cut":
        del data[len(data) // 2 :]
    else:
        data[200:260] = bytes(60)
    path.write_bytes(data)
    assert "the NPZ file is damaged" in refused(path, "omega=x", rate_hz=1)


def test_a_header_that_claims_too_much(tmp_path):
    path = tmp_path / "log.npz"
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (%d,), }" % 10**15
    data = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + bytes(80)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x.npy", data)
    assert "damaged" in refused(path, "omega=x", rate_hz=1)


def test_an_archive_that_unpacks_to_gigabytes(tmp_path, monkeypatch):
    monkeypatch.setattr("tuner.limits.UNPACKED", 1000)
    path = saved(tmp_path, np.savez_compressed, x=np.zeros(10_000))
    assert "would unpack to 0.0764 MB" in refused(path, "omega=x", rate_hz=1)


def test_checksum_of_a_large_file_is_that_of_its_bytes(tmp_path):
    array = np.random.default_rng(2).normal(size=(100_000, 2))
    path = saved(tmp_path, t=np.arange(100_000) / 1000, z=array)
    first = read_record(path, ["z=z"])
    assert path.stat().st_size > 1 << 20
    assert first.digest == hashlib.sha256(path.read_bytes()).hexdigest()
    array[70_000, 1] += 1e-12
    np.savez(path, t=np.arange(100_000) / 1000, z=array)
    assert read_record(path, ["z=z"]).digest != first.digest


def test_checksum_does_not_depend_on_what_is_read_of_a_file_nor_in_which_order(tmp_path):
    rows = np.arange(70_000)
    arrays = {"x": rows + 0.5, "unread": np.ones(5), "t": rows / 1000, "last": -rows}
    path = saved(tmp_path, **arrays)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    assert path.stat().st_size > 1 << 20
    for maps in (["z=x"], ["z=last"], ["a=last", "b=x"]):
        assert read_record(path, maps).digest == digest


@pytest.mark.parametrize("large", [False, True])
def test_one_bit_of_a_stored_array_is_noticed(tmp_path, large):
    path = saved(tmp_path, t=np.arange(100_000 if large else N) / 100, x=np.arange(N))
    data = bytearray(path.read_bytes())
    data[400] ^= 1
    path.write_bytes(data)
    with pytest.raises(LogError, match="Bad CRC-32 for file 't.npy'"):
        read_record(path, ["z=t"], time="t")


def test_a_file_that_is_refused_leaves_no_thread(tmp_path):
    path = saved(tmp_path, x=np.ones((70_000, 2)), t=np.zeros(70_000))
    before = threading.active_count()
    assert "stands still" in refused(path, "z=x")
    assert "no channel is mapped" in refused(path)
    for _ in range(100):
        if threading.active_count() == before:
            return
        time.sleep(0.05)
    raise AssertionError("a thread still computes a checksum")
