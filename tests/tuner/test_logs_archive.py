import zipfile

import numpy as np
import pytest

from tests.tuner.recordings import refusal
from tuner.data.logs.formats import open_table
from tuner.data.reading import read_record

START = 1_709_132_400_123_456_789
GYRO = np.random.default_rng(5).normal(size=(300, 2)).round(6)


def sensor(rows, step_s, names, values):
    lines = [",".join(["time", "seconds_elapsed", *names])]
    for k in range(rows):
        cells = [START + round(k * step_s * 1e9), f"{k * step_s:.6f}", *values[k]]
        lines.append(",".join(map(str, cells)))
    return "\n".join(lines)


FILES = {
    "2024-02-28/Gyroscope.csv": sensor(300, 0.005, "zx", GYRO),
    "2024-02-28/Barometer.csv": sensor(4, 0.5, ["pressure"], [[961.2 + k] for k in range(4)]),
    "2024-02-28/Annotation.csv": "time,text\n",
}


def packed(folder, files, method=zipfile.ZIP_DEFLATED):
    path = folder / "phone.zip"
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return path


def unpacked(folder, files):
    home = folder / "phone"
    for name, text in files.items():
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).write_text(text)
    return home


@pytest.mark.parametrize("form", [packed, unpacked])
def test_one_file_a_sensor(tmp_path, form):
    path = form(tmp_path, FILES)
    record = read_record(path, ["omega=Gyroscope/x:rad/s", "p=Barometer/pressure:hPa"])
    omega, p = record.channels["omega"], record.channels["p"]
    np.testing.assert_array_equal(omega.values, GYRO[:, 1])
    np.testing.assert_allclose(p.values, 100 * (961.2 + np.arange(4)))
    assert (omega.rate_hz, p.rate_hz) == pytest.approx((200.0, 2.0), rel=1e-4)
    assert omega.clock.source == "column 'Gyroscope/time'"
    assert any("ns since 1970" in note for note in record.notes)
    assert "'2024-02-28/Annotation.csv' left out: no columns of numbers" in open_table(path).notes


def test_a_wrong_cell_has_its_file_and_line_named(tmp_path):
    wrong = FILES["2024-02-28/Gyroscope.csv"].replace(str(GYRO[7, 1]), "x")
    path = packed(tmp_path, FILES | {"2024-02-28/Gyroscope.csv": wrong})
    sentence = refusal(path, ["omega=Gyroscope/x"])
    assert "Gyroscope.csv" in sentence
    assert "line 9" in sentence


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("../../etc/x.csv", "leads out of it"),
        ("/etc/x.csv", "leads out of it"),
        ("C:/x.csv", "leads out of it"),
        ("inner.zip", "holds the archive 'inner.zip'"),
    ],
)
def test_suspicious_names(tmp_path, name, part):
    assert part in refusal(packed(tmp_path, {**FILES, name: "t,x\n0,1\n"}), ["omega=Gyroscope/x"])


def test_what_would_unpack_to_gigabytes_is_not_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr("tuner.limits.UNPACKED", 1 << 20)  # a smaller bomb is as hostile
    path = tmp_path / "bomb.zip"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("a.csv", "w", force_zip64=True) as member,
    ):
        for _ in range(30):
            member.write(bytes(1 << 20))
    assert path.stat().st_size < 1 << 17
    told = refusal(path, ["omega=x"])
    assert "would unpack to 30 MB from 0.0" in told
    assert "which no log does" in told


def test_what_declares_less_than_it_holds(tmp_path):
    path = packed(tmp_path, FILES)
    data = path.read_bytes()
    declared = len(FILES["2024-02-28/Gyroscope.csv"]).to_bytes(4, "little")
    assert data.count(declared) == 2  # beside the file, and in the directory
    path.write_bytes(data.replace(declared, (100).to_bytes(4, "little")))
    assert "the zip file is damaged" in refusal(path, ["omega=Gyroscope/x"])


def test_zips_without_logs(tmp_path):
    assert "holds none with numbers" in refusal(packed(tmp_path, {"a.txt": "hello"}), ["x=y"])
    empty = tmp_path / "empty"
    empty.mkdir()
    assert "there is none at all" in refusal(empty, ["x=y"])


BLACKBOX = '"Product","Blackbox flight data recorder by Nicholas Sherlock"\n"minthrottle","1070"\n'
ROWS = "".join(f"{k},{10**6 + 500 * k},{k % 7},ARM|ANGLE\n" for k in range(50))


@pytest.mark.parametrize(
    ("text", "time"),
    [
        (f'{BLACKBOX}"loopIteration","time","gyroADC[0]","flags"\n{ROWS}', "time"),
        (f"loopIteration, time (us), gyroADC[0], flags\n{ROWS}", "time (us)"),
        (f"H Product:Blackbox\nloopIteration,time (us),gyroADC[0],flags\n{ROWS}", "time (us)"),
    ],
)
def test_betaflight(tmp_path, text, time):
    path = tmp_path / "LOG00001.csv"
    path.write_text(text)
    gyro = read_record(path, ["omega=gyroADC[0]:deg/s"]).channels["omega"]
    np.testing.assert_allclose(gyro.values, np.deg2rad(np.arange(50) % 7))
    assert (gyro.rate_hz, gyro.clock.source) == (pytest.approx(2000.0), f"column {time!r}")
    assert "not a number" in refusal(path, ["omega=flags"])
    line = text.count("\n", 0, text.index("0,1000000")) + 1
    assert f"line {line}" in refusal(path, ["omega=flags"])


def test_raw_betaflight_is_named(tmp_path):
    path = tmp_path / "LOG00001.TXT"
    path.write_bytes(b"H Product:Blackbox flight data recorder\nH Data version:2\nI\x00\x81\xff")
    assert "decode it by blackbox_decode" in refusal(path, ["omega=x"])
    path.write_bytes(b"H Product:Blackbox flight data recorder\nH Data version:2\n")
    assert "no line of the Betaflight log names columns" in refusal(path, ["omega=x"])


def test_betaflight_without_loop_iterations(tmp_path):
    path = tmp_path / "export.csv"
    lines = [f"{1000 * k},{k},NaN" for k in range(20)]
    head = ['"Firmware revision","Betaflight 4.5.0"', '"time","gyroADC[0]","rcCommand[3]"']
    path.write_text("\n".join([*head, *lines]))
    assert read_record(path, ["w=gyroADC[0]:deg/s"]).channels["w"].rate_hz == pytest.approx(1000.0)
