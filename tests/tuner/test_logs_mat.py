import sys

import numpy as np
import pytest

from tests.tuner.recordings import refusal, values
from tuner.data.reading import read_record

N = 40
NOISE = np.random.default_rng(2).normal(size=(N, 3))


def refused(path, text):
    sentence = refusal(path, [text])
    assert sentence.startswith("log.mat: ")
    return sentence


CONTENT = {
    "gyr": NOISE,
    "row": NOISE[:, 0][None, :],
    "column": NOISE[:, 1][:, None],
    "fs": np.array([[50.0]]),
    "imu": {"acc": NOISE * 2, "scale": np.array([[0.5]])},
    "counts": np.arange(N, dtype=np.int16)[:, None],
    "single": NOISE.astype(np.float32),
}


def save5(folder, content):
    from scipy.io import savemat

    path = folder / "log.mat"
    savemat(path, {**content, "note": "recorded at rest", "nothing": np.empty((0, 0))})
    return path


def save73(folder, content):
    """As MATLAB writes it: a header of 512 bytes, axes reversed, classes as attributes."""
    h5py = pytest.importorskip("h5py")
    path = folder / "log.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in content.items():
            parts = value if isinstance(value, dict) else {"": value}
            for field, array in parts.items():
                file[f"{name}/{field}".rstrip("/")] = array.T
        note = file.create_dataset("note", data=np.array([[104], [105]], dtype=np.uint16))
        note.attrs["MATLAB_class"] = np.bytes_(b"char")
        nothing = file.create_dataset("nothing", data=np.zeros(2, dtype=np.uint64))
        nothing.attrs["MATLAB_empty"] = np.uint8(1)
        file.create_group("#refs#")["a"] = np.ones(3)
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(512))
    return path


@pytest.fixture(params=[save5, save73], ids=["v5", "v7.3"])
def save(request):
    return request.param


@pytest.mark.parametrize(
    ("column", "expected"),
    [
        ("gyr", NOISE),
        ("gyr[2]", NOISE[:, 2]),
        ("row", NOISE[:, 0]),
        ("column", NOISE[:, 1]),
        ("imu.acc[1]*imu.scale", NOISE[:, 1]),
        ("counts", np.arange(N)),
        ("single[0]", NOISE[:, 0].astype(np.float32)),
    ],
)
def test_both_versions_agree(tmp_path, save, column, expected):
    record = read_record(save(tmp_path, CONTENT), [f"omega={column}"])
    omega = record.channels["omega"]
    np.testing.assert_array_equal(omega.values, expected)
    assert omega.values.flags.c_contiguous
    assert (omega.clock.source, record.sources[0].rate_hz) == ("scalar 'fs'", 50.0)


@pytest.mark.parametrize(
    ("column", "parts"),
    [
        ("gyr,row", ["shape (40, 3)", "gyr[0] to gyr[2]"]),
        ("nothing", ["0 rows"]),
        ("imu", ["no column 'imu'", "'imu.acc'"]),
        ("fs", ["single number"]),
    ],
)
def test_bad_columns(tmp_path, save, column, parts):
    sentence = refused(save(tmp_path, CONTENT), f"omega={column}")
    for part in parts:
        assert part in sentence


def test_time_inside_a_struct(tmp_path, save):
    content = {"imu": {"gyr": NOISE, "t_ms": 10.0 * np.arange(N)[:, None]}, "t": np.ones((1, 3))}
    omega = read_record(save(tmp_path, content), ["omega=imu.gyr[0]"]).channels["omega"]
    assert omega.clock.source == "column 'imu.t_ms'"
    assert omega.rate_hz == pytest.approx(100)


def test_damaged_files(tmp_path, save):
    path = save(tmp_path, CONTENT)
    path.write_bytes(path.read_bytes()[:900])
    assert "file is damaged" in refused(path, "omega=gyr[0]")


def test_files_without_arrays(tmp_path):
    from scipy.io import savemat

    savemat(tmp_path / "log.mat", {})
    assert "no arrays" in refused(tmp_path / "log.mat", "omega=gyr[0]")


def test_text_in_version_5(tmp_path):
    assert "holds text" in refused(save5(tmp_path, CONTENT), "omega=note")


def test_without_h5py_the_extra_is_named(tmp_path, monkeypatch):
    path = save73(tmp_path, CONTENT)
    monkeypatch.setitem(sys.modules, "h5py", None)
    assert "pip install 'filter-tuner[mat73]'" in refused(path, "omega=gyr[0]")


def test_plain_hdf5_and_numbers_as_text(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "log.mat", "w") as file:
        file["x.y"] = NOISE[:, 0]
    np.testing.assert_array_equal(values(tmp_path / "log.mat", "omega=x.y", rate_hz=1), NOISE[:, 0])
    np.savetxt(tmp_path / "log.mat", NOISE)  # as MATLAB's save -ascii does
    np.testing.assert_array_equal(values(tmp_path / "log.mat", "omega=3", rate_hz=1), NOISE[:, 2])
