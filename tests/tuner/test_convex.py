"""Convex programs: against HiGHS, against closed forms, and what they refuse."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import cvxpy as cp
import numpy as np
import pytest
from scipy.optimize import linprog

from tuner.certificate.solution import Status
from tuner.convex import ConvexProgram, clarabel, linear_program, reading, solve
from tuner.convex.bound import dual_bound
from tuner.convex.cones import matrix, outside
from tuner.solvers.convex import Convex


def random_program(seed, n=6, k=9, equalities=2):
    """A feasible, bounded linear program: its point and its dual point are known to exist."""
    rng = np.random.default_rng(seed)
    A_ub, A_eq = rng.normal(size=(k, n)), rng.normal(size=(equalities, n))
    x = rng.normal(size=n)
    low = np.where(rng.random(n) < 0.5, -np.inf, x - rng.random(n))
    high = np.where(rng.random(n) < 0.5, np.inf, x + rng.random(n))
    c = -A_ub.T @ rng.random(k) + A_eq.T @ rng.normal(size=equalities)
    return {
        "c": c,
        "A_ub": A_ub,
        "b_ub": A_ub @ x + rng.random(k),
        "A_eq": A_eq,
        "b_eq": A_eq @ x,
        "low": low,
        "high": high,
    }


def highs(c, A_ub=None, b_ub=None, A_eq=None, b_eq=None, low=None, high=None):
    n = len(c)
    low = np.full(n, -np.inf) if low is None else np.broadcast_to(low, n)
    high = np.full(n, np.inf) if high is None else np.broadcast_to(high, n)
    return linprog(c, A_ub, b_ub, A_eq, b_eq, np.column_stack([low, high]), method="highs")


@pytest.mark.parametrize("seed", range(6))
def test_linear_programs_agree_with_highs(seed):
    given = random_program(seed)
    expected = highs(**given)
    answer = solve(linear_program(**given))
    assert answer.status is Status.CONVERGED
    scale = 1 + abs(expected.fun)
    assert abs(answer.value - expected.fun) < 1e-8 * scale
    assert expected.fun - 1e-7 * scale < answer.lower_bound <= expected.fun + 1e-12 * scale
    assert answer.violation < 1e-8
    # The vertices of random programs are unique, and so are their duals: scipy's have our sign
    # the other way round.
    assert answer.variables["x"] == pytest.approx(expected.x, abs=1e-6)
    assert answer.duals["ub"] == pytest.approx(-expected.ineqlin.marginals, abs=1e-6)
    assert answer.duals["eq"] == pytest.approx(-expected.eqlin.marginals, abs=1e-6)


@pytest.mark.parametrize("seed", range(2))
def test_duals_are_strong_and_complementary(seed):
    given = random_program(seed)
    answer = solve(linear_program(**given))
    x, dual = answer.variables["x"], answer.duals
    low, high = (np.isfinite(given[k]) for k in ("low", "high"))
    value = -given["b_ub"] @ dual["ub"] - given["b_eq"] @ dual["eq"]
    value += given["low"][low] @ dual["low"] - given["high"][high] @ dual["high"]
    assert value == pytest.approx(answer.value, abs=1e-7)
    assert (given["b_ub"] - given["A_ub"] @ x) * dual["ub"] == pytest.approx(0, abs=1e-7)
    assert (x - given["low"])[low] * dual["low"] == pytest.approx(0, abs=1e-7)
    assert min(dual[k].min() for k in ("ub", "low", "high")) > -1e-9


def test_one_program_serves_many_right_hand_sides():
    given = random_program(3)
    program = linear_program(**given)
    rng = np.random.default_rng(5)
    for _ in range(2):
        b_ub = given["b_ub"] + 0.1 * rng.random(9)
        expected = highs(**{**given, "b_ub": b_ub}).fun
        assert solve(program, {"b_ub": b_ub}).value == pytest.approx(expected, rel=1e-8)
    assert program.at({"b_ub": b_ub}).answer().value == pytest.approx(expected, rel=1e-8)
    # The program itself is as it was.
    assert program.answer().value == pytest.approx(highs(**given).fun, rel=1e-8)


def test_multipliers_are_relative_slopes():
    given = {"c": [-3.0, -2.0], "A_ub": [[1.0, 1.0], [1.0, 0.0]], "b_ub": [4.0, 3.0], "low": 0.5}
    answer = solve(linear_program(**given))
    wider = highs(**{**given, "b_ub": np.array([4.0, 3.0]) * (1 + 1e-4)}).fun
    slope = (answer.value - wider) / abs(answer.value) / 1e-4
    assert answer.multipliers["ub"] == pytest.approx(slope, rel=1e-6)
    assert answer.multipliers["low"] == pytest.approx(0, abs=1e-8)


@pytest.mark.parametrize(
    ("given", "status"),
    [
        ({"c": [1.0, 0.0], "A_ub": [[1.0, 0.0], [-1.0, 0.0]], "b_ub": [1.0, -2.0]}, "infeasible"),
        ({"c": [-1.0, 0.0], "A_ub": [[1.0, -1.0]], "b_ub": [1.0], "low": 0.0}, "unbounded"),
        # A direction of descent alone does not make it unbounded.
        ({"c": [0.0, -1.0], "A_ub": [[1.0, 0.0], [-1.0, 0.0]], "b_ub": [1.0, -2.0]}, "infeasible"),
        # Six constraints through one vertex of the plane, one of them twice.
        (
            {
                "c": [-1.0, -1.0],
                "A_ub": [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0], [1.0, 2.0], [1.0, 1.0]],
                "b_ub": [1.0, 1.0, 2.0, 3.0, 3.0, 2.0],
            },
            "converged",
        ),
    ],
)
def test_ends_are_told_apart(given, status):
    answer = solve(linear_program(**given))
    expected = highs(**given)
    assert answer.status.value == status
    if status == "converged":
        assert answer.value == pytest.approx(expected.fun, abs=1e-8)
        assert answer.lower_bound == pytest.approx(expected.fun, abs=1e-7)
        return
    # HiGHS calls 4 what it only knows to be infeasible or unbounded.
    assert expected.status in {"infeasible": (2, 4), "unbounded": (3, 4)}[status]
    assert answer.value == {"infeasible": np.inf, "unbounded": -np.inf}[status]
    assert answer.variables == {}
    assert answer.lower_bound is None


def eigenvalue_program():
    """The largest eigenvalue of a symmetric matrix by a matrix inequality."""
    t, A = cp.Variable(), cp.Parameter((4, 4), symmetric=True)
    above = t * np.eye(4) - A >> 0
    problem = cp.Problem(cp.Minimize(t), [above])
    report = lambda answer: {"twice": 2 * answer.value}  # noqa: E731
    return ConvexProgram(
        "eigenvalue", problem, {"A": A}, {"t": t}, {"above": above}, {"A": np.eye(4)},
        {"t": "m"}, report,
    )  # fmt: skip


def symmetric(seed):
    matrix = np.random.default_rng(seed).normal(size=(4, 4))
    return matrix + matrix.T


def test_a_matrix_inequality_and_its_dual():
    program = eigenvalue_program()
    A = symmetric(1)
    answer = solve(program, {"A": A})
    values, vectors = np.linalg.eigh(A)
    assert answer.value == pytest.approx(values[-1], rel=1e-9)
    assert values[-1] - 1e-7 < answer.lower_bound <= values[-1] + 1e-12
    assert answer.duals["above"] == pytest.approx(
        np.outer(vectors[:, -1], vectors[:, -1]), abs=1e-6
    )


def test_the_scaled_triangle_is_read_as_cvxpy_writes_it():
    full = symmetric(2)
    columns, rows = np.tril_indices(4)
    scaled = full[rows, columns] * np.where(rows == columns, 1, np.sqrt(2))
    assert matrix(scaled, 4) == pytest.approx(full)
    dims = type("Dims", (), {"zero": 1, "nonneg": 2, "soc": [3], "psd": [4]})()
    z = np.concatenate([[-9.0, 1.0, -3.0], [1.0, 4.0, -3.0], scaled])
    negative = np.minimum(np.linalg.eigvalsh(full), 0)
    assert outside(z, dims) == pytest.approx(np.sqrt(9 + 16 + negative @ negative))


def test_a_wrong_dual_proves_less():
    # min x where x >= 1: the dual of any z >= 0 is no better than that of the right one.
    data = {
        "c": np.array([1.0]),
        "A": np.array([[-1.0]]),
        "b": np.array([-1.0]),
        "dims": type(
            "D", (), {"zero": 0, "nonneg": 1, "soc": [], "psd": [], "exp": 0, "p3d": []}
        )(),
    }
    for z in (-1.0, 0.0, 0.5, 1.0, 1.5):
        bound = dual_bound(data, np.array([1.0]), np.array([z]), np.array([0.5]))
        assert bound <= 1.0
        assert (bound == 1.0) == (z == 1.0)


def test_a_quadratic_objective_is_bounded_as_well():
    x, low = cp.Variable(3), cp.Parameter(3)
    problem = cp.Problem(cp.Minimize(cp.sum_squares(x) + 7.0), [low <= x])
    program = ConvexProgram("square", problem, {"low": low}, {"x": x}, values={"low": [1, 2, -3]})
    answer = program.answer()
    assert program.kind == "qp"
    assert answer.value == pytest.approx(12.0, rel=1e-9)
    assert 12.0 - 1e-6 < answer.lower_bound <= 12.0 + 1e-12


def test_what_the_solver_does_not_reach_is_not_claimed(monkeypatch):
    program = linear_program(**random_program(1))
    monkeypatch.setattr(clarabel, "TOLERANCES", (1e-30, 1e-6))
    answer = solve(program)
    assert answer.status is Status.CONVERGED
    assert "at a tolerance of 1e-06 only" in answer.message
    monkeypatch.setattr(clarabel, "TOLERANCES", (1e-30,))
    answer = solve(program)
    assert answer.status is Status.STALLED
    assert "short of 1e-30" in answer.message
    assert answer.lower_bound <= highs(**random_program(1)).fun + 1e-12
    monkeypatch.undo()
    monkeypatch.setattr(reading, "_violation", lambda constraint: 1e-3)
    assert solve(program).status is Status.STALLED


def test_threads_do_not_disturb_each_other():
    program = eigenvalue_program()

    def largest(seed):
        own = eigenvalue_program() if seed % 2 else program
        return solve(own, {"A": symmetric(seed)}).value

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(largest, range(12)))
    expected = [np.linalg.eigvalsh(symmetric(seed))[-1] for seed in range(12)]
    assert found == pytest.approx(expected, rel=1e-8)


def parts():
    x, a = cp.Variable(), cp.Parameter(nonneg=True)
    return x, a, cp.Problem(cp.Minimize(cp.abs(x)), [x >= a])


def test_what_is_no_such_program_is_refused():
    x, a, problem = parts()
    with pytest.raises(ValueError, match="^upside is not a minimisation; minimise the negative"):
        ConvexProgram("upside", cp.Problem(cp.Maximize(x), [x <= a]), {"a": a}, {"x": x})
    with pytest.raises(ValueError, match=r"^square breaks cvxpy's rules .* \(DPP\); let each"):
        ConvexProgram("square", cp.Problem(cp.Minimize(x), [x >= a**2 * a]), {"a": a}, {"x": x})
    with pytest.raises(ValueError, match="has a parameter .* without a name in parameters; add"):
        ConvexProgram("p", problem, {}, {"x": x})
    with pytest.raises(ValueError, match="^the variable named 'y' is not part of p; leave it out"):
        ConvexProgram("p", problem, {"a": a}, {"y": cp.Variable()})
    with pytest.raises(ValueError, match="^the constraint named 'c' is not part of p"):
        ConvexProgram("p", problem, {"a": a}, {"x": x}, {"c": x <= 1})
    with pytest.raises(ValueError, match="^unknown variable of p 'X'; there are: x"):
        ConvexProgram("p", problem, {"a": a}, {"x": x}, units={"X": "m"})


def test_wrong_values_are_refused():
    x, a, problem = parts()
    program = ConvexProgram("p", problem, {"alpha": a}, {"x": x})
    for values, message in [
        ({}, r"^p needs a value of shape \(\) for its parameter 'alpha'$"),
        ({"alhpa": 1.0}, "^unknown parameter of p 'alhpa'; did you mean alpha\\? There are: alpha"),
        ({"alpha": [1.0]}, r"^p: 'alpha' has shape \(1,\), but needs \(\)$"),
        ({"alpha": np.nan}, r"^p: 'alpha' is nan at \(\); give finite numbers$"),
        ({"alpha": -1.0}, "^p: 'alpha': Parameter value must be nonnegative"),
    ]:
        with pytest.raises(ValueError, match=message):
            solve(program, values)
    with pytest.raises(ValueError, match="^unknown parameter of p 'b'"):
        program.at({"b": 1.0})
    assert solve(program, {"alpha": 2.0}).value == pytest.approx(2.0)


def test_linear_programs_refuse_shapes_that_do_not_fit():
    for given, message in [
        ({"c": [[1.0]]}, r"^c has shape \(1, 1\), but needs 1 dimension"),
        ({"c": [1.0], "A_ub": [[1.0]]}, "^A_ub and b_ub belong together; give both or neither$"),
        ({"c": [1.0], "A_eq": [[1.0]], "b_eq": [1.0, 2.0]}, r"needs \(2, 1\)$"),
        ({"c": [1.0], "low": [1.0, 2.0]}, r"^low has shape \(2,\), but needs \(1,\) or a number$"),
        ({"c": [1.0], "low": np.nan}, "^linear program: 'low' is nan"),
    ]:
        with pytest.raises(ValueError, match=message):
            solve(linear_program(**given))


def test_a_solver_of_a_study_returns_a_solution():
    program = eigenvalue_program()
    solution = Convex("sdp")(program.at({"A": symmetric(3)}))
    largest = np.linalg.eigvalsh(symmetric(3))[-1]
    assert (solution.problem, solution.solver) == ("eigenvalue", "sdp")
    assert solution.status is Status.CONVERGED
    assert solution.value == pytest.approx(largest, rel=1e-9)
    assert solution.z.shape == (0,)
    assert solution.parameters["t"].unit == "m"
    assert float(solution.parameters["t"].value) == pytest.approx(largest, rel=1e-9)
    assert solution.derived == {"twice": 2 * solution.value}
    assert solution.certificate.lower_bound == pytest.approx(largest, abs=1e-7)
    assert solution.evaluations > 1


def test_the_linear_solver_refuses_more():
    solution = Convex("lp")(linear_program([1.0], [[-1.0]], [-2.0]))
    assert solution.value == pytest.approx(2.0)
    assert solution.certificate.multipliers["ub"] == pytest.approx(1.0)
    with pytest.raises(ValueError, match=r"^eigenvalue is no linear program \(it needs matrix in"):
        Convex("lp")(eigenvalue_program())
    x, _, _ = parts()
    quadratic = ConvexProgram("q", cp.Problem(cp.Minimize(x**2)), {}, {"x": x})
    with pytest.raises(ValueError, match=r"\(it needs a quadratic objective\); solve it by sdp$"):
        Convex("lp")(quadratic)
    with pytest.raises(ValueError, match="^unknown convex solver 'spd'; did you mean sdp"):
        Convex("spd")


def test_an_impossible_program_becomes_a_solution_as_well():
    report = replace(eigenvalue_program(), report=None)
    assert Convex("sdp")(report).derived == {}
    solution = Convex("lp")(linear_program([1.0], [[1.0], [-1.0]], [1.0, -2.0]))
    assert solution.status is Status.INFEASIBLE
    assert solution.parameters == {}
    assert solution.certificate.lower_bound is None


def test_cvxpy_is_loaded_when_it_is_used():
    code = "import sys, tuner, tuner.convex, tuner.observers.lmi; assert 'cvxpy' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


SIZES = [1e-12, 1e-6, 1e6, 1e12]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("price", [1e-12, 1.0, 1e12])
def test_sides_and_costs_of_any_size(size, price):
    """The same program in other units has the same solution in these, multipliers as well."""
    given = random_program(0)
    plain = solve(linear_program(**given))
    sides = {name: size * given[name] for name in ("b_ub", "b_eq", "low", "high")}
    answer = solve(linear_program(**(given | sides | {"c": price * given["c"]})))
    assert answer.status is Status.CONVERGED
    assert answer.value / (size * price) == pytest.approx(plain.value, rel=1e-7)
    assert answer.variables["x"] / size == pytest.approx(plain.variables["x"], abs=1e-6)
    assert answer.duals["ub"] / price == pytest.approx(plain.duals["ub"], abs=1e-6)
    assert abs(answer.gap) < 1e-7 * size * price * (1 + abs(plain.value))


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1.0, 1e6])
def test_a_curved_objective_of_any_size(size):
    """The point of a plane nearest to one beside it, by hand.

    Not of 1e12: a @ x is 5e-4 by rounding then, which counts as a violation beside a side of 0.
    """
    x, at = cp.Variable(3), cp.Parameter(3)
    a = np.array([1.0, 2.0, -2.0])
    problem = cp.Problem(cp.Minimize(cp.sum_squares(x - at)), [a @ x == 0])
    near = ConvexProgram("near", problem, {"at": at}, {"x": x})
    point = np.array([3.0, 1.0, 1.0])
    answer = solve(near, {"at": size * point})
    assert answer.status is Status.CONVERGED
    foot = point - a * (a @ point) / 9
    assert answer.variables["x"] / size == pytest.approx(foot, abs=1e-6)
    assert answer.value / size**2 == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("size", SIZES)
def test_infeasible_in_any_unit(size):
    x, low = cp.Variable(), cp.Parameter()
    program = ConvexProgram(
        "empty", cp.Problem(cp.Minimize(x), [x >= low, 2 * x <= low]), {"low": low}, {"x": x}
    )
    assert solve(program, {"low": size}).status is Status.INFEASIBLE
    assert solve(program, {"low": -size}).status is Status.CONVERGED


@pytest.mark.parametrize("far", [1e6, 1e8, 1e10])
def test_a_bound_that_is_far_off_changes_nothing(far):
    """Sides of 1 beside a large one, and a cost of 1 beside a large one."""
    z, bound = cp.Variable(2), cp.Parameter()
    near = cp.Problem(cp.Minimize(cp.sum(z)), [z >= 1, z <= bound])
    answer = solve(ConvexProgram("near", near, {"bound": bound}, {"z": z}), {"bound": far})
    assert answer.status is Status.CONVERGED
    assert answer.value == pytest.approx(2.0, abs=1e-8)


def test_unbounded_beside_a_large_cost():
    z, cost = cp.Variable(2), cp.Parameter(nonneg=True)
    falls = cp.Problem(cp.Minimize(-z[0] + cost * z[1]), [z >= 0])
    answer = solve(ConvexProgram("falls", falls, {"cost": cost}, {"z": z}), {"cost": 1e8})
    assert answer.status is Status.UNBOUNDED


def test_a_large_curvature_beside_a_small_slope():
    z, weight = cp.Variable(), cp.Parameter(nonneg=True)
    bowl = cp.Problem(cp.Minimize(weight * z**2 - z), [z >= 0])
    answer = solve(ConvexProgram("bowl", bowl, {"weight": weight}, {"z": z}), {"weight": 1e6})
    assert answer.variables["z"] == pytest.approx(5e-7, rel=1e-3)
