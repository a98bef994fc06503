"""Blocks of plain numbers are read by SciPy or C, to the same bits, and no other blocks are."""

import math
import os
import re
from fractions import Fraction
from itertools import product
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tests.tuner.code.compiled import needed
from tuner.data.logs import compiled, parts, plain, regular
from tuner.data.logs.csv import open_csv
from tuner.data.logs.error import LogError
from tuner.data.logs.table import Loaded
from tuner.native import compiler
from tuner.native.compiler import NoCodeError

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


@pytest.fixture(scope="module", params=["SciPy", "C"])
def read(request):
    """Both readers in turn."""
    if request.param == "SciPy":
        return regular.read_regular
    needed("cc")
    return compiled.compiled()


@settings(max_examples=120, deadline=None)
@given(
    rows=grids(cells), delimiter=st.sampled_from(",;\t| "), piece=st.sampled_from([8, 64, 1 << 16])
)
def test_a_block_is_read_to_the_bit_or_left_alone(read, rows, delimiter, piece):
    text = text_of(rows, delimiter)
    with patch.object(plain, "_PIECE", piece):
        found = read(text, delimiter.encode(), len(rows[0]))
    parted = [line.split(delimiter.encode()) for line in text[:-1].split(b"\n")]
    right = all(len(row) == len(rows[0]) and all(map(NUMBER.fullmatch, row)) for row in parted)
    if right and all(abs(float(cell)) < 2**53 for row in parted for cell in row):
        values = np.array([[float(cell) for cell in row] for row in parted]).T.copy()
        np.testing.assert_array_equal(found.view(np.int64), values.view(np.int64))
    else:
        assert found is None


def test_every_short_cell_is_a_number_or_left_alone(read):
    for cell in (bytes(c) for length in range(5) for c in product(b"1.-+e", repeat=length)):
        found = read(b"2," + cell + b",3\n", b",", 3)
        assert (found is not None) == bool(NUMBER.fullmatch(cell)), cell
        assert found is None or found[1] == float(cell)


@pytest.mark.parametrize("text", ["1,2\n3\n4,5,6\n", "1,2\n\n3,4\n", "1\n2,3,4\n", "1,2\n3,4,\n"])
def test_rows_of_other_widths_are_left_alone(read, text):
    assert read(text.encode(), b",", 2) is None


@pytest.mark.parametrize("text", [b"", b"1", b"1,2", b"1,2\n3", b"1,2\n-", b"\n" * 5000])
def test_texts_that_end_early_are_left_alone(read, text):
    assert read(text, b",", 1 << 40) is None
    assert read(text, b",", 2) is None


def middle(double):
    """The 19 digits below the middle of a number and the next one."""
    between = (Fraction(double) + Fraction(float(np.nextafter(double, np.inf)))) / 2
    power = math.floor(math.log10(double)) - 18
    return f"{int(between / Fraction(10) ** power)}e{power}"


def test_numbers_that_are_hard_to_round(read):
    draw = np.random.default_rng(3)
    doubles = (2.0 ** draw.uniform(-890, 53, 500)).tolist()
    cells = [middle(double) for double in doubles]
    cells += [middle(double).replace("e", ".0e") for double in doubles]  # a digit more
    cells += [f"{draw.integers(1, 2**64, dtype=np.uint64)}e{-power}" for power in range(4, 330)]
    cells += [f"{double:.16e}" for double in doubles] + [f"1e-{power}" for power in range(330)]
    cells += ["4503599627370497.5", "2251799813685249.25", "9007199254740991.4999", "5e-324"]
    found = read("".join(f"{cell}\n" for cell in cells).encode(), b",", 1)
    assert found.tobytes() == np.array([float(cell) for cell in cells]).tobytes()


