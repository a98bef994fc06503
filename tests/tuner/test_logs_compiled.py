"""Blocks of numbers that C reads to the bit, or leaves alone, and where there is no C."""

import math
from fractions import Fraction
from itertools import product
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from benchmarks.text_fuzz import right
from tests.tuner.code.compiled import needed
from tests.tuner.test_logs_regular import cells, loaded, numbers
from tuner import compiler
from tuner.compiler import NoCodeError
from tuner.data.logs import compiled
from tuner.data.logs.compiled import Form, by_scipy
from tuner.data.logs.csv import open_csv

EITHER = object()


@pytest.fixture(scope="module")
def read():
    needed("cc")
    return compiled.compiled()


def of(width, delimiter=b",", point=b"."):
    return Form(delimiter, point, width, range(width))


words = st.sampled_from(["nan", "NaN", "", " ", "na", "nano", "-nan", "+1", "#", "%1", "on", "a b"])
blanks = st.sampled_from(["", "", "", " ", "  ", "\t"])
texts = st.tuples(blanks, st.one_of(numbers, numbers, cells, words), blanks).map("".join)


@st.composite
def blocks(draw):
    """Some lines, and how they are written and wanted."""
    delimiter, point = draw(st.sampled_from([",.", ";.", ";,", "\t.", "|,", " .", " ,", ",,"]))
    width = draw(st.integers(1, 4))
    row = st.lists(texts, min_size=width, max_size=width).map(delimiter.join)
    rows = draw(st.lists(row, max_size=8))
    columns = draw(st.lists(st.integers(0, width - 1), min_size=1, unique=True))
    text = "".join(f"{row}\n" for row in rows).replace(".", point)
    return text.encode(), Form(delimiter.encode(), point.encode(), width, columns)


@settings(max_examples=100)
@given(block=blocks())
def test_a_block_is_read_to_the_bit_or_left_alone(read, block):
    text, form = block
    with patch.object(compiled, "by_scipy", return_value=EITHER):
        found = read(text, form)
    wanted = right(text, form)
    if found is None or wanted is None:
        assert found in (EITHER, wanted)
    elif found is not EITHER:
        assert np.array(found).tobytes() == wanted.tobytes()


def test_every_short_cell_is_a_number_or_left_alone(read):
    form = of(3)
    for cell in (bytes(c) for length in range(5) for c in product(b"1.-+e ", repeat=length)):
        found, wanted = read(b"2," + cell + b",3\n", form), right(b"2," + cell + b",3\n", form)
        assert (found is None) == (wanted is None), cell
        assert found is None or np.array(found).tobytes() == wanted.tobytes()


@pytest.mark.parametrize("text", [b"", b"1", b"1,2", b"1,2\n3", b"1,2\n-", b"n", b"\n" * 5000])
def test_texts_that_end_early_are_left_alone(read, text):
    assert read(text, of(2)) is None
    wide = Form(b",", b".", 1 << 40, [0])  # for which there is no memory
    assert read(text, wide) is None


def middle(double):
    """The 19 digits below the middle of a number and the next one."""
    between = (Fraction(double) + Fraction(float(np.nextafter(double, np.inf)))) / 2
    power = math.floor(math.log10(double)) - 18
    return f"{int(between / Fraction(10) ** power)}e{power}"


def test_numbers_that_are_hard_to_round(read):
    draw = np.random.default_rng(3)
    doubles = (2.0 ** draw.uniform(-890, 45, 500)).tolist()
    cells = [middle(double) for double in doubles]
    cells += [f"{draw.integers(1, 2**63)}e-{power}" for power in range(4, 290)]
    cells += [f"{double:.16e}" for double in doubles] + [f"1e-{power}" for power in range(290)]
    cells += [f"{double:.30e}" for double in doubles] + [f"{double:.99f}" for double in doubles]
    cells += [middle(double).replace("e", "07e") for double in doubles] + [
        "0" * 40,
        "0.5" + "0" * 40,
    ]
    cells += ["9007199254740991.499", "0e-999", "-0e9", "0.5000000000000000000", "1e-00000000005"]
    text = "".join(f"{cell}\n" for cell in cells).encode()
    with patch.object(compiled, "by_scipy") as scipy:
        (found,) = read(text, of(1))
    assert not scipy.called
    assert found.tobytes() == np.array([float(cell) for cell in cells]).tobytes()


@pytest.mark.parametrize(
    "cell", ["4503599627370497.5", "2251799813685249.25", "4503599627370497.50000001", "1e-291"]
)
def test_what_is_in_doubt_is_left_to_scipy(read, cell):
    with patch.object(compiled, "by_scipy", return_value=EITHER):
        assert read(f"1,{cell}\n".encode(), of(2)) is EITHER
    assert read(f"1,{cell}\n".encode(), of(2))[1] == float(cell)


