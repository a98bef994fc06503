import gzip
import hashlib

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.tuner.recordings import refusal, values
from tuner.data.reading import read_record

ROWS = ((0.00, 1.5, -3.0), (0.01, 2.5, -2.0), (0.02, 0.5, -4.0), (0.03, 1.0, 1e-3))


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
    record = read_record(path, maps, rate_hz=100)
    omega, theta = record.channels["omega"], record.channels["theta"]
    np.testing.assert_allclose(omega.values, np.radians([row[1] for row in ROWS]), rtol=1e-15)
    np.testing.assert_array_equal(theta.values, [row[2] for row in ROWS])
    assert (omega.unit, theta.unit, record.name) == ("rad/s", "", "log.csv")
    assert record.digest == hashlib.sha256(path.read_bytes()).hexdigest()


def test_channels_are_contiguous_read_only_float64(tmp_path):
    array = values(written(tmp_path, table(",")), "omega=gx*2")
    assert array.dtype == np.float64
    assert array.flags.c_contiguous
    assert not array.flags.writeable
    np.testing.assert_array_equal(array, [3.0, 5.0, 1.0, 2.0])


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
    omega = read_record(written(tmp_path, text), ["omega=gx"]).channels["omega"]
    np.testing.assert_array_equal(omega.values, [row[1] for row in ROWS])
    assert omega.rate_hz == pytest.approx(100)
    assert omega.clock.source == "column 't'"


def test_compressed_whatever_its_name(tmp_path):
    path = written(tmp_path, gzip.compress(table(",").encode()), "log.csv")
    np.testing.assert_array_equal(values(path, "omega=gx"), [row[1] for row in ROWS])


def test_a_damaged_first_row_does_not_pass_for_a_header(tmp_path):
    path = written(tmp_path, table(",", header=None).replace("1.5", "l.5", 1))
    assert "line 1, column 'column2' holds 'l.5'" in refusal(path, ["omega=2"])


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
        (table(",") + "0.04,broken,1\n", ["line 6", "'broken'"]),
        (table(";").replace("2.5", "2,5"), ["line 3", "'2,5'", "decimal points"]),
        (b"\x00\x01\x02\x03" * 50, ["neither text nor of a known format"]),
        (gzip.compress(table(",").encode() * 500, mtime=0)[:-20], ["cannot be read", "again"]),
        (gzip.compress(b"t", mtime=0)[:2] + b"\x07" * 40, ["cannot be read", "again"]),
        ('t,gx\n0,"' + "1" * 200_000, ["cannot be read", "field"]),
    ],
    ids=lambda value: None if isinstance(value, list) else repr(value[:24]),
)
def test_bad_text_is_refused(tmp_path, text, parts):
    sentence = refusal(written(tmp_path, text), ["omega=gx"])
    for part in parts:
        assert part in sentence


@pytest.mark.parametrize("cell", ["", " ", "nan", "-inf", "1.7976931348623157e308"])
@pytest.mark.parametrize("mode", [(), ("on",)], ids=["fast", "careful"])
def test_missing_cells_are_nan(tmp_path, cell, mode):
    header, rows = ("t", "gx", "ang", *("mode" for _ in mode)), [(*row, *mode) for row in ROWS]
    text = table(",", header, rows).replace("2.5", cell).replace("'", "")
    np.testing.assert_array_equal(
        values(written(tmp_path, text), "omega=gx"), [1.5, np.nan, 0.5, 1.0]
    )


def test_text_in_a_mapped_column_asks_for_another(tmp_path):
    text = table(",", ("t", "gx", "ang", "mode"), [(*row, "on") for row in ROWS])
    assert "map another column" in refusal(written(tmp_path, text), ["omega=mode"])


def test_missing_file_and_folder(tmp_path):
    assert refusal(tmp_path / "none.csv", ["omega=gx"]) == (
        "none.csv: there is no such file; check the path"
    )
    assert "folder of text files holds none" in refusal(tmp_path, ["omega=gx"])
    assert "cannot be opened" in refusal(tmp_path / ("x" * 300), ["omega=gx"])


@pytest.mark.parametrize("column", ["gy", "0", "4", "column2"])
def test_unknown_columns_list_the_known_ones(tmp_path, column):
    sentence = refusal(written(tmp_path, table(",")), [f"omega={column}"])
    assert f"no column '{column}'" in sentence
    assert "'t', 'gx', 'ang'" in sentence


def test_repeated_names_are_told_apart_by_their_number(tmp_path):
    path = written(tmp_path, table(",", ("t", "g", "g")))
    assert "'g (column 2)', 'g (column 3)'" in refusal(path, ["omega=g"])
    omega = read_record(path, ["omega=3"]).channels["omega"]
    np.testing.assert_array_equal(omega.values, [row[2] for row in ROWS])
    assert omega.source == "g (column 3)"


def test_a_factor_in_a_text_file_is_a_number(tmp_path):
    assert "'lsb' is neither a number nor a scalar" in refusal(
        written(tmp_path, table(",")), ["omega=gx*lsb"]
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
    both = values(written(tmp_path, "\n".join(lines)), "omega=1,2", rate_hz=50)
    np.testing.assert_array_equal(both, [row[:2] for row in rows])
