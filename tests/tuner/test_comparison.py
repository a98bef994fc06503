"""Rows of a comparison: verdicts, sizes and tolerances."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tuner.run.comparison import Comparison, Verdict, claim, number, undecided

numbers = st.floats(1e-12, 1e12) | st.floats(-1e12, -1e-12)


def row(paper, ours, tolerance=0.05, **more):
    return number("gain", "Table 2", paper, ours, tolerance=tolerance, **more)


@given(numbers, st.floats(-0.9, 9.0), st.floats(0.0, 1.0))
def test_a_match_lies_within_the_tolerance(paper, deviation, tolerance):
    found = row(paper, paper * (1 + deviation), tolerance)
    if abs(abs(deviation) - tolerance) > 1e-9:  # the quotient rounds
        expected = Verdict.MATCH if abs(deviation) < tolerance else Verdict.DIFFERS
        assert found.verdict is expected
    assert found.deviation == pytest.approx(deviation, abs=1e-9)
    assert found.within(None) == (found.verdict is Verdict.MATCH)


@pytest.mark.parametrize(
    ("paper", "ours", "note"),
    [
        (2.0, 7.2, "x 3.6"),
        (2.0, 4.0, "x 2"),
        (2.0, 3.9, "+95.0 %"),
        (2.0, 2.2, "+10.0 %"),
        (2.0, 1.8, "-10.0 %"),
        (2.0, 1.0, "x 0.5"),
        (2.0, 0.002, "x 0.001"),
        (2.0, -2.0, "x -1"),
        (1027.47, 2.3e8, "x 2.2e+05"),
        (0.0, 3.0, "3 against 0"),
        (2.0, math.inf, "inf against 2"),
        (2.0, math.nan, "nan against 2"),
    ],
)
def test_a_difference_says_its_size(paper, ours, note):
    found = row(paper, ours)
    assert found.verdict is Verdict.DIFFERS
    assert found.note == note
    assert row(paper, ours, note="reading R6").note == f"reading R6; {note}"
    assert not found.within(None)
    assert not found.within(0.04)


def test_a_match_keeps_its_note():
    found = row(2.0, 2.02, note="reading R6", unit="1/s")
    assert found == Comparison(
        "gain", "Table 2", 2.0, 2.02, "1/s", 0.05, Verdict.MATCH, "reading R6"
    )
    assert found.deviation == pytest.approx(0.01)


def test_zero_on_paper_matches_zero_only():
    assert row(0.0, 0.0).verdict is Verdict.MATCH
    assert row(0.0, 0.0).within(0.0)
    assert row(0.0, 1e-300).verdict is Verdict.DIFFERS
    # No tolerance is wide enough for something where there should be nothing.
    assert not row(0.0, 1e-300).within(10.0)
    assert row(0.0, 0.0).deviation is None


def test_another_tolerance():
    found = row(2.0, 2.2)  # 10 %
    assert [found.within(t) for t in (None, 0.0, 0.099, 0.101, 1.0)] == [
        False,
        False,
        False,
        True,
        True,
    ]
    assert [row(2.0, 2.02).within(t) for t in (None, 0.001, 0.02)] == [True, False, True]


def test_an_infinite_number_is_none_on_file_and_still_differs():
    on_file = Comparison("f", "Table 2", 2.0, None, "Hz", 0.05, Verdict.DIFFERS, "")
    assert not on_file.within(None)
    assert not on_file.within(1e6)


@pytest.mark.parametrize("holds", [True, False])
def test_claims(holds):
    found = claim("stuck", "section 4", holds, ours=3.0, note="it does not move", unit="1")
    verdict = Verdict.HOLDS if holds else Verdict.FAILS
    assert found == Comparison(
        "stuck", "section 4", None, 3.0, "1", None, verdict, "it does not move"
    )
    # Words have no tolerance to lie outside of.
    assert found.within(None)
    assert found.within(0.0)
    assert found.deviation is None


def test_what_cannot_be_compared_keeps_its_numbers_and_the_reason():
    found = undecided("M", "section 5", paper=0.7, ours=0.9, unit="deg", note="no unit is given")
    assert found == Comparison(
        "M", "section 5", 0.7, 0.9, "deg", None, Verdict.NOT_IDENTIFIABLE, "no unit is given"
    )
    assert found.within(0.0)


def test_words_of_the_verdicts():
    assert [verdict.value for verdict in Verdict] == [
        "match",
        "differs",
        "claim holds",
        "claim fails",
        "not identifiable",
        "inconsistent in the paper",
    ]
