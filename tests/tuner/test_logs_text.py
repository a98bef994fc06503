"""Text logs as their programs write them: letters, heads, units, notations, kinds of rows."""

import gzip
import struct
from datetime import datetime, timedelta

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.tuner.recordings import refusal
from tuner.data.logs.cells import is_number
from tuner.data.logs.csv import open_csv
from tuner.data.logs.table import Loaded
from tuner.data.reading import read_record, read_records

X = [1.5, -2.25, 1234.5, 0.001, -7.0, 3.0]
ROWS = "".join(f"{k * 0.01:.2f},{x}\n" for k, x in enumerate(X))
LOG = "t,x\n" + ROWS
GERMAN = "t;x\n" + ROWS.replace(",", ";").replace(".", ",")


def written(folder, text, name="log.csv"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def read(folder, text, mapping="z=x", **options):
    record = read_record(written(folder, text), [mapping], **options)
    return record.channels["z"], "\n".join(record.describe())


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (LOG.encode("utf-8-sig"), ""),
        (LOG.encode("utf-16"), "letters read as utf-16-le"),
        (b"\xfe\xff" + LOG.encode("utf-16-be"), "letters read as utf-16-be"),
        (LOG.encode("utf-16-le"), "letters read as utf-16-le"),
        ("Gerät 7°\n".encode("cp1252") + LOG.encode(), "letters read as cp1252"),
        (LOG.replace("\n", "\r").encode(), ""),
        ("Device;X,Y\n\nSerial,1,2\nMode\n" + LOG, "3 lines above the columns left out"),
        ("# a\n\n% b\n" + LOG, ""),
        (GERMAN, "decimal commas"),
        (GERMAN.replace("1234,5", "1.234,5"), "x: '.' between thousands in 1 cell"),
        (LOG.replace(",", ";").replace("1234.5", "1,234.5"), "x: ',' between thousands"),
        (LOG.replace("\n0.02", "\nt,x\n0.02"), "1 repeated head left out"),
        (LOG.replace("\n0.02", "\n# pause\n0.02"), ""),
        (LOG + "0.06,", "1 cut last line left out"),
        (LOG + "0.06", "1 cut last line left out"),
        (LOG + "end of log\n", "1 line without a number at the end left out"),
        ('"t","x"\n' + "".join(f'"{r.replace(",", chr(34) + "," + chr(34))}"\n'
                               for r in ROWS.splitlines()), ""),
        (LOG.replace("1.5", "0x10"), "x: hexadecimal in 1 cell"),
    ],
)  # fmt: skip
def test_what_is_found_is_read_and_told(tmp_path, text, told):
    z, lines = read(tmp_path, text)
    if "0x10" in str(text) or text == LOG + "0.06,":
        return
    np.testing.assert_array_equal(z.values, X)
    assert z.rate_hz == pytest.approx(100)
    assert told in lines


@pytest.mark.parametrize("word", ["NaN", "NA", "null", "-", "--", "#N/A", "", "n/a", "nan"])
def test_words_for_nothing(tmp_path, word):
    z, lines = read(tmp_path, LOG.replace("-2.25", word))
    np.testing.assert_array_equal(z.values, [np.nan if x == -2.25 else x for x in X])
    plain = word.lower() in ("nan", "")
    assert plain or f"x: {word!r} taken as missing in 1 cell" in lines


def test_two_readings_of_a_comma_are_named(tmp_path):
    text = "t;x\n" + "".join(f"{k};1,{k + 234}\n" for k in range(6))
    z, lines = read(tmp_path, text)
    assert z.values[0] == 1.234
    assert "'1,234' read as 1.234; where it is 1234, map it as COLUMN*1000" in lines


@pytest.mark.parametrize("row", ["ms,deg/s,m/s^2", "(ms),(deg/s),(m/s^2)", "[ms],[deg/s],"])
def test_a_row_of_units(tmp_path, row):
    rows = "".join(f"{10 * k},{x},9.8\n" for k, x in enumerate(X))
    z, lines = read(tmp_path, f"time,gyro,acc\n{row}\n{rows}", "z=gyro")
    np.testing.assert_allclose(z.values, np.radians(X))
    assert z.rate_hz == pytest.approx(100)
    assert "units as the row below the names says: time ms, gyro deg/s" in lines


@pytest.mark.parametrize(
    ("name", "mapping", "unit"),
    [
        ("gyro_rad[2]", "z=gyro_rad[2]", ""),
        ("Temperatur [°C]", "z=Temperatur [°C]", "°C"),
        ("Voltage(V)", "z=Voltage(V)", "V"),
        ('"gyro, x"', "z=gyro, x:rad/s", "rad/s"),
        ('"a, b [m]"', "z=a, b [m]", "m"),
    ],
)
def test_names_to_the_letter(tmp_path, name, mapping, unit):
    z, _ = read(tmp_path, f"t,{name}\n{ROWS}", mapping)
    np.testing.assert_array_equal(z.values, X)
    assert z.unit == unit