rows = st.tuples(numbers, texts, texts).map(",".join)
lines = st.sampled_from(["# a", "", "t,x,on", "1,2,3", "% e", " #,1,2", "end", "1,2", "1,2,3\r"])
LARGE = ["9007199254740993,1,", "-0,1,", "5,9007199254740993,"]


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    rows=st.lists(st.one_of(*5 * [rows], lines), max_size=20),
    head=st.sampled_from(["", "t,x,on\n", "log 7\nt,x,on\n", "1,2,on\n", '"1","2",on\n', ",,\n"]),
    ended=st.booleans(),
    wanted=st.sampled_from([[0, 1, 2], [0, 1], [1], [2]]),
)
@example(rows=LARGE, head="", ended=True, wanted=[1])
@example(rows=["# 1,2,3", "1,2,on", '"1",2,"a,b"'], head="1,2,on\n", ended=True, wanted=[1])
def test_c_says_the_same_of_a_log(read, tmp_path, rows, head, ended, wanted):
    text = head + "".join(f"{k},{k}.5,\n" for k in range(30)) + "\n".join(rows) + "\n" * ended
    path = tmp_path / "log.csv"
    path.write_bytes(text.encode())
    right, found = (loaded(path, 0, word, wanted) for word in ("off", "on"))
    assert found == right


@pytest.mark.parametrize("text", ["{0}.5 \t{0}e-1\n", "  {0} {0}\n", "{0},5;{0}\n", "{0};nan \n"])
def test_logs_of_other_programs_go_through_c(read, tmp_path, text):
    path = tmp_path / "log.csv"
    path.write_text("".join(text.format(k) for k in range(60)))
    kept = loaded(path, 0, "off", [0, 1])
    with patch("tuner.data.logs.parts._from_cells") as cells:
        assert loaded(path, 0, "on", [0, 1]) == kept
    assert not cells.called


# Where there is C.


@pytest.fixture
def begun(monkeypatch):
    """As in a new process, with the default choice."""
    monkeypatch.setenv("TUNER_NATIVE", "auto")
    compiled._begun.cache_clear()
    yield
    compiled._begun.cache_clear()


def test_c_is_compiled_where_it_pays_and_is_wanted(begun, monkeypatch):
    needed("cc")
    assert compiled.reader(compiled.PAYS - 1) is by_scipy
    monkeypatch.setenv("TUNER_NATIVE", "off")
    assert compiled.reader(compiled.PAYS) is by_scipy
    assert compiled._begun.cache_info().currsize == 0
    monkeypatch.setenv("TUNER_NATIVE", "auto")
    assert compiled.reader(compiled.PAYS) is not by_scipy
    monkeypatch.setenv("TUNER_NATIVE", "on")
    assert compiled.reader(0) is compiled.reader(compiled.PAYS)
    monkeypatch.setenv("TUNER_NATIVE", "yes")
    with pytest.raises(ValueError, match="TUNER_NATIVE is 'yes'; set it to auto, on or off"):
        compiled.reader(0)


@pytest.mark.parametrize("script", ["exit 1", "echo cc 1", "sleep 60"])
def test_without_a_compiler_that_works_nothing_changes(script, begun, monkeypatch, tmp_path):
    broken = tmp_path / "cc"
    broken.write_text(f"#!/bin/sh\n{script}\n")
    broken.chmod(0o700)
    monkeypatch.setattr(compiler, "SECONDS", 0.2)
    monkeypatch.setattr(compiled, "_PATIENCE", 0.1 if "sleep" in script else 9)
    for program in (str(broken), str(tmp_path / "none")):
        monkeypatch.setenv("CC", program)
        assert compiled.reader(compiled.PAYS) is by_scipy


def test_c_that_reads_other_numbers_is_not_used(begun, monkeypatch):
    needed("cc")
    tens = compiled.powers_of_ten()
    monkeypatch.setattr(compiled, "powers_of_ten", lambda: tens + np.uint64(1))
    with pytest.raises(NoCodeError, match="that Python reads differently"):
        compiled.compiled()
    assert compiled.reader(compiled.PAYS) is by_scipy


def test_powers_of_ten_are_cut_off_after_128_bits():
    tens = compiled.powers_of_ten()
    for power, (high, low, exponent) in zip(range(-290, 0), tens.tolist(), strict=True):
        bits, unit = (high << 64) + low, Fraction(2) ** (exponent - (1 << 64))
        assert bits >> 127 == 1
        assert bits * unit <= Fraction(10) ** power < (bits + 1) * unit


def test_a_long_log_is_read_by_c_in_blocks(begun, tmp_path):
    needed("cc")
    values = np.random.default_rng(2).standard_normal((30_000, 3))
    values[::7, 2] = np.nan
    path = tmp_path / "log.csv"
    np.savetxt(path, values, "%.17g", ",", header="t,x,y", comments="")
    with patch.object(compiled, "PAYS", 0), patch.object(compiled, "read_regular") as scipy:
        found = open_csv(path).load(["t", "x", "y"]).raw
    assert not scipy.called
    np.testing.assert_array_equal(np.array(list(found.values())).T, values)
