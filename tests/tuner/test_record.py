import csv
import doctest
import hashlib
import importlib
import pkgutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import tuner.data
from tests.tuner.recordings import refusal
from tuner.data.reading import read_record, read_records
from tuner.data.record import Record

CASES = Path(__file__).parents[2].parent / "shared" / "cases"
cases = pytest.mark.skipif(not CASES.is_dir(), reason="no public cases beside the repository")
MODULES = [info.name for info in pkgutil.walk_packages(tuner.data.__path__, "tuner.data.")]
N = 60
RNG = np.random.default_rng(11)
GYR = RNG.normal(size=(N, 3))


def channel(unit, axes=()):
    """What a filter declares of a channel, as far as reading asks."""
    return SimpleNamespace(unit=unit, axes=axes)


INPUTS = {
    "gyr": channel("rad/s", ("x", "y", "z")),
    "acc": channel("m/s^2", ("x", "y", "z")),
    "mag": channel("unit", ("x", "y", "z")),
    "baro": channel("m"),
    "x": channel("m"),
    "y": channel("m"),
    "z": channel("unit"),
}
OUTPUTS = {"att": channel("", ("w", "x", "y", "z"))}


def written(folder, name="log.csv", **columns):
    path = folder / name
    lines = [",".join(columns)]
    for row in zip(*columns.values(), strict=True):
        lines.append(",".join("" if value is None else str(value) for value in row))
    path.write_text("\n".join(lines) + "\n")
    return path


def saved(folder, name="log.npz", **arrays):
    np.savez(folder / name, **arrays)
    return folder / name


@pytest.mark.parametrize("text", ["gyr=gx,gy,gz:deg/s", "gyr=1,2,3:deg/s", "gyr=gx*1,gy,gz:°/s"])
def test_vectors_of_columns_come_in_si(tmp_path, text):
    path = written(tmp_path, gx=GYR[:, 0], gy=GYR[:, 1], gz=GYR[:, 2])
    gyr = read_record(path, [text], inputs=INPUTS, rate_hz=50).channels["gyr"]
    np.testing.assert_allclose(gyr.values, np.radians(GYR), rtol=1e-15)
    np.testing.assert_allclose(gyr.times, np.arange(N) / 50, rtol=1e-15)
    assert (gyr.unit, gyr.values.flags.writeable) == ("rad/s", False)


def test_arrays_are_taken_whole_and_axes_may_be_turned(tmp_path):
    path = saved(tmp_path, gyro=GYR, quat=np.ones((N, 4)), fs=20.0)
    texts = ["gyr=gyro:rad/s", "acc=-gyro[1],gyro[0]*2,-gyro[2]*-1:g"]
    record = read_record(path, texts, truth=["att=quat"], inputs=INPUTS, outputs=OUTPUTS)
    np.testing.assert_array_equal(record.channels["gyr"].values, GYR)
    turned = np.stack([-GYR[:, 1], 2 * GYR[:, 0], GYR[:, 2]], axis=1) * 9.80665
    np.testing.assert_allclose(record.channels["acc"].values, turned, rtol=1e-15)
    assert record.truth["att"].values.shape == (N, 4)
    assert record.notes == ()
    assert record.sources[0].sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert (record.sources[0].samples, record.sources[0].rate_hz) == (N, 20.0)
    sentence = refusal(path, ["x=gyro:m"], inputs=INPUTS)
    assert "x is one number per sample, and 'gyro' is 3 columns" in sentence


def test_a_name_to_the_letter_goes_before_its_parts(tmp_path):
    path = tmp_path / "log.csv"
    rows = zip(GYR[:, 0], GYR[:, 1], GYR[:, 2], strict=True)
    lines = "".join(f"{a},{b},{c}\n" for a, b, c in rows)
    path.write_text('w[0],"a,b:c",-w\n' + lines)
    for text, column in (("z=w[0]", 0), ("z=a,b:c", 1), ("z=-w", 2), ("z=2", 1)):
        values = read_record(path, [text], inputs=INPUTS, rate_hz=1).channels["z"].values
        np.testing.assert_array_equal(values, GYR[:, column])