def loaded(path, smallest, native="off"):
    """All columns and what is said of them, or the sentence that refuses them."""
    with patch.object(parts, "_FEW", smallest), patch.dict(os.environ, TUNER_NATIVE=native):
        table = open_csv(path)
        try:
            found = Loaded.of(table.load(table.names))
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
def test_all_readers_say_the_same_of_a_log(tmp_path, rows, head, ended):
    text = head + "".join(f"{k},{k}.5\n" for k in range(30)) + "\n".join(rows) + "\n" * ended
    path = tmp_path / "log.csv"
    path.write_bytes(text.encode())
    cell_by_cell = loaded(path, len(text) * 2 + 1)
    assert loaded(path, 0) == cell_by_cell
    assert loaded(path, 0, native="on") == cell_by_cell


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


# C or not.


@pytest.fixture
def begun(monkeypatch):
    """As in a new process, with the default choice."""
    monkeypatch.setenv("TUNER_NATIVE", "auto")
    compiled._begun.cache_clear()
    yield
    compiled._begun.cache_clear()


def test_c_is_compiled_where_it_pays_and_is_wanted(begun, monkeypatch):
    needed("cc")
    assert compiled.plain_reader(compiled.PAYS - 1) is regular.read_regular
    monkeypatch.setenv("TUNER_NATIVE", "off")
    assert compiled.plain_reader(compiled.PAYS) is regular.read_regular
    assert compiled._begun.cache_info().currsize == 0
    monkeypatch.setenv("TUNER_NATIVE", "auto")
    assert compiled.plain_reader(compiled.PAYS) is not regular.read_regular
    monkeypatch.setenv("TUNER_NATIVE", "on")
    assert compiled.plain_reader(0) is compiled.plain_reader(compiled.PAYS)
    monkeypatch.setenv("TUNER_NATIVE", "yes")
    with pytest.raises(ValueError, match="TUNER_NATIVE is 'yes'; set it to auto, on or off"):
        compiled.plain_reader(0)


@pytest.mark.parametrize("script", ["exit 1", "echo cc 1", "sleep 60"])
def test_without_a_compiler_that_works_nothing_changes(script, begun, monkeypatch, tmp_path):
    broken = tmp_path / "cc"
    broken.write_text(f"#!/bin/sh\n{script}\n")
    broken.chmod(0o700)
    monkeypatch.setattr(compiler, "SECONDS", 0.2)
    monkeypatch.setattr(compiled, "_PATIENCE", 0.1 if "sleep" in script else 9)
    for program in (str(broken), str(tmp_path / "none")):
        monkeypatch.setenv("CC", program)
        assert compiled.plain_reader(compiled.PAYS) is regular.read_regular


def test_c_that_reads_other_numbers_is_not_used(begun, monkeypatch):
    needed("cc")
    monkeypatch.setattr(compiled, "_KNOWN", compiled._KNOWN + ",1e0")
    tens = compiled.powers_of_ten()
    monkeypatch.setattr(compiled, "powers_of_ten", lambda: tens + np.uint64(1 << 12))
    with pytest.raises(NoCodeError, match="that Python reads differently"):
        compiled.compiled()
    assert compiled.plain_reader(compiled.PAYS) is regular.read_regular


def test_powers_of_ten_are_cut_off_after_128_bits():
    tens = compiled.powers_of_ten()
    for power, (high, low, exponent) in zip(range(-290, 0), tens.tolist(), strict=True):
        bits, unit = (high << 64) + low, Fraction(2) ** (exponent - (1 << 64))
        assert bits >> 127 == 1
        assert bits * unit <= Fraction(10) ** power < (bits + 1) * unit


def test_a_long_log_is_read_by_c_without_scipy(begun, tmp_path):
    needed("cc")
    values = np.random.default_rng(2).standard_normal((30_000, 3))
    path = tmp_path / "log.csv"
    np.savetxt(path, values, "%.17g", ",", header="t,x,y", comments="")
    with patch.object(compiled, "PAYS", 0), patch.object(compiled, "read_regular") as scipy:
        found = open_csv(path).load(["t", "x", "y"]).raw
    assert not scipy.called
    np.testing.assert_array_equal(np.array(list(found.values())).T, values)
