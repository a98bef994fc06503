"""Statuses are tried on neighbours: saddles, kinks, steps, plateaus, starts that differ."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from tuner.certificate.solution import Status
from tuner.problem.parameters import Limited, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers import Gradient, Ipopt, Known, NelderMead
from tuner.solvers.gradient import minimise

AROUND = Space.of(x=Limited(0.0, -4.0, 4.0), y=Limited(0.0, -4.0, 4.0))
LOGS = Space.of(a=Positive(0.1, 1e-3, 1e3), b=Positive(1.0, 1e-2, 1e2))
TIMES = jnp.linspace(0.0, 10.0, 200)


either = pytest.mark.parametrize(
    "solver", [Gradient("l-bfgs-b", seed=0), NelderMead(seed=0)], ids=["gradient", "simplex"]
)


def itself(values):
    return values


def posed(objective, space=AROUND):
    return Problem("tried", space, None, itself, objective)


def well(p, _):
    """A saddle at 0 between two minima of 2."""
    return 2 + (p["x"] ** 2 - 1) ** 2 + p["y"] ** 2


@pytest.mark.parametrize(
    "solver", [Gradient("l-bfgs-b", seed=0, starts=1), Ipopt(seed=0, starts=1)], ids=["bfgs", "ip"]
)
def test_a_search_that_begins_on_a_saddle_goes_on(solver):
    solution = solver(posed(well))
    assert solution.status is Status.CONVERGED
    assert solution.value == pytest.approx(2.0, abs=1e-9)


def test_a_formula_that_gives_a_saddle_is_told_so():
    formula = Known("formula", lambda _: {"x": 0.0, "y": 0.0}, "a wrong one")
    solution = formula(posed(well))
    assert solution.status is Status.SADDLE
    assert not solution.status.trusted


def rounded(p, _):
    return 1 + jnp.round(20 * ((jnp.log(p["a"]) - 1) ** 2 + jnp.log(p["b"]) ** 2)) / 20


def test_a_staircase_is_told_and_searched_without_derivatives():
    solution = Gradient("l-bfgs-b", seed=0)(posed(rounded, LOGS))
    assert solution.status is Status.STAIRCASE
    assert solution.value == 1.0


def largest(p, _):
    decay = jnp.exp(-p["a"] * TIMES) - jnp.exp(-0.7 * TIMES)
    return 0.01 + jnp.max(jnp.abs(decay)) + 0.1 * jnp.abs(p["b"] - 2)


def test_a_kink_has_a_word_of_its_own():
    solution = Gradient("l-bfgs-b", seed=0)(posed(largest, LOGS))
    assert solution.status is Status.KINK
    assert solution.status.trusted
    assert solution.value == pytest.approx(0.01, rel=1e-3)


def ridge(p, _):
    """Kinked along x = y, and falling along it alone."""
    return 3 + 20 * jnp.abs(p["x"] - p["y"]) + (p["x"] + p["y"] - 3) ** 2


@pytest.mark.parametrize(
    "solver", [Gradient("l-bfgs-b", seed=0), NelderMead(seed=0)], ids=["g", "n"]
)
def test_a_kinked_valley_is_followed_to_its_end(solver):
    solution = solver(posed(ridge))
    assert solution.status in (Status.KINK, Status.CONVERGED)
    assert solution.value == pytest.approx(3.0, rel=1e-3)


def perfect(p, _):
    decay = jnp.exp(-p["a"] * TIMES) - jnp.exp(-0.7 * TIMES)
    return jnp.mean(decay**2) + (p["b"] - 2) ** 2


@pytest.mark.parametrize(
    "solver", [Gradient("l-bfgs-b", seed=0), NelderMead(seed=0)], ids=["g", "n"]
)
def test_a_perfect_fit_has_converged(solver):
    solution = solver(posed(perfect, LOGS))
    assert solution.status is Status.CONVERGED
    assert solution.certificate.starts.agreeing == 4


def walled(p, _):
    """A wide basin of 1 at x = -2; before a wall that ends at x = 2.4 a hole of 0 at x = 2.1."""
    x, y = p["x"], p["y"]
    hole = jnp.where(jnp.abs(x - 2.1) < 0.05, 100 * (x - 2.1) ** 2, 60.0)
    behind = jnp.where(x > 2.4, 2 + 20 * (x - 2.4), hole)
    return jnp.where(x < 0, 1 + (x + 2) ** 2 + (y + 2) ** 2, behind + (y - 1) ** 2)


@pytest.mark.parametrize("x", [2.6, 3.0, 3.5, 3.5 + 1e-9, 3.5 + 1e-6, 3.501])
def test_a_descent_that_a_jump_ends_has_the_lowest_point_it_saw(x):
    """Before the wall it is above 2 and y has come near 1; within it is 60."""
    problem = posed(walled)
    limits = {"gtol": 1e-8, "maxiter": 200}
    end = minimise(problem, np.array([x, 1.3]), "l-bfgs-b", limits, problem.space.box())
    assert end.blocked
    assert end.value == problem.value(end.z)
    assert 2 < end.value < 2.1


@pytest.mark.parametrize("moved", [0.0, 1e-9, -1e-6, 1e-3])
def test_an_end_that_a_jump_keeps_from_the_best_one_goes_on(moved):
    box = {"x": Limited(-1.0, -4.0, 4.0), "y": Limited(-1.0, -4.0, 4.0)}
    beyond = AROUND.unconstrain({"x": 3.5 + moved, "y": 1.3})
    problem = replace(posed(walled, Space.of(**box)), known_starts=(beyond,))
    solution = Gradient("l-bfgs-b", seed=0, starts=2)(problem)
    assert solution.value < 1e-3
    assert solution.status is Status.STARTS_DIFFER


def wells(p, _):
    """Many minima, about as deep: every start ends in its own."""
    x, y = p["x"], p["y"]
    tilt = 0.3 * (jnp.sin(1.7 * x + 0.3) + jnp.sin(2.3 * y + 1.1))
    return 3 + tilt - 2 * jnp.cos(9 * x) * jnp.cos(9 * y)


def test_starts_that_end_apart_are_not_called_converged():
    solution = Gradient("l-bfgs-b", seed=3, starts=8)(posed(wells))
    starts = solution.certificate.starts
    assert solution.status is Status.STARTS_DIFFER
    assert starts.agreeing < starts.count / 2
    assert starts.worst > 1e-3


def plateau(p, _):
    """Flat over decades, with one narrow valley."""
    return 2 - jnp.exp(-((jnp.log(p["a"]) - 5) ** 2)) - jnp.exp(-(jnp.log(p["b"]) ** 2))


def test_ends_on_a_plateau_find_the_valley():
    solution = Gradient("l-bfgs-b", seed=0, starts=4)(posed(plateau, LOGS))
    assert solution.status is Status.CONVERGED
    assert solution.value == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(np.log(float(solution.parameters["a"].value)), 5.0, atol=1e-3)


def holed(p, _):
    """Not a number where the search begins."""
    x, y = jnp.log(p["a"]), jnp.log(p["b"])
    return jnp.where(x < 0, jnp.nan, 1 + (x - 1) ** 2 + y**2)


def test_lost_starts_are_drawn_again():
    solution = Gradient("l-bfgs-b", seed=0, starts=4)(posed(holed, LOGS))
    assert solution.status is Status.CONVERGED
    assert (solution.certificate.starts.count, solution.certificate.starts.agreeing) == (4, 4)