def test_what_is_missing_is_nan(tmp_path):
    z = [1.5, None, float("inf"), 1e300, 2.5]
    record = read_record(written(tmp_path, t=np.arange(5) / 10, z=z), ["z=z"], inputs=INPUTS)
    np.testing.assert_array_equal(record.channels["z"].values, [1.5, *[np.nan] * 3, 2.5])
    assert record.channels["z"].rate_hz == pytest.approx(2.5)  # two samples 0.4 s apart
    assert record.describe()[3].split()[4] == "3"


def test_what_was_taken_for_granted_is_said(tmp_path):
    arrays = {"gyro (deg/s)": GYR[:, 0], "h": GYR[:, 1].astype(np.float32), "p": 1e5 + GYR[:, 2]}
    maps = ["w=gyro (deg/s)", "baro=h", "x=p:Pa"]
    inputs = INPUTS | {"w": channel("rad/s")}
    record = read_record(saved(tmp_path, **arrays), maps, inputs=inputs, rate_hz=5)
    np.testing.assert_allclose(record.channels["w"].values, np.radians(GYR[:, 0]), rtol=1e-15)
    assert record.notes == (
        "w: deg/s, as the column's name says",
        "baro: float32, widened to float64; what was rounded away stays lost",
        "baro: no unit given, taken as m",
        "x: height in the standard atmosphere, from a pressure",
    )
    # The hydrostatic equation at 1000 hPa: 111 m up, so 288.15 K less 0.72 K.
    slope = np.polyfit(arrays["p"], record.channels["x"].values, 1)[0]
    assert slope == pytest.approx(-287.05287 * 287.43 / 9.80665 / 1e5, rel=1e-4)


@pytest.mark.parametrize(
    ("maps", "parts"),
    [
        (["gyr=gx,gy,gz:m/s^2"], ["'gx'", "m/s^2", "rad/s is needed"]),
        (["gyr=gx,gy,gz:def/s"], ["unknown unit 'def/s'", "deg/s"]),
        (["gyr=gx:rad/s"], ["gyr has 3 axes (x, y, z)", "1 column;"]),
        (["gyr=gx,gy:deg/s"], ["gyr has 3 axes (x, y, z)", "2 columns", "gyr=COLUMN,COLUMN,"]),
        (["x=gx,gy:m"], ["x is one number per sample", "2 columns"]),
        (["gyr=gx,gy,hz:deg/s"], ["no column 'hz'", "'gz'"]),
        (["gry=gx,gy,gz"], ["no known channel", "'gyr'"]),
        (["gyr=gx,gy,gz", "gyr=gx,gy,gz"], ["'gyr' is mapped 2 times"]),
        (["x=gx:lat"], ["latitude alone", ":lon"]),
        (["x=none"], ["'none'", "missing in all 60 rows"]),
        (["x,y=gx:m"], ["2 names and 1 columns"]),
        ([], ["no channel is mapped", "'gx'"]),
    ],
)
def test_bad_mappings_are_refused_in_one_sentence(tmp_path, maps, parts):
    path = written(tmp_path, gx=GYR[:, 0], gy=GYR[:, 1], gz=GYR[:, 2], none=[None] * N)
    sentence = refusal(path, maps, inputs=INPUTS, rate_hz=10)
    for part in parts:
        assert part in sentence


def test_files_that_share_the_columns_are_one_recording(tmp_path):
    times = np.arange(N) / 10
    imu = written(tmp_path, "imu.csv", t=times + 1000, gx=GYR[:, 0])
    gps = written(tmp_path, "gps.csv", t=times[::5] + 1000.03, px=GYR[::5, 1])
    record = read_record([imu, gps], ["z=gx", "x=px:m"], inputs=INPUTS)
    assert record.name == "imu.csv + gps.csv"
    assert [source.name for source in record.sources] == ["imu.csv", "gps.csv"]
    np.testing.assert_allclose(record.channels["x"].times, times[::5] + 0.03, atol=1e-9)
    assert record.channels["z"].times[0] == 0.0


def test_nanoseconds_of_two_files_keep_their_digits(tmp_path):
    start = 1_700_000_000_123_456_789
    one = saved(tmp_path, "one.npz", time=start + 10_000_000 * np.arange(9), a=np.arange(9.0))
    two = saved(tmp_path, "two.npz", time=start + 7 + 10_000_000 * np.arange(9), b=np.arange(9.0))
    record = read_record([one, two], ["z=a", "x=b:m"], inputs=INPUTS)
    np.testing.assert_allclose(
        record.channels["x"].times - record.channels["z"].times, 7e-9, rtol=1e-6
    )


