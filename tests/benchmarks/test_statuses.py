"""The battery of statuses: its optima are those of a dense search, and its judge can condemn."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.statuses.__main__ import main
from benchmarks.statuses.battery import cases
from benchmarks.statuses.case import lowest
from benchmarks.statuses.judge import Verdict, judge, steps
from tuner import Known, NelderMead, Status

ALL = list(cases(0))


def test_three_hundred_problems_of_ten_families():
    assert len(ALL) == 300
    assert len(Counter(case.family for case in ALL)) == 10
    assert len({case.name for case in ALL}) == 300


@pytest.mark.parametrize("case", [case for case in ALL if case.number in (0, 5)], ids=str)
def test_known_optimum_is_that_of_a_dense_search(case):
    low, high = case.problem.space.box()
    assert (case.where >= low - 1e-12).all()
    assert (case.where <= high + 1e-12).all()
    assert abs(float(case.values(case.where[None])[0]) - case.best) <= 0.1 * case.tolerance + 1e-300
    dense = 201 if len(low) == 2 else 7
    assert lowest(case.values, low, high, dense)[1] >= case.best - 0.1 * case.tolerance


@pytest.mark.parametrize("case", [case for case in ALL if case.number == 1], ids=str)
def test_both_statements_are_the_same_function(case):
    low, high = case.problem.space.box()
    for z in np.random.default_rng(0).uniform(low, high, (3, len(low))):
        value = case.problem.value(z)
        np.testing.assert_allclose(value, case.values(z[None])[0], rtol=1e-8)


def _case(name):
    return next(case for case in ALL if case.name == name)


def _ended(case, z, status=Status.CONVERGED, told=()):
    """A solution at z with whatever it is to say."""
    names = case.problem.space.names
    solved = Known("there", lambda problem: dict.fromkeys(names, 1.0), "said")(case.problem)
    certificate = replace(solved.certificate, flat_directions=tuple(told))
    return replace(solved, z=np.asarray(z), status=status, certificate=certificate)


def test_judge_condemns_a_saddle_and_a_missed_optimum():
    case = _case("saddle 0")
    n = case.where[1]
    at_saddle = judge(case, "any", _ended(case, [0.0, n]))
    assert at_saddle.wrong
    assert judge(case, "any", _ended(case, case.where)).gap == pytest.approx(0, abs=1e-6)
    assert not judge(case, "any", _ended(case, [0.0, n], Status.STALLED)).wrong
    hidden = _case("waves 0")
    far = hidden.where + np.array([3.0, 3.0]) * -np.sign(hidden.where)
    other = NelderMead(seed=0, starts=1)(replace_start(hidden, far))
    found = judge(hidden, "any", replace(other, status=Status.CONVERGED))
    assert found.wrong == (found.gap > 1)


def replace_start(case, z):
    return replace(case.problem, known_starts=(np.asarray(z),))


def test_judge_condemns_an_end_of_the_box_that_hides_the_optimum():
    case = _case("beyond 0")
    assert judge(case, "any", _ended(case, case.where)).near
    assert not judge(case, "any", _ended(case, case.where, Status.AT_BOUND)).near
    assert not judge(case, "any", _ended(case, case.where, Status.AT_BOUND)).alarm


def test_judge_knows_false_alarms_and_sentences_that_are_not_true():
    case = _case("power 0")
    assert judge(case, "any", _ended(case, case.where, Status.STALLED)).alarm
    assert not judge(case, "any", _ended(case, case.where)).alarm
    told = ["a x 10 changes nothing: a is not determined"]
    assert judge(case, "any", _ended(case, case.where, told=told)).lies == 1
    ridge = _case("ridge 0")
    assert judge(ridge, "any", _ended(ridge, ridge.where)).silent


def test_step_of_a_sentence():
    labels = ["ln R", "ln Q", "x"]
    moved = steps(labels, "R x 10 with Q x 0.1 with x -0.3 changes nothing: only that")
    np.testing.assert_allclose(moved, [np.log(10), -np.log(10), -0.3])


def test_table_names_what_is_wrong_and_the_exit_code_says_so(monkeypatch, capsys):
    fine = Verdict("kinked", "corner 1", "nelder-mead", "converged", 0.2)
    false = Verdict("staircase", "floors 1", "l-bfgs-b", "converged", 7e3, wrong=True, near=True)

    def coded(*found):
        monkeypatch.setattr("benchmarks.statuses.__main__.solved", lambda part: list(found))
        return main(["--jobs", "1"])

    assert coded(fine) == 0
    assert "wrong: 0.0% (goal 1%)" in capsys.readouterr().out
    assert coded(fine, false) == 1
    assert "wrong: 50.0% (goal 1%)  floors 1 l-bfgs-b: converged" in capsys.readouterr().out
    # What most of the starts agree on is counted apart, for it may be another well.
    assert coded(fine, replace(false, agreed=True, near=False)) == 0
