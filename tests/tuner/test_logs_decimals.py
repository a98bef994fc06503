"""Numbers in a text are the very doubles that ``float`` makes of them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tuner.data.logs.grid import find_cells

digits = st.text("0123456789", min_size=0, max_size=24)
SIGNS = st.sampled_from(["", "-", "+"])


@st.composite
def plain(draw):
    whole, part = draw(digits), draw(digits)
    text = draw(SIGNS) + (whole or ("" if part else "7"))
    text += draw(st.sampled_from([f".{part}", ""])) if whole or not part else f".{part}"
    exponent = draw(st.none() | st.integers(-330, 330))
    return text if exponent is None else f"{text}{draw(st.sampled_from('eE'))}{exponent}"


finite = st.floats(allow_nan=False, allow_infinity=False)
numbers = st.one_of(
    finite.map(repr),
    st.tuples(finite, st.integers(0, 20)).map(lambda p: f"{p[0]:.{p[1]}e}"),
    st.tuples(st.floats(-1e6, 1e6), st.integers(0, 9)).map(lambda p: f"{p[0]:.{p[1]}f}"),
    st.integers(-(10**22), 10**22).map(str),
    plain(),
)


def check(texts):
    """Bit for bit where a number is read; the others are named."""
    grid = find_cells("".join(f"{text}\n" for text in texts).encode(), ",", 1, ".")
    found = grid.numbers([0])
    read = np.ones(len(texts), bool)
    read[found.odd] = False
    right = np.array([float(text) for text in texts])
    np.testing.assert_array_equal(found.values[read].view(np.int64), right[read].view(np.int64))
    return read


@settings(max_examples=150, deadline=None)
@given(st.lists(numbers, min_size=1, max_size=40))
def test_numbers_are_the_nearest_doubles(texts):
    check(texts)


def test_the_usual_numbers_are_read_at_once():
    rng = np.random.default_rng(1)
    values = rng.standard_normal(3000) * 10.0 ** rng.integers(-3, 12, 3000)
    for form in ("{:.5f}", "{:.9g}", "{:.18e}", "{:.0f}", "{!r}"):
        assert check([form.format(float(v)) for v in values]).mean() > 0.9


def test_halves_between_two_doubles_are_left_to_others():
    texts = ["9007199254740993", "9007199254740995.0", "4503599627370497.5", "1e23", "8.5e22"]
    texts += [f"{2**53 + k}" for k in range(1, 100, 2)]
    check(texts)


ODD = (
    "1.2.3 1-2 --1 1e 1e5e2 1e1.5 e5 - . +. 0x1F 1_0 1,5 nan 1.5deg 12:30 2024-03-30 1e+ 1.e-+5 1/2"
)


@pytest.mark.parametrize("text", [*ODD.split(), "1 2", "\N{ARABIC-INDIC DIGIT THREE}"])
def test_what_is_no_plain_number_is_named(text):
    grid = find_cells(f"1\n{text}\n2\n".encode(), ";", 1, ".")
    found = grid.numbers([0])
    assert found.odd.tolist() == [1]
    assert found.values[[0, 2]].tolist() == [1.0, 2.0]


def test_empty_cells_are_missing_and_whole_numbers_kept():
    grid = find_cells(b"1,,-1709132400123456789\n,2,0\n", ",", 3, ".")
    found = grid.numbers([0, 1, 2])
    assert np.isnan(found.values[[1, 3]]).all()
    assert found.whole[2] == 1709132400123456789
    assert found.negative[2]
    assert not len(found.odd)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.lists(numbers, min_size=3, max_size=3), min_size=1, max_size=20), st.data())
def test_columns_are_chosen(rows, data):
    columns = data.draw(st.permutations(range(3)).map(lambda p: p[:2]))
    grid = find_cells("".join(";".join(row) + "\n" for row in rows).encode(), ";", 3, ".")
    assert [cell.decode() for cell in grid.cells(1)] == [row[1] for row in rows]
    found = grid.numbers(columns)
    read = np.ones(len(found.values), bool)
    read[found.odd] = False
    right = np.array([float(row[k]) for row in rows for k in columns])
    np.testing.assert_array_equal(found.values[read], right[read])


@pytest.mark.parametrize(
    "block", [b"1,2\n3\n", b"1,2,3\n4,5,6\n", b"1,2\n3,4,5\n6\n", b"1\n2,3,4\n"]
)
def test_another_width_is_no_grid(block):
    assert find_cells(block, ",", 2, ".") is None