def test_a_column_of_several_files_needs_its_file(tmp_path):
    names = ("a.csv", "b.csv")
    files = [
        written(tmp_path, name, t=np.arange(N) / 10, w=GYR[:, i]) for i, name in enumerate(names)
    ]
    extra = written(tmp_path, "c.csv", t=np.arange(N) / 10, v=GYR[:, 2])
    sentence = refusal([*files, extra], ["z=w", "x=v:m"], inputs=INPUTS)
    assert "'a.csv', 'b.csv'" in sentence
    assert "z=a.csv/w" in sentence
    record = read_record(files, ["z=b.csv/w", "x=a.csv/w:m"], inputs=INPUTS)
    np.testing.assert_array_equal(record.channels["z"].values, GYR[:, 1])
    assert "no file has the columns 'u'" in refusal(files, ["z=u"], inputs=INPUTS)
    assert "nothing is read from it" in refusal([*files, extra], ["z=b.csv/w", "x=a.csv/w"])
    assert "several recordings" in refusal(files, ["z=w"], inputs=INPUTS)


def test_files_that_all_have_all_are_recordings(tmp_path):
    paths = [written(tmp_path, f"{i}.csv", t=np.arange(N) / 10, w=GYR[:, i]) for i in range(3)]
    records = read_records(paths, ["z=w"], inputs=INPUTS)
    assert [record.name for record in records] == ["0.csv", "1.csv", "2.csv"]
    np.testing.assert_array_equal(records[2].channels["z"].values, GYR[:, 2])


