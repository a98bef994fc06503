"""The verdict: use it, use it with care, do not use it, and why."""

import pytest

from tests.tuner.report import made
from tuner.certificate.solution import Status
from tuner.report.lines import five_lines
from tuner.report.verdict import verdict, worth
from tuner.report.words import HARD


def told(result):
    found = verdict(result)
    return found.grade, found.sentence.replace(HARD, " ")


def test_use():
    grade, sentence = told(made.result())
    assert grade == "use"
    assert sentence == (
        "On the last 449 samples, not used for tuning, its error is 13 to 19 % smaller than "
        "before, its innovations are consistent with its variances, and all starts agree."
    )


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"in_doubt": ["q", "R"]}, "q and R are not determined by this recording"),
        ({"held_out": None}, "Nothing was held out for judging"),
        ({"held_out": made.held_out((-0.04, 0.04))}, "it is not clear whether tuning helps"),
        (
            {"diagnostics": [made.diagnostics(), made.diagnostics(failed=["whiteness"])]},
            "The innovations are correlated",
        ),
    ],
)
def test_with_care(changed, words):
    grade, sentence = told(made.result(fit=made.fit(**changed)))
    assert grade == "care"
    assert words in sentence


@pytest.mark.parametrize(
    ("held", "words"),
    [
        (made.held_out((-0.2, -0.1)), "its error is larger than before"),
        (
            made.held_out(over=(-0.2, -0.1)),
            "its error is larger than without filter (the constant mean)",
        ),
    ],
)
def test_what_harms_is_not_used(held, words):
    grade, sentence = told(made.result(fit=made.fit(held_out=held)))
    assert grade == "refuse"
    assert words in sentence


@pytest.mark.parametrize("status", [s for s in Status if not s.trusted])
def test_what_did_not_converge_is_not_used(status):
    grade, sentence = told(made.result(solutions=[made.solution(status=status)]))
    assert grade == "refuse"
    assert status.value in sentence
    assert status.sentence in sentence


def test_of_studies():
    assert told(made.study(all_met=True)) == ("use", "All 2 numbers and claims are met.")
    assert told(made.study())[0] == "care"
    nothing = made.result(fit=None, study="x")
    assert told(nothing) == ("use", "Its one search converged.")


def test_before_and_after_in_words():
    assert worth(made.fit()).replace(HARD, " ") == (
        "A measurement is predicted within 2.57 Pa; before it was 3.15 Pa."
    )
    angle = made.fit(objective="inclination", unit="deg", start=None)
    assert worth(angle) == (
        "The error of the inclination is 2.57° (rms); before it was without bound."
    )


def test_five_lines_of_a_study():
    use, good, trust, open_, next_ = five_lines(made.study())
    assert use == "use       q = 0.146 [0.07, 0.3] (95 %) Pa^2/s, R = 6.34 [below 7] Pa^2"
    assert good == (
        "how good  2 of 4 numbers and claims are met; 1 differs and 1 cannot be identified"
    )
    assert trust == "trust     the search converged; all starts agree"
    assert open_ == "open      R cannot be identified"
    assert next_ == "next      tuner compare RUN --md"
    assert five_lines(made.result()) == made.fit().lines
