"""Statuses against known optima: a part of ``python -m benchmarks.statuses``, and its goals."""

import jax.numpy as jnp
import pytest

from benchmarks.statuses.battery import cases, verdicts
from benchmarks.statuses.case import LIMITED
from tuner import Known, Problem

KINDS = (
    *("ridge", "near ridge", "weak ridge", "bent"),
    *("corner", "largest", "crease", "deviations", "worst"),
    *("rounded", "counted", "floors", "confused", "confused, declared"),
    *("many corners", "monkey", "edge saddle", "saddle", "tilted", "wells"),
    *("scaled", "negative", "crossing", "banana", "wide"),
    *("at a limit", "beyond", "power", "held", "cone", "squares", "line"),
)


@pytest.fixture(scope="module")
def found():
    """Two solvers on one problem of every kind."""
    chosen = [case for case in cases(1, 0.01) if case.kind in KINDS]
    return list(verdicts(chosen, slow=99, only=("l-bfgs-b", "nelder-mead", "alternating")))


def _named(found, fault):
    return [f"{v.case} {v.solver}: {v.status}" for v in found if getattr(v, fault)]


def test_nothing_is_trusted_that_is_not_an_optimum(found):
    # 1 % of 60 is none.
    assert len(found) > 55
    assert _named([v for v in found if not v.agreed], "wrong") == []
    assert _named(found, "near") == []


def test_optima_are_called_optima(found):
    # 3 % of 60 is one; starts may truly differ where there are wells of different depth.
    assert len(_named([v for v in found if not v.differs], "alarm")) <= 1
    assert _named(found, "raised") == []


def test_what_is_said_to_change_nothing_changes_nothing(found):
    assert _named(found, "lies") == []
    assert _named(found, "silent") == []


def double_well(point, truth):
    """Lowest, 2, at x = -1 and 1; a saddle at 0."""
    x, y = point["x"], point["y"]
    return 2 + (x**2 - 1) ** 2 + y**2


def as_it_is(values):
    return values


@pytest.mark.parametrize(("x", "trusted"), [(0.0, False), (1.0, True), (0.5, False)])
def test_wrong_formula_is_not_trusted(x, trusted):
    problem = Problem("well", LIMITED, None, as_it_is, double_well)
    solution = Known("formula", lambda _: {"x": x, "y": 0.0}, "a formula")(problem)
    assert solution.status.trusted is trusted
    assert float(jnp.round(solution.value, 6)) == round(2 + (x**2 - 1) ** 2, 6)
