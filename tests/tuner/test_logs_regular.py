"""Blocks of plain numbers are read by SciPy, to the same bits, and no other blocks are."""

import os
import re
from itertools import product
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tuner.data.logs import parts, plain, regular
from tuner.data.logs.csv import open_csv
from tuner.data.logs.error import LogError
from tuner.data.logs.table import Loaded

NUMBER = re.compile(rb"-?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
"""What is read here; of all that ``float`` reads it lacks a plus before the number, and words."""

finite = st.floats(allow_nan=False, allow_infinity=False)
numbers = st.one_of(
    finite.map(repr),
    st.tuples(finite, st.integers(0, 25)).map(lambda pair: f"{pair[0]:.{pair[1]}e}"),
    st.floats(-1e6, 1e6).map("{:.9g}".format),
    st.integers(-(2**53), 2**53).map(str),
    st.sampled_from(
        ["-0", "-.0", "5.", ".5", "-0.000", "1E5", "-1e-400", "007", "4503599627370497.5"]
    ),
    st.text("0123456789", min_size=1, max_size=40).map("0.".__add__),
)
ODD = (
    "nan inf 0x1F 1_0 1e 1e+ e5 1.2.3 1-2 --1 1e5e3 1e.5 1.-2 .e5 . - + +1 1/2 1:2 1e400 "
    "9007199254740993 \N{ARABIC-INDIC DIGIT THREE}"
)
odd = st.sampled_from([*ODD.split(), "", " ", " 1", "1 2", '"1"', "1\0"])
cells = st.one_of(numbers, numbers, numbers, odd, st.text("01.-+eE", max_size=6))


def grids(cell, most=12):
    widths = st.integers(1, 4)
    rows = widths.flatmap(
        lambda width: st.lists(
            st.lists(cell, min_size=width, max_size=width).map(tuple), min_size=1, max_size=most
        )
    )
    return rows  # fmt: skip


def text_of(rows, delimiter):
    return "".join(delimiter.join(row) + "\n" for row in rows).encode()


@settings(max_examples=120, deadline=None)
@given(
    rows=grids(cells), delimiter=st.sampled_from(",;\t| "), piece=st.sampled_from([8, 64, 1 << 16])
)
def test_a_block_is_read_to_the_bit_or_left_alone(rows, delimiter, piece):
    text = text_of(rows, delimiter)
    with patch.object(plain, "_PIECE", piece):
        found = regular.read_regular(text, delimiter.encode(), len(rows[0]))
    parted = [line.split(delimiter.encode()) for line in text[:-1].split(b"\n")]
    right = all(len(row) == len(rows[0]) and all(map(NUMBER.fullmatch, row)) for row in parted)
    if right and all(abs(float(cell)) < 2**53 for row in parted for cell in row):
        values = np.array([[float(cell) for cell in row] for row in parted]).T.copy()
        np.testing.assert_array_equal(found.view(np.int64), values.view(np.int64))
    else:
        assert found is None


def test_every_short_cell_is_a_number_or_left_alone():
    for cell in (bytes(c) for length in range(5) for c in product(b"1.-+e", repeat=length)):
        found = regular.read_regular(b"2," + cell + b",3\n", b",", 3)
        assert (found is not None) == bool(NUMBER.fullmatch(cell)), cell
        assert found is None or found[1] == float(cell)


@pytest.mark.parametrize("text", ["1,2\n3\n4,5,6\n", "1,2\n\n3,4\n", "1\n2,3,4\n", "1,2\n3,4,\n"])
def test_rows_of_other_widths_are_left_alone(text):
    assert regular.read_regular(text.encode(), b",", 2) is None


def loaded(path, smallest, native="off", wanted=None):
    """Some columns and what is said of them, or the sentence that refuses them."""
    with patch.object(parts, "_FEW", smallest), patch.dict(os.environ, TUNER_NATIVE=native):
        table = open_csv(path)
        try:
            columns = range(len(table.names)) if wanted is None else wanted
            found = Loaded.of(table.load([table.names[k] for k in columns]))
        except LogError as error:
            return str(error), []
    return found.notes, [(name, a.dtype, a.tobytes()) for name, a in found.raw.items()]


lines = st.sampled_from(["# pause", "", "t,x", "1,2", "% e", "end of log", "1,2,3", "1", "1,2\r"])


@settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    rows=st.lists(st.one_of(*4 * [st.tuples(numbers, cells).map(",".join)], lines), max_size=30),
    head=st.sampled_from(["", "t,x\n", "log 7\nt,x\n", "1,2,7\nt,x\n"]),
    ended=st.booleans(),
)
@example(rows=["9007199254740993,1", "-0,1", "5,9007199254740993"], head="", ended=True)
def test_both_readers_say_the_same_of_a_log(tmp_path, rows, head, ended):
    text = head + "".join(f"{k},{k}.5\n" for k in range(30)) + "\n".join(rows) + "\n" * ended
    path = tmp_path / "log.csv"
    path.write_bytes(text.encode())
    assert loaded(path, 0) == loaded(path, len(text) * 2 + 1)


def test_a_long_log_is_read_by_scipy_where_it_is_plain(tmp_path):
    values = np.random.default_rng(2).standard_normal((60_000, 3))
    values[40_000:, 2] = np.nan
    path = tmp_path / "log.csv"
    np.savetxt(path, values, "%.17g", ",", header="t,x,y", comments="")
    with patch.object(regular, "_matrix", wraps=regular._matrix) as matrix:
        table = open_csv(path)
        found = table.load(table.names).raw
    assert 1 <= matrix.call_count <= 3  # of four blocks
    np.testing.assert_array_equal(np.array(list(found.values())).T, values)
