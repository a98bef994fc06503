import gzip
import hashlib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tuner.data.logs import LogError, parse_mapping, read_log

CHANNELS = ("omega", "theta")
ROWS = ((0.00, 1.5, -3.0), (0.01, 2.5, -2.0), (0.02, 0.5, -4.0), (0.03, 1.0, 1e-3))


def read(path, *maps, **options):
    return read_log(path, [parse_mapping(text, CHANNELS) for text in maps], **options)


def refusal(path, *maps, **options):
    with pytest.raises(LogError) as caught:
        read(path, *maps, **options)
    assert "\n" not in str(caught.value)
    assert str(path.parent) not in str(caught.value)
    return str(caught.value)


def written(folder, text, name="log.csv"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def table(delimiter, header=("t", "gx", "ang"), rows=ROWS):
    lines = [delimiter.join(header)] if header else []
    return "\n".join([*lines, *(delimiter.join(map(repr, row)) for row in rows)]) + "\n"


@pytest.mark.parametrize("delimiter", [",", ";", "\t", " ", "   ", ", ", " ; "])
@pytest.mark.parametrize("header", [("t", "gx", "ang"), None])
def test_delimiters_and_headers(tmp_path, delimiter, header):
    path = written(tmp_path, table(delimiter, header))
    maps = ("omega=gx:deg/s", "theta=ang") if header else ("omega=2:deg/s", "theta=column3")
    log = read(path, *maps, rate_hz=100)
    np.testing.assert_array_equal(log.channels["omega"], [row[1] for row in ROWS])
    np.testing.assert_array_equal(log.channels["theta"], [row[2] for row in ROWS])
    assert log.units == {"omega": "deg/s", "theta": ""}
    assert log.name == "log.csv"
    assert log.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


def test_channels_are_contiguous_read_only_float64(tmp_path):
    values = read(written(tmp_path, table(",")), "omega=gx*2").channels["omega"]
    assert values.dtype == np.float64
    assert values.flags.c_contiguous
    assert not values.flags.writeable
    np.testing.assert_array_equal(values, [3.0, 5.0, 1.0, 2.0])


@pytest.mark.parametrize(
    "text",
    [
        "\N{ZERO WIDTH NO-BREAK SPACE}" + table(","),
        "# recorded today\n% by a logger\n\n" + table(","),
        table(",").replace("\n", "\r\n"),
        table(",").replace("\n", "\n\n"),
        table(",").replace("0.02,", "# a pause\n0.02,"),
        table(",").replace("gx", '"gx"'),
        table(",").replace("t,gx", " t , gx "),
        "# t,gx,ang\n" + table(",", header=None),
        table(";").replace(".", ","),
        "Messung: 7\nsep=;\n" + table(";").replace(".", ","),
        ("Ger\N{LATIN SMALL LETTER A WITH DIAERESIS}t 7\n" + table("\t")).encode("cp1252"),
        table(",", ("t", "gx", "ang", "mode"), [(*row, "on") for row in ROWS]),
        table(",", ("t", "gx", "ang", "ang"), [(*row, 7) for row in ROWS]),
    ],
    ids=[
        "bom",
        "comments",
        "crlf",
        "blank-lines",
        "comment-inside",
        "quotes",
        "blanks",
        "savetxt",
        "decimal-comma",
        "titles",
        "cp1252",
        "text",
        "twice",
    ],
)
def test_variants_of_one_file(tmp_path, text):
    log = read(written(tmp_path, text), "omega=gx")
    np.testing.assert_array_equal(log.channels["omega"], [row[1] for row in ROWS])
    assert log.rate_hz == pytest.approx(100)
    assert log.findings.time_column == "t"


def test_compressed_whatever_its_name(tmp_path):
    path = written(tmp_path, gzip.compress(table(",").encode()), "log.csv")
    assert read(path, "omega=gx").findings.samples == len(ROWS)


def test_limit_stops_before_what_follows(tmp_path):
    path = written(tmp_path, table(",") + "0.04,broken,1\n")
    assert read(path, "omega=gx", limit=3).findings.samples == 3
    assert "line 6" in refusal(path, "omega=gx")


def test_a_damaged_first_row_does_not_pass_for_a_header(tmp_path):
    path = written(tmp_path, table(",", header=None).replace("1.5", "l.5", 1))
    assert "line 1, column 'column2' holds 'l.5'" in refusal(path, "omega=2")


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("", ["log.csv", "empty"]),
        ("\n\n# nothing\n", ["not one row"]),
        ("t,gx,ang\n", ["not one row"]),
        ("t,gx,ang\n0,1,2\n", ["1 row;", "at least 2"]),
        (table(",").replace("2.5", "abc"), ["line 3", "'gx'", "'abc'", "correct it"]),
        ("# a\n\n" + table(",").replace("2.5", "x" * 99), ["line 5", "xxx...'"]),
        (table(",").replace(",2.5", ""), ["line 3", "2 cells instead of 3", "complete"]),
        (table(",").replace("2.5", "2.5,9"), ["line 3", "4 cells instead of 3"]),
        (table(" ").replace(" 2.5", ""), ["line 3", "2 cells instead of 3"]),
        (table(",").replace("2.5", ""), ["'gx'", "omega", "1 row,", "line 3", "interpolate"]),
        (table(",").replace("2.5", " ").replace("0.5", "nan"), ["2 rows, first at line 3"]),
        (table(",").replace("2.5", "inf"), ["missing", "line 3"]),
        (table(",").replace("2.5", "1.7976931348623157e308"), ["beyond 1e150", "line 3"]),
        (table(";").replace("2.5", "2,5"), ["line 3", "'2,5'", "decimal points"]),
        (b"\x00\x01\x02\x03" * 50, ["neither UTF-8 text nor NPZ nor MAT"]),
        (gzip.compress(table(",").encode() * 500, mtime=0)[:-20], ["cannot be read", "again"]),
        (gzip.compress(b"t", mtime=0)[:2] + b"\x07" * 40, ["cannot be read", "again"]),
        ('t,gx\n0,"' + "1" * 200_000, ["cannot be read", "field"]),
    ],
    ids=lambda value: None if isinstance(value, list) else repr(value[:24]),
)
def test_bad_text_is_refused(tmp_path, text, parts):
    sentence = refusal(written(tmp_path, text), "omega=gx")
    for part in parts:
        assert part in sentence


