"""Plans and claims: found by name, solving what they need alone."""

import dataclasses
import re
import threading

import numpy as np
import pytest

from tests.tuner.helpers import Solved, bowl, problem, trench
from tuner.data.source import Source
from tuner.run.background_work import begin_claims
from tuner.run.comparison import number
from tuner.run.study import Claim, Plan, Task

NAMES = ("left", "right", "left.paper", "right.paper")
NOTHING = Source("nothing", "", 0, 0.0)


def exactly(sentence):
    return f"^{re.escape(sentence)}$"


def row(name):
    return number(name, "Table 1", 1.0, 1.0, tolerance=0.1)


def one(name):
    return lambda case, solutions: row(name)


def each(suffix):
    """A row for each of the case's sides."""
    return lambda case, solutions: (row(f"{side}.{suffix}") for side in case)


def tasks():
    solver = Solved("any", lambda problem: pytest.fail("nothing is solved here"))
    return tuple(Task(problem(bowl, name=name), solver) for name in NAMES)


def plan(**changed):
    fields = {
        "source": NOTHING,
        "tasks": tasks(),
        "exports": ("left",),
        "case": ("left", "right"),
        "claims": (
            Claim("*.ratio", each("ratio"), ("left", "right")),
            Claim("left.R", one("left.R"), ("left.paper",)),
            Claim("*.both", each("both"), ("*.paper",)),
            Claim("table.[1]", one("table.[1]")),
        ),
        "figures": lambda case, solutions: pytest.fail("nothing is drawn here"),
    }
    return Plan(**fields | changed)


def rows(plan, *names):
    return [row.quantity for row in plan.compare({}, names)]


def solved(plan):
    return [task.problem.name for task in plan.tasks]


def test_all_rows_in_the_order_of_the_claims():
    assert rows(plan()) == [
        *("left.ratio", "right.ratio", "left.R", "left.both", "right.both", "table.[1]")
    ]


@pytest.mark.parametrize(
    ("names", "found", "needed"),
    [
        (("left.R",), ["left.R"], ["left.paper"]),
        (("right.ratio",), ["right.ratio"], ["left", "right"]),
        (("*.ratio",), ["left.ratio", "right.ratio"], ["left", "right"]),
        (("left.*",), ["left.ratio", "left.R", "left.both"], list(NAMES)),
        (("?eft.bot?",), ["left.both"], ["left.paper", "right.paper"]),
        (("l*", "table.[1]"), ["left.ratio", "left.R", "left.both", "table.[1]"], list(NAMES)),
        (("table.[1]",), ["table.[1]"], []),
        (("*",), None, list(NAMES)),
    ],
)
def test_claims_by_name_and_pattern(names, found, needed):
    chosen = plan().only(names)
    assert solved(chosen) == needed
    assert rows(chosen, *names) == (rows(plan()) if found is None else found)
    assert chosen.exports == ()
    assert list(chosen.figures(chosen.case, {})) == []
    assert (chosen.source, chosen.case) == (NOTHING, ("left", "right"))


def test_unknown_claims_are_told_the_near_ones():
    there = "There are: *.both, *.ratio, left.R, table.[1]"
    sentence = f"unknown claim 'left.S'; did you mean left.R? {there}"
    with pytest.raises(ValueError, match=exactly(sentence)):
        plan().only(["left.S"])
    # One that is known does not hide one that is not.
    with pytest.raises(ValueError, match=exactly(f"unknown claim 'nonsense'; t{there[1:]}")):
        plan().only(["left.R", "nonsense"])
    with pytest.raises(ValueError, match=exactly("unknown claim 'left.R'; there are none")):
        plan(claims=()).only(["left.R"])


def test_a_row_that_no_claim_returned_is_told_when_it_is_known():
    """middle.ratio may be one of ``*.ratio``: only the claim itself knows."""
    chosen = plan().only(["middle.ratio"])
    sentence = "unknown claim 'middle.ratio'; did you mean left.ratio or right.ratio? There are: "
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}"):
        rows(chosen, "middle.ratio")


def test_no_row_can_hide_from_its_name():
    astray = plan(claims=(Claim("left.R", one("left.Q")),))
    with pytest.raises(ValueError, match=exactly("the claim left.R returned the row 'left.Q'")):
        rows(astray)


def test_claims_know_the_case_and_the_solutions():
    def told(case, solutions):
        assert case == "the case"
        return number("a", "b", 1.0, solutions["left", "any"], tolerance=0.1)

    (found,) = Claim("a", told).compare("the case", {("left", "any"): 2.0})
    assert found.ours == 2.0


def test_claims_that_need_no_solution_are_tried_while_others_wait():
    told, waited = [], threading.Event()

    def early(case, solutions):
        assert not solutions
        told.append(threading.current_thread())
        waited.set()
        return [row("table.[1]")]

    def late(case, solutions):
        assert solutions
        return [row("left.R")]

    made = plan(claims=(Claim("left.R", late, ("left",)), Claim("table.[1]", early)))
    begun = begin_claims(made)
    assert waited.wait(10)
    found = made.compare({("left", "any"): 2.0}, early=begun)
    assert [one.quantity for one in found] == ["left.R", "table.[1]"]
    assert told != [threading.current_thread()]
    assert len(told) == 1


def test_an_early_claim_fails_where_it_is_asked_for():
    def wrong(case, solutions):
        raise ValueError("no such number")

    made = plan(claims=(Claim("left.R", wrong),))
    begun = begin_claims(made)
    with pytest.raises(ValueError, match=exactly("no such number")):
        made.compare({}, early=begun)


def test_what_nobody_solves_cannot_be_exported():
    sentence = "unknown problem 'lft'; did you mean left? There are: "
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}"):
        plan(exports=("lft",))


def test_tasks_have_two_fields_and_the_solvers_own_name():
    assert [field.name for field in dataclasses.fields(Task)] == ["problem", "solver"]
    assert Task(problem(trench), Solved("mine", None)).solver.name == "mine"


def test_long_patterns_are_matched_in_a_moment():
    name = "a" * 40
    chosen = plan(claims=(Claim(name, one(name)),)).only(["*a*a*"])
    assert np.size(rows(chosen, "*a*a*")) == 1
