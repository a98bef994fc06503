"""fminsearch: the same search as scipy's and Octave's, and what it does at Kownacki's Table 1."""

import shutil
import subprocess
from functools import cache

import numpy as np
import pytest
from scipy.optimize import minimize, rosen

from studies.kownacki2010 import problems
from studies.kownacki2010.data import benches
from studies.kownacki2010.paper import ACC, GYRO
from studies.kownacki2010.settings import Settings
from tuner.solvers import fminsearch, nelder_mead


def quadratic(x):
    return (x[0] - 3.0) ** 2 + 2.0 * (x[1] + 1.0) ** 2 + (x[0] - 3.0) * (x[1] + 1.0) + 5.0


def absolute(x):
    return float(np.abs(x - np.array([1.0, -2.0])[: len(x)]).sum())


def steps(x):
    """Many equal values: the order of ties counts."""
    return float(np.round(np.abs(x).sum(), 1))


def wall(x):
    """Infinite beyond a line."""
    return float(x @ x) if x[0] > 0.2 else np.inf


CASES = {
    "quadratic": (quadratic, [1.0, 1.0]),
    "quadratic from the axis": (quadratic, [0.0, 1.0]),
    "quadratic from zero": (quadratic, [0.0, 0.0]),
    "Rosenbrock": (rosen, [-1.2, 1.0]),
    "Rosenbrock in four": (rosen, [-1.2, 1.0, 0.0, 0.7]),
    "one coordinate": (lambda x: (x[0] - 2.0) ** 4, [0.1]),
    "absolute": (absolute, [0.4, 0.7]),
    "absolute from zero": (absolute, [0.0, 0.0]),
    "steps": (steps, [2.0, -3.0]),
    "wall": (wall, [1.0, 1.0]),
    "far too large for the tolerance": (lambda x: 1e6 * quadratic(1e-3 * x), [1e3, 1e3]),
    "far too small for the tolerance": (lambda x: 1e-6 * quadratic(1e6 * x), [1e-6, 1e-6]),
}


def traced(function):
    points = []

    def call(x):
        points.append(np.array(x))
        return function(x)

    return call, points


@pytest.mark.parametrize("case", CASES)
def test_same_as_scipy_to_the_bit(case):
    function, start = CASES[case]
    ours, visited = traced(function)
    theirs, expected = traced(function)
    found = fminsearch(ours, np.array(start))
    reference = minimize(
        theirs,
        np.array(start),
        method="Nelder-Mead",
        # scipy stops within an iteration at its cap, MATLAB after it.
        options={"xatol": 1e-4, "fatol": 1e-4, "maxiter": 200 * len(start), "maxfev": 10**6},
    )
    assert np.array(visited).tobytes() == np.array(expected).tobytes()
    assert found.z.tobytes() == reference.x.tobytes()
    assert found.value == reference.fun
    assert found.evaluations == reference.nfev == len(visited)
    assert found.finished == reference.success


def test_start_may_be_whole_numbers_and_stays_as_it_is():
    start = np.array([1, 1])
    found = fminsearch(quadratic, start)
    np.testing.assert_allclose(found.z, [3.0, -1.0], atol=1e-4)
    assert start.tolist() == [1, 1]


def test_first_simplex_is_fminsearchs():
    call, points = traced(quadratic)
    fminsearch(call, np.array([2.0, 0.0]))
    assert np.array(points[:3]).tolist() == [[2.0, 0.0], [2.1, 0.0], [2.0, 0.00025]]


def test_cap_counts_evaluations():
    call, points = traced(rosen)
    found = fminsearch(call, np.linspace(-1.2, 1.0, 8))
    assert not found.finished
    # MATLAB's cap ends the search after the iteration that reaches it: up to n + 1 more.
    assert 1600 <= found.evaluations == len(points) <= 1600 + 10
    assert found.message == f"stopped after {found.evaluations} evaluations"


def test_an_objective_that_is_infinite_everywhere_ends():
    found = fminsearch(lambda x: np.inf, np.array([1.0, 1.0]))
    assert found.value == np.inf
    assert found.evaluations < 200


