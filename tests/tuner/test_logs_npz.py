import pickle
import zipfile

import numpy as np
import pytest

from tuner.data.logs import LogError, describe, parse_mapping, read_log

CHANNELS = ("omega", "theta")
N = 50
NOISE = np.random.default_rng(1).normal(size=(N, 3))


def read(path, *maps, **options):
    return read_log(path, [parse_mapping(text, CHANNELS) for text in maps], **options)


def refusal(path, *maps, **options):
    with pytest.raises(LogError) as caught:
        read(path, *maps, **options)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("log.npz: ")
    return str(caught.value)


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
    log = read(path, "omega=gyr[2]*lsb:deg/s", "theta=angle*-2", rate_hz=200)
    np.testing.assert_array_equal(log.channels["omega"], counts[:, 2] * 0.05)
    np.testing.assert_array_equal(log.channels["theta"], NOISE[:, 1] * -2)
    assert all(values.flags.c_contiguous for values in log.channels.values())
    assert log.findings.rate_source == "--rate"
    assert log.findings.duration_s == pytest.approx((N - 1) / 200)


@pytest.mark.parametrize(
    "dtype", [np.int8, np.uint16, np.int32, np.int64, np.uint64, ">f8", np.longdouble, np.bool_]
)
def test_number_types(tmp_path, dtype):
    raw = np.arange(N).astype(dtype)
    values = read(saved(tmp_path, x=raw), "omega=x", rate_hz=1).channels["omega"]
    np.testing.assert_array_equal(values, raw.astype(float))


@pytest.mark.parametrize("dtype", [np.float16, np.float32])
def test_rounded_numbers_are_widened_and_said(tmp_path, dtype):
    log = read(saved(tmp_path, x=NOISE[:, 0].astype(dtype)), "omega=x", rate_hz=1)
    np.testing.assert_array_equal(log.channels["omega"], NOISE[:, 0].astype(dtype).astype(float))
    assert f"omega: {dtype.__name__}, widened" in describe(log)[-1]


@pytest.mark.parametrize("name", ["fs", "rate", "rate_hz", "sampling_rate", "Sample_Rate"])
def test_rate_from_a_scalar(tmp_path, name):
    log = read(saved(tmp_path, x=NOISE[:, 0], **{name: np.array([250])}), "omega=x")
    assert log.rate_hz == 250.0
    assert log.findings.rate_source == f"scalar '{name}'"


def test_one_column_needs_no_index(tmp_path):
    log = read(saved(tmp_path, x=NOISE[:, :1]), "omega=x", rate_hz=1)
    np.testing.assert_array_equal(log.channels["omega"], NOISE[:, 0])


def test_limit_cuts_arrays(tmp_path):
    path = saved(tmp_path, x=NOISE, t=np.arange(N) / 100)
    log = read(path, "omega=x[0]", limit=2)
    assert log.findings.samples == 2
    assert log.findings.duration_s == pytest.approx(0.01)


def test_the_format_is_told_by_the_bytes(tmp_path):
    path = saved(tmp_path, x=NOISE[:, 0]).rename(tmp_path / "log.csv")
    assert read(path, "omega=x", rate_hz=1).findings.samples == N