def test_text_in_a_mapped_column_asks_for_another(tmp_path):
    text = table(",", ("t", "gx", "ang", "mode"), [(*row, "on") for row in ROWS])
    assert "map another column" in refusal(written(tmp_path, text), "omega=mode")


def test_missing_file_and_folder(tmp_path):
    assert refusal(tmp_path / "none.csv", "omega=gx") == (
        "none.csv: there is no such file; check the path"
    )
    assert "not a file" in refusal(tmp_path, "omega=gx")
    assert "cannot be opened" in refusal(tmp_path / ("x" * 300), "omega=gx")


@pytest.mark.parametrize("column", ["gy", "0", "4", "column2"])
def test_unknown_columns_list_the_known_ones(tmp_path, column):
    sentence = refusal(written(tmp_path, table(",")), f"omega={column}")
    assert f"no column '{column}'" in sentence
    assert "'t', 'gx', 'ang'" in sentence


def test_repeated_names_are_told_apart_by_their_number(tmp_path):
    path = written(tmp_path, table(",", ("t", "g", "g")))
    assert "'g (column 2)', 'g (column 3)'" in refusal(path, "omega=g")
    assert read(path, "omega=3").findings.channels[0].source == "g (column 3)"


def test_a_factor_in_a_text_file_is_a_number(tmp_path):
    assert "'lsb' is neither a number nor a scalar" in refusal(
        written(tmp_path, table(",")), "omega=gx*lsb"
    )


finite = st.floats(
    allow_nan=False, allow_infinity=False, width=64, min_value=-1e149, max_value=1e149
)


@settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    rows=st.lists(
        st.tuples(finite, finite),
        min_size=2,
        max_size=30,
        unique_by=(lambda r: r[0], lambda r: r[1]),
    ),
    delimiter=st.sampled_from([",", ";", "\t", " "]),
    header=st.booleans(),
    text=st.booleans(),
)
def test_numbers_come_back_exactly(tmp_path, rows, delimiter, header, text):
    rows = [(*row, "on") for row in rows] if text else rows
    names = ("gx", "ang", "mode")[: len(rows[0])] if header else None
    lines = [delimiter.join(map(str, row)) for row in ([names, *rows] if names else rows)]
    log = read(written(tmp_path, "\n".join(lines)), "omega=1", "theta=2", rate_hz=50)
    np.testing.assert_array_equal(log.channels["omega"], [row[0] for row in rows])
    np.testing.assert_array_equal(log.channels["theta"], [row[1] for row in rows])