def mixed(samples):
    for k in range(samples):
        yield f"IMU,{10 * k},{k % 7},0.5\n"
        if k % 10 == 3:
            yield f"GPS,{10 * k},{k % 3},8.25,4\n"


@pytest.mark.parametrize(
    ("head", "maps", "time"),
    [
        ("", ("z=IMU/3", "p=GPS/column3"), "2:ms"),
        ("IMU,t_ms,gx,gy\nGPS,t_ms,n,e,fix\n", ("z=IMU/gx", "p=GPS/n"), None),
        ("kind,t_ms,gx,gy\nkind,t_ms,n,e,fix\n", ("z=IMU/gx", "p=GPS/n"), "t_ms"),
    ],
)
def test_rows_of_several_kinds(tmp_path, head, maps, time):
    path = written(tmp_path, head + "".join(mixed(60)))
    record = read_record(path, maps, time=time)
    np.testing.assert_array_equal(record.channels["z"].values, np.arange(60) % 7)
    np.testing.assert_array_equal(record.channels["p"].values, np.arange(3, 60, 10) % 3)
    rates = [record.channels[name].rate_hz for name in "zp"]
    assert rates == pytest.approx([100, 10])
    assert record.channels["p"].times[0] - record.channels["z"].times[0] == pytest.approx(0.03)


def test_a_kind_that_comes_late(tmp_path):
    rows = list(mixed(30_000))
    late = [row for k, row in enumerate(rows) if k > 32_000 or row.startswith("IMU")]
    record = read_record(written(tmp_path, "".join(late)), ["z=IMU/3", "p=GPS/3"], time="2:ms")
    assert len(record.channels["z"].values) == 30_000
    assert record.channels["p"].rate_hz == pytest.approx(10)


def test_rows_of_one_width_by_a_word(tmp_path):
    rows = "".join(f"GYR,{k / 100},{k % 5}\nACC,{k / 100},{9 + k % 3}\n" for k in range(40))
    path = written(tmp_path, f"sensor,t,x\n{rows}")
    record = read_record(path, ["z=GYR/x", "a=ACC/x"])
    np.testing.assert_array_equal(record.channels["z"].values, np.arange(40) % 5)
    np.testing.assert_array_equal(record.channels["a"].values, 9 + np.arange(40) % 3)
    assert len(read_records(path, ["z=x"], by="sensor")) == 2


@pytest.mark.parametrize(
    ("text", "part"),
    [
        (b"t,x\n0,\0\0\n1,2\n", "neither text nor of a known format"),
        (LOG.encode() * 9999 + b"1,\0\0\n2,3\n", "holds '\\x00\\x00', not a number"),
        (b"t,x\n0,1\n" + b"1" * (17 << 20), "a line is longer than 16 MB"),
        (",".join(map(str, range(110_000))) + "\n", "110000 cells; at most 100000"),
        (gzip.compress(LOG.encode())[:-9], "cannot be read"),
        ("\n".join(",".join("1" * (1 + 7 * k % 11)) for k in range(99)), "cells instead of"),
        ("some words, and more\nof them, here\n" * 9, "not one row of numbers"),
        ("a,b\n1,2,3\n4,5,6\n", "line 1 names 2 columns, and the rows below have 3 cells"),
        ("t,x\n" + "0,1,2,3\n" * 9, "a comma that is the decimal mark too"),
        (LOG.replace("\n0.03", "\nGPS,1,2\n0.03"), "line 5 has 3 cells instead of 2"),
    ],
    ids=lambda value: value[:20] if isinstance(value, str) else "",
)
def test_bad_files_end_in_a_sentence(tmp_path, text, part):
    assert part in refusal(written(tmp_path, text), ["z=2"], rate_hz=1)


def test_what_unpacks_to_more_than_a_log_does(tmp_path, monkeypatch):
    monkeypatch.setattr("tuner.limits.UNPACKED", 1 << 20)  # a smaller bomb is as hostile
    bomb = gzip.compress(b"t,x\n" + b"0,1\n" * (1 << 20), 9)
    assert "unpack to more than 1 MB; a log does" in refusal(written(tmp_path, bomb), ["z=2"])


def test_a_kind_without_numbers_is_told(tmp_path):
    rows = [*mixed(60)]
    text = "".join([*rows[:20], "MSG,armed,by hand\n", *rows[20:]])
    record = read_record(written(tmp_path, text), ["z=IMU/3"], rate_hz=100)
    assert "rows of 'MSG' left out: no numbers" in record.notes


def bits(number):
    return struct.pack("d", number)