BAD = [
    (NOISE, "omega=x", ["shape (50, 3)", "x[0] to x[2]"]),
    (NOISE, "omega=x[3]", ["x[0] to x[2]"]),
    (NOISE[:, 0], "omega=x[0]", ["one-dimensional", "leave the index out"]),
    (NOISE.T, "omega=x[0]", ["(3, 50)", "transposed"]),
    (NOISE[..., None], "omega=x", ["3-dimensional"]),
    (np.float64(3), "omega=x", ["single number"]),
    (np.empty(0), "omega=x", ["0 rows", "at least 2"]),
    (np.full(N, 3.5), "omega=x", ["constant", "3.5"]),
    (NOISE[:, 0] * 1j, "omega=x", ["complex"]),
    (np.array(["a"] * N), "omega=x", ["text"]),
    (np.arange(N).astype("M8[ms]"), "omega=x", ["dates"]),
    (np.arange(N) + 2**53, "omega=x", ["beyond 2**53", "offset"]),
    (NOISE[:, 0], "omega=x*nothing", ["'nothing' is neither a number nor a scalar", "'x'"]),
    (NOISE[:, 0], "omega=x*x", ["'x' is neither a number nor a scalar"]),
    (NOISE[:, 0], "omega=y", ["no column 'y'", "'x', 'zero'"]),
    (NOISE[:, 0], "omega=x*zero", ["scalar 'zero' is 0"]),
    (NOISE[:, 0], "omega=1", ["no column '1'"]),
    (NOISE[:, 0], "omega=x*1e308", ["missing"]),
    (np.where(np.arange(N) > 40, np.nan, 1.0), "omega=x", ["9 rows", "row 41 (counted from 0)"]),
    (np.array([1.0, -np.inf, 2.0]), "omega=x", ["1 row,", "row 1 ", "cut them out or interp"]),
]


@pytest.mark.parametrize(("array", "mapped", "parts"), BAD, ids=[" ".join(b[2]) for b in BAD])
def test_bad_arrays_are_refused(tmp_path, array, mapped, parts):
    array = array * 10 if "1e308" in mapped else array
    sentence = refusal(saved(tmp_path, x=array, zero=np.float64(0)), mapped, rate_hz=100)
    for part in parts:
        assert part in sentence


def test_requests_that_no_file_can_meet(tmp_path):
    path = saved(tmp_path, x=NOISE[:, 0])
    for rate in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(LogError, match=r"--rate is .* positive and finite"):
            read(path, "omega=x", rate_hz=rate)
    with pytest.raises(LogError, match="'omega' is mapped 2 times"):
        read(path, "omega=x", "omega=x*2")
    with pytest.raises(LogError, match=r"limit is 1 sample; .* at least 2"):
        read(path, "omega=x", rate_hz=1, limit=1)
    assert "no channel is mapped" in refusal(path)


def test_columns_of_different_length(tmp_path):
    path = saved(tmp_path, x=NOISE[:, 0], y=NOISE[:40, 1])
    sentence = refusal(path, "omega=x", "theta=y", rate_hz=1)
    assert "'y' (mapped to theta) has 40 rows where 'x' has 50" in sentence


def test_pickles_are_never_run(tmp_path):
    path = saved(tmp_path, x=np.array([{}, None], dtype=object), y=NOISE[:, 0])
    assert "'x' holds a pickle" in refusal(path, "omega=x", rate_hz=1)
    assert read(path, "omega=y", rate_hz=1).findings.samples == N
    path.write_bytes(pickle.dumps({"x": [1.0, 2.0]}))
    assert "this is a pickle" in refusal(path, "omega=x", rate_hz=1)


def test_other_archives_and_arrays(tmp_path):
    path = tmp_path / "log.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("notes.txt", "hello")
    assert "no numpy arrays" in refusal(path, "omega=x")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x.npy", "hello")
    assert "np.savez" in refusal(path, "omega=x", rate_hz=1)
    with path.open("wb") as stream:
        np.save(stream, NOISE)
    assert "one array without a name" in refusal(path, "omega=x")


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
    assert "the NPZ file is damaged" in refusal(path, "omega=x", rate_hz=1)


def test_a_header_that_claims_too_much(tmp_path):
    path = tmp_path / "log.npz"
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (%d,), }" % 10**15
    data = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + bytes(80)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("x.npy", data)
    assert "damaged" in refusal(path, "omega=x", rate_hz=1)


def test_an_archive_that_unpacks_to_gigabytes(tmp_path, monkeypatch):
    monkeypatch.setattr("tuner.data.logs.npz._MAX_BYTES", 1000)
    path = saved(tmp_path, np.savez_compressed, x=np.zeros(10_000))
    assert "would unpack to 0.0 GiB" in refusal(path, "omega=x", rate_hz=1)