@pytest.mark.parametrize("labels", [["b", "a"], [7, 3]])
def test_a_column_tells_recordings_apart(tmp_path, labels):
    who = np.resize(labels, N)
    path = written(tmp_path, t=np.repeat(np.arange(N // 2) / 10, 2), who=who, x=GYR[:, 0])
    records = read_records(path, ["x=x:m"], inputs=INPUTS, by="who")
    assert [record.name for record in records] == [f"log.csv: who {label}" for label in labels]
    for lane, record in enumerate(records):
        np.testing.assert_array_equal(record.channels["x"].values, GYR[lane::2, 0])
        np.testing.assert_allclose(record.channels["x"].times, np.arange(N // 2) / 10, atol=1e-12)
    assert "no column 'whom'" in refusal(
        path, ["x=x:m"], reader=read_records, inputs=INPUTS, by="whom"
    )


def test_one_recording_may_lack_a_channel_and_short_ones_are_left_out(tmp_path):
    path = written(tmp_path, t=[0, 0, 1, 1, 2], who=list("ababc"), x=[1, None, 2, None, 3])
    records = read_records(path, ["x=x:m"], inputs=INPUTS, by="who")
    assert [np.isnan(record.channels["x"].values).all() for record in records] == [False, True]
    assert records[0].notes == ("who: 1 value with one row alone left out",)
    assert "no value of 'number' has 2 rows" in refusal(
        written(tmp_path, "b.csv", number=[1, 2, 3], x=[1, 2, 3]),
        ["x=x"],
        reader=read_records,
        rate_hz=1,
        by="number",
    )


def test_lengths_of_one_file_need_clocks_of_their_own(tmp_path):
    arrays = {"a": GYR, "b": GYR[::2, 0], "t": np.arange(N) / 10}
    sentence = refusal(saved(tmp_path, **arrays), ["gyr=a", "x=b:m"], inputs=INPUTS, rate_hz=10)
    assert "'b' (mapped to x) has 30 rows where 'a' has 60" in sentence
    path = saved(tmp_path, **arrays, t_ms=np.arange(N // 2) * 200.0)
    record = read_record(path, ["gyr=a", "x=b:m"], inputs=INPUTS)
    np.testing.assert_allclose(record.channels["x"].times, np.arange(N // 2) / 5, atol=1e-12)


def test_clocks_that_restart_are_refused_with_the_way_out(tmp_path):
    path = written(tmp_path, t=np.r_[np.arange(30), np.arange(30)] / 10, w=GYR[:, 0])
    sentence = refusal(path, ["z=w"], inputs=INPUTS)
    assert "runs backwards by 2.9 s at line 32" in sentence
    assert "--by" in sentence


def test_records_of_arrays():
    truth = {"z": GYR[:30, 1]}
    record = Record.of(
        {"gyr": GYR, "z": GYR[:, 0]},
        times=5.0 + np.arange(N) / 20,
        units={"gyr": "deg/s"},
        truth=truth,
        truth_times=5.0 + np.arange(30) / 10,
        inputs=INPUTS,
    )
    np.testing.assert_allclose(record.channels["gyr"].values, np.radians(GYR), rtol=1e-15)
    assert record.channels["z"].times[0] == record.truth["z"].times[0] == 0.0
    assert repr(record).startswith("<Record 'arrays': gyr (60, 3) rad/s at 20 Hz, z (60,) - at 20")
    assert repr(record).endswith("; truth z (30,) - at 10 Hz>")
    assert len(record.describe()) == 7
    same = Record.of({"z": GYR[:, 0]}, rate_hz=20.0)
    assert same.digest == Record.of({"z": GYR[:, 0]}, rate_hz=20.0).digest != record.digest


@pytest.mark.parametrize(
    ("channels", "options", "part"),
    [
        ({}, {"rate_hz": 1.0}, "no channels"),
        ({"z": [1.0, 2.0]}, {}, "needs either a rate_hz or times"),
        ({"z": [1.0, 2.0]}, {"rate_hz": 0.0}, "must be positive"),
        ({"z": [1.0, 2.0]}, {"times": [0.0, 0.0]}, "do not rise at row 1"),
        ({"z": [1.0, 2.0]}, {"times": [0.0]}, "give as many"),
        ({"z": [np.nan, np.nan]}, {"rate_hz": 1.0}, "missing in all 2"),
        ({"z": 1.0}, {"rate_hz": 1.0}, "shape ()"),
        ({"z": [1.0, 2.0]}, {"rate_hz": 1.0, "units": {"y": "m"}}, "unit of 'y'"),
        ({"x": [1.0, 2.0]}, {"rate_hz": 1.0, "units": {"x": "g"}, "inputs": INPUTS}, "m is needed"),
        ({"w": [1.0, 2.0]}, {"rate_hz": 1.0, "inputs": INPUTS}, "no channel 'w'"),
    ],
)
def test_bad_arrays_are_refused(channels, options, part):
    assert part in refusal(channels, reader=Record.of, **options)


@pytest.mark.parametrize("name", MODULES)
def test_examples_in_docstrings(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_reading_is_light():
    heavy = "{'jax', 'scipy', 'h5py', 'matplotlib'}"
    modules = (
        "tuner.data.reading, tuner.data.merge, tuner.data.plausibility, tuner.data.description"
    )
    code = f"import sys, {modules}; sys.exit(bool({heavy} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@settings(
    max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.lists(st.floats(-1e5, 1e5), min_size=2, max_size=20))
def test_degrees_and_radians_are_one_reading(tmp_path, values):
    degrees, radians = np.array(values), np.radians(values)
    path = saved(tmp_path, d=degrees, r=radians)
    one = read_record(path, ["w=d:deg/s"], inputs={"w": channel("rad/s")}, rate_hz=9)
    other = read_record(path, ["w=r:rad/s"], inputs={"w": channel("rad/s")}, rate_hz=9)
    np.testing.assert_allclose(one.channels["w"].values, other.channels["w"].values, rtol=1e-15)


def columns_of(path, delimiter=","):
    """A text log by the standard library alone; empty cells are NaN."""
    with path.open() as stream:
        header, *rows = csv.reader(stream, delimiter=delimiter)
    cells = np.array([[float(cell or "nan") for cell in row] for row in rows])
    return dict(zip(header, cells.T, strict=True))


@cases
def test_vario():
    path = CASES / "vario" / "vario.csv"
    raw = columns_of(path, ";")
    record = read_record(path, ["acc=acc_up_ms2:m/s^2", "baro=baro_m:m"])
    np.testing.assert_array_equal(record.channels["acc"].values, raw["acc_up_ms2"])
    np.testing.assert_array_equal(record.channels["baro"].values, raw["baro_m"])
    assert record.channels["baro"].rate_hz == pytest.approx(10)
    np.testing.assert_allclose(record.channels["acc"].times, raw["t_ms"] / 1000, atol=1e-9)


@cases
def test_degrees_become_metres_from_the_first_fix():
    path = CASES / "gps-accuracy" / "track.csv"
    raw = columns_of(path)
    maps = ["x,y=latitude,longitude:lat,lon", "accuracy=accuracy:m"]
    record = read_record(path, maps)
    lat, lon = np.radians(raw["latitude"]), np.radians(raw["longitude"])
    a, e2 = 6378137.0, 6.69437999014e-3  # the formulas of the case, at the first fix
    w = 1 - e2 * np.sin(lat[0]) ** 2
    north = (lat - lat[0]) * a * (1 - e2) / w**1.5
    east = (lon - lon[0]) * a / np.sqrt(w) * np.cos(lat[0])
    # The last digit of a longitude in rad is 3e-17, which is 2e-10 m; both sides round twice.
    np.testing.assert_allclose(record.channels["x"].values, north, atol=1e-8)
    np.testing.assert_allclose(record.channels["y"].values, east, atol=1e-8)
    times = (raw["time"] - raw["time"][0]) / 1000
    np.testing.assert_allclose(record.channels["x"].times, times, rtol=1e-12)
    assert "time 'time': taken as ms since 1970" in record.notes


@cases
def test_recordings_of_one_file():
    path = CASES / "several-tracks" / "tracks.csv"
    raw = columns_of(path)
    assert "stands still at line 367" in refusal(path, ["x=x:m"])
    records = read_records(path, ["x=x:m"], by="track_id")
    assert len(records) == 20
    for record in records:
        mine = raw["track_id"] == float(record.name.split()[-1])
        np.testing.assert_array_equal(record.channels["x"].values, raw["x"][mine])


@cases
@pytest.mark.parametrize(
    ("name", "maps", "rate"),
    [
        ("nis-check/track1d.csv", "z=x:m", 1.0),
        ("level-pressure/pressure.csv", "z=pressure_Pa:Pa", 12.5),
        ("log-phone-zip/Gyroscope.csv", "z=x:rad/s", 201.6),
        ("log-phone-zip/GyroscopeBursts.csv", "z=x:rad/s", 201.6),
        ("tiny-units/ampere.csv", "z=Current [A]", 50.0),
    ],
)
def test_other_logs(name, maps, rate):
    path = CASES / name
    raw = columns_of(path, ";" if "ampere" in name else ",")
    record = read_record(path, [maps], inputs=INPUTS)
    np.testing.assert_array_equal(record.channels["z"].values, raw[maps[2:].partition(":")[0]])
    assert record.channels["z"].rate_hz == pytest.approx(rate, rel=1e-3)


@cases
def test_columns_with_brackets_in_their_names():
    path = CASES / "log-ulog2csv" / "log_sensor_combined_0.csv"
    maps = ["gyr=gyro_rad[0],gyro_rad[1],gyro_rad[2]:rad/s"]
    assert "'timestamp:us' (199.9 Hz)" in refusal(path, maps, inputs=INPUTS)
    gyr = read_record(path, maps, inputs=INPUTS, time="timestamp:us").channels["gyr"]
    np.testing.assert_array_equal(gyr.values[:, 2], columns_of(path)["gyro_rad[2]"])


@cases
@pytest.mark.parametrize("name", ["Messung_01.csv", "Messung_utf8bom.csv"])
def test_a_german_logger(name):
    record = read_record(CASES / "log-german-logger" / name, ["z=Temperatur [°C]"], rate_hz=1 / 30)
    z = record.channels["z"]
    # As printed in the case, which has the numbers from the generator.
    assert (len(z.values), z.unit) == (500, "°C")
    assert z.values.mean() == pytest.approx(21.8347, abs=5e-5)
    assert z.values.std() == pytest.approx(0.25716, abs=5e-6)


@cases
def test_arrays_with_truth_at_half_the_rate():
    path = CASES / "madgwick-beta" / "imu_mocap.npz"
    record = read_record(
        path,
        ["gyr=gyr:rad/s", "acc=acc:m/s^2"],
        truth=["att=quat"],
        inputs=INPUTS,
        outputs=OUTPUTS,
    )
    with np.load(path) as raw:
        np.testing.assert_array_equal(record.channels["acc"].values, raw["acc"])
        np.testing.assert_array_equal(record.truth["att"].values, raw["quat"])
    assert record.truth["att"].rate_hz == pytest.approx(25)