def test_box_is_never_left():
    low, high = np.array([-1.0, 0.0]), np.array([0.5, 2.0])
    call, points = traced(lambda x: (x[0] - 3.0) ** 2 + (x[1] + 1.0) ** 2)
    simplex = np.array([[0.0, 1.0], [0.5, 1.0], [0.0, 1.5]])
    found = nelder_mead(call, simplex, xtol=1e-8, ftol=1e-8, limit=500, box=(low, high))
    assert ((low <= np.array(points)) & (np.array(points) <= high)).all()
    np.testing.assert_allclose(found.z, [0.5, 0.0], atol=1e-7)
    assert found.finished


# The paper's use of it. A tenth of the rate and a fifth of the length change neither Table 1 nor
# the tolerance that it meets.


def lowest(posed, R):
    """The lowest cost in steps of 5 % of Q/R, at Table 1's R."""
    return min(posed.value(np.log([R, ratio * R])) for ratio in np.geomspace(1, 1e4, 190))


@cache
def search(sensor):
    made = benches(Settings(seconds=2.0, rate_hz=1e3), None, 0)
    posed = problems.paper(next(bench for bench in made if bench.sensor is sensor))
    start = np.array(sensor.table1)

    def cost(values):
        return posed.value(np.log(values)) if (values > 0).all() else np.inf

    return posed, cost, start


@pytest.mark.parametrize("sensor", [GYRO, ACC], ids=["gyro", "acc"])
def test_from_table_1_fminsearch_stops_where_it_began(sensor):
    posed, cost, start = search(sensor)
    found = fminsearch(cost, start)
    assert found.evaluations == 3
    assert found.finished
    # One of the three points of the first simplex: 5 % from Table 1.
    np.testing.assert_allclose(found.z, start, rtol=0.05 * (1 + 1e-12))
    assert found.value > 2 * lowest(posed, start[0])


@pytest.mark.parametrize("sensor", [GYRO, ACC], ids=["gyro", "acc"])
def test_in_decimal_logarithms_it_finds_the_valley(sensor):
    posed, _, start = search(sensor)
    found = fminsearch(lambda v: posed.value(v * np.log(10)), np.log10(start))
    assert found.finished
    assert found.evaluations > 50
    # Never above the scan; below it by what P0 still matters where R is far above it.
    assert 0.95 < found.value / lowest(posed, start[0]) < 1.0


OCTAVE = """
f = @(x) {function};
options = optimset('TolX', 1e-4, 'TolFun', 1e-4, 'Display', 'off');
[x, value, flag, output] = fminsearch(f, {start}, options);
printf('%.17g ', x, value, output.funcCount);
"""


def octave(function, start):
    code = OCTAVE.format(function=function, start=start)
    words = ["octave-cli" if shutil.which("octave-cli") else "octave", "--norc", "--quiet"]
    ran = subprocess.run([*words, "--eval", code], capture_output=True, text=True, check=True)
    *x, value, count = map(float, ran.stdout.split())
    return np.array(x), value, int(count)


@pytest.mark.skipif(not shutil.which("octave"), reason="Octave is not installed")
def test_octaves_fminsearch_does_not_get_stuck():
    """Octave's fminsearch is another one: its first simplex has an edge of 1, whatever the start.

    It ends like ours on a plain function. From Table 1 it leaves at once and finds the valley,
    at an R and Q that have nothing to do with where it began: only Q/R is determined.
    """
    x, _, _ = octave("(x(1)-3)^2 + 2*(x(2)+1)^2 + (x(1)-3)*(x(2)+1) + 5", "[1, 1]")
    np.testing.assert_allclose(x, [3.0, -1.0], atol=2e-3)
    # The cost's valley in (R, Q), ln(Q/R) squared, as low and as slow as the paper's: 5 % of Q
    # or R change it by less than 1e-4. At the bottom that tolerance is 1.8 in ln(Q/R).
    start, optimum = [1.3872e-6, 2.4907e-9], 1027.0
    cost = "3e-5 * log(x(2) / x(1) / 1027)^2 + 1e9 * any(x <= 0)"
    x, _, _ = octave(cost, repr(start))
    assert abs(np.log(x[1] / x[0] / optimum)) < 1.8
    assert x[0] > 1000 * start[0]
    assert x[1] > 1000 * start[1]
    ours = fminsearch(
        lambda v: 3e-5 * np.log(v[1] / v[0] / optimum) ** 2 if (v > 0).all() else 1e9,
        np.array(start),
    )
    assert ours.evaluations == 3
    assert ours.z[1] / ours.z[0] < 0.01