notations = st.sampled_from(
    [repr, "{:.3f}".format, "{:.17g}".format, "{:+.9e}".format, "{:g}".format]
)
doubles = st.floats(allow_nan=False, allow_infinity=False)
plain = st.builds(lambda form, number: form(number), notations, doubles | st.floats(-1e6, 1e6))
digits = st.from_regex(r"[-+]?[0-9]{0,25}(\.[0-9]{0,25})?([eE][-+]?[0-9]{1,3})?", fullmatch=True)
digits = digits.filter(is_number)


@settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(cells=st.lists(plain | digits, min_size=2, max_size=40))
def test_every_number_is_the_double_that_python_reads(tmp_path, cells):
    right = [float(cell) for cell in cells]
    path = written(tmp_path, "".join(f"0,{cell}\n" for cell in cells))
    found = Loaded.of(open_csv(path).load(["column2"])).raw["column2"]
    assert [*map(bits, found.astype(float).tolist())] == [*map(bits, right)]


START = datetime(2024, 3, 30, 23, 59, 58)


@pytest.mark.parametrize(
    ("form", "step"),
    [
        ("%Y-%m-%dT%H:%M:%S.%fZ", 0.5),
        ("%Y-%m-%d %H:%M:%S.%f+02:00", 0.5),
        ("%d.%m.%Y %H:%M:%S", 30),
        ("%d.%m.%Y;%H:%M:%S", 30),
        ("%m/%d/%Y;%I:%M:%S %p", 30),
        ("%d-%b-%Y %H:%M:%S", 1),
        ("%Y%m%d-%H%M%S", 1),
        ("%H:%M:%S.%f", 0.25),
        ("%b %d, %Y %H:%M:%S", 1),
    ],
)
def test_dates_and_times_of_day(tmp_path, form, step):
    times = [START + timedelta(seconds=step * k) for k in range(80)]
    names = "Datum;Uhrzeit" if ";" in form else "zeitpunkt"
    text = f"{names};x\n" + "".join(f"{t.strftime(form)};{k}\n" for k, t in enumerate(times))
    z, _ = read(tmp_path, text)
    np.testing.assert_allclose(z.times, step * np.arange(80), atol=1e-9)


def test_zones_change_and_times_go_on(tmp_path):
    times = ["01:59:59+02:00", "03:00:00+03:00", "03:00:01+03:00"]
    text = "time,x\n" + "".join(f"2024-03-31T{t},{k}\n" for k, t in enumerate(times))
    z, _ = read(tmp_path, text)
    assert z.times.tolist() == [0, 1, 2]


def test_day_and_month_are_chosen_by_the_user(tmp_path):
    path = written(tmp_path, "Date,Time,x\n" + "".join(
        f"0{1 + k // 5}/04/2024,{12 + k % 5}:00:00,{k}\n" for k in range(10)
    ))  # fmt: skip
    sentence = refusal(path, ["z=x"])
    assert "'01/04/2024', day, month, year (:dmy) or month, day, year (:mdy)" in sentence
    assert "--time 'Date:dmy,Time'" in sentence
    days = [
        read_record(path, ["z=x"], time=f"Date:{order},Time").channels["z"].times[5] / 86_400
        for order in ("dmy", "mdy")
    ]
    assert days == [1, 31]


def test_one_day_has_the_same_steps_in_either_order(tmp_path):
    z, lines = read(tmp_path, "time,x\n" + "".join(f"03/04/2024 10:00:0{k},1\n" for k in range(6)))
    assert z.rate_hz == 1
    assert "may be day, month, year (:dmy) or month, day, year (:mdy), with the same steps" in lines


def test_two_numbers_and_a_colon(tmp_path):
    text = "time,x\n" + "".join(f"00:{k:02d},{k}\n" for k in range(9))
    assert "hours and minutes (:h-min) or minutes and seconds (:min-s)" in refusal(
        written(tmp_path, text), ["z=x"]
    )
    assert read(tmp_path, text, time="time:min-s")[0].rate_hz == 1
    assert read(tmp_path, text, time="time:h-min")[0].times[1] == pytest.approx(60)


def test_far_more_lines_above_than_rows(tmp_path):
    lines = [f"property {k}, value" for k in range(300)]
    rows = [f"{0.01 * k:.2f},{k % 3}" for k in range(30)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([*lines, "t,x", *rows]))
    record = read_record(path, ["z=x"])
    assert record.channels["z"].values.tolist() == [k % 3 for k in range(30)]
    assert "300 lines above the columns left out" in record.notes


def test_a_lost_page_is_a_line(tmp_path):
    rows = "".join(f"{0.01 * k:.2f},{k % 3},1\n" for k in range(200))
    path = tmp_path / "log.csv"
    path.write_text("t,x,y\n" + rows + "\0" * 64 + "\n" + rows)
    assert "line 202 has 1 cell instead of 3" in refusal(path, ["z=x"])
