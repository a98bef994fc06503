"""Tanaka's regression against exact fractions, HiGHS and cvxpy; ties, windows, bad input."""

import re
from fractions import Fraction
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.test_util import check_grads

import tests.oracles_tanaka as oracle
from filters.fuzzy_line import line, newest_line
from filters.fuzzy_regression import regression
from tuner.certificate.solution import Status
from tuner.convex import solve
from tuner.regression import (
    Outcome,
    corners,
    interior,
    many,
    tanaka,
    tanaka_program,
    tanaka_simplex,
    tanaka_windows,
)

EXACT = 1e-9
# Without the compiler's optimisation, which changes no formula and takes most of the time.
quickly = partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0})


def floats(values):
    return np.array([float(Fraction(value)) for value in values])


def close(found, wanted, size=1.0):
    np.testing.assert_allclose(
        found, [float(v) for v in np.atleast_1d(wanted)], rtol=0, atol=EXACT * size
    )


def agrees(found, exact):
    """A regression with an exact one."""
    size = 1 + max(abs(float(v)) for v in (*exact.p, *exact.c, exact.J))
    assert found.unique == exact.unique
    close(found.objective, exact.J, size)
    close(found.center, exact.p, size)
    close(found.spread, exact.c, size)
    assert found.violation <= EXACT * size
    assert abs(found.gap) <= EXACT * size


@pytest.mark.parametrize("name", oracle.SETS)
def test_the_table_of_the_notes(name):
    given = oracle.SETS[name]
    found = tanaka(floats(given.t), floats(given.x), 0.0, floats(given.e))
    close(found.objective, Fraction(given.J))
    close(found.center, [Fraction(v) for v in given.p])
    close(found.spread, [Fraction(v) for v in given.c])
    assert found.unique == given.unique


@pytest.mark.parametrize("seed", range(40))
def test_random_fractions_are_solved_exactly(seed):
    """Ties, repeated rows, missing rank, fuzzy samples and both signs are all among them."""
    rng = np.random.default_rng(seed)
    m = int(rng.integers(1, 7))
    t = rng.integers(-3, 5, (m, int(rng.integers(1, 3)) if m < 6 else 1))
    x, h = rng.integers(-6, 7, m), Fraction(int(rng.integers(0, 4)), 4)
    e = rng.integers(0, 4, m) if seed % 2 else np.zeros(m, int)
    exact = oracle.fit(t.tolist(), x.tolist(), h, e.tolist(), scaled=True)
    agrees(tanaka(t, x, float(h), e), exact)


@pytest.mark.parametrize("seed", range(10))
def test_multipliers_prove_the_objective(seed):
    """Summed up here by hand: feasible for the dual, and worth as much as the primal."""
    rng = np.random.default_rng(100 + seed)
    t, x, e, h = rng.normal(size=(9, 2)), rng.normal(size=9), rng.uniform(0, 1, 9), 0.3
    found = tanaka(t, x, h, e)
    T = np.column_stack([np.ones(9), t])
    u, v, w = found.above, found.below, found.least
    assert min(u.min(), v.min(), w.min()) >= 0
    close((u - v) @ T, np.zeros(3))
    close((1 - h) * (u + v) @ abs(T) + w, abs(T).sum(axis=0))
    close((u - v) @ x + (1 - h) * (u + v) @ e, found.objective, 10)
    assert (abs(x - T @ found.center) <= (1 - h) * (abs(T) @ found.spread - e) + EXACT).all()


@pytest.mark.parametrize(("m", "k"), [(4, 1), (10, 1), (9, 2), (14, 3)])
def test_windows_met_before_change_no_answer(m, k):
    """Integers, so that many windows have several optima and pass through degenerate corners."""
    rng = np.random.default_rng(m)
    t, fuzzy = rng.integers(-4, 5, (m, k)), rng.integers(0, 3, (60, m))
    x = rng.integers(-3, 4, (60, m))
    after = [tanaka(t, one, 0.25, e) for one, e in zip(x, fuzzy, strict=True)]
    for one, e, found in zip(x, fuzzy, after, strict=True):
        corners.corners.cache_clear()
        alone = tanaka(t, one, 0.25, e)
        assert (found.status, found.message) == (alone.status, alone.message)
        for name in ("center", "spread", "objective", "above", "below", "least"):
            np.testing.assert_allclose(getattr(found, name), getattr(alone, name), atol=1e-13)


@pytest.mark.parametrize("kept", [1 << 16, 300])
def test_windows_met_before_are_solved_from_corner_to_corner(kept, monkeypatch):
    """Without the interior-point method, however many corners may be kept; HiGHS agrees."""
    monkeypatch.setattr(corners, "KEPT", kept)
    rng = np.random.default_rng(kept)
    t, x = rng.uniform(0, 9, 10), rng.normal(size=(40, 10))
    tanaka(t, x[0])
    monkeypatch.delattr(interior, "interior_point")
    for one in x:
        found, simplex = tanaka(t, one), tanaka_simplex(t, one)
        assert found.unique
        close(found.objective, simplex.objective)
        close(found.center, simplex.center)
        close(found.spread, simplex.spread)


def test_a_window_of_many_regressors_is_left_to_the_interior_point(monkeypatch):
    monkeypatch.setattr(corners, "STEPS", 2)
    rng = np.random.default_rng(0)
    t, x = rng.normal(size=(20, 3)), rng.normal(size=(5, 20))
    for one in x:
        close(tanaka(t, one).objective, tanaka_simplex(t, one).objective)


@pytest.mark.parametrize(("m", "noise"), [(4, -7), (6, -7), (6, -10)])
def test_one_large_sample_among_small_ones(m, noise):
    """Met for the first time or not: an interior point does not tell rows so near apart."""
    rng = np.random.default_rng(m - noise)
    for _ in range(10):
        x = [Fraction(int(n), 10**-noise) for n in rng.integers(-9, 10, m)]
        x[rng.integers(m)] = Fraction(1)
        exact = oracle.fit([[Fraction(t)] for t in range(m)], x)
        corners.corners.cache_clear()
        agrees(tanaka(np.arange(m), floats(x)), exact)


@pytest.mark.parametrize("offset", [1e4, 1e6, 1e8])
def test_times_far_from_zero(offset):
    rng = np.random.default_rng(int(offset))
    for x in rng.normal(size=(5, 6)):
        found, simplex = (f(offset + np.arange(6), x) for f in (tanaka, tanaka_simplex))
        assert found.status is Outcome.UNIQUE
        assert found.objective == pytest.approx(simplex.objective, rel=1e-9)


@pytest.mark.parametrize(
    ("t", "x"),
    [
        ([1, 1 + 1e-10], [7.0, 7.0]),
        (1.7e9 + np.arange(6), [0.7] * 6),
        (1.7e9 + np.arange(6), [0.0, 1, 5, 2, 3, 1]),
        (132_000 + np.arange(6), [0.9, 0.8, 0.0, 0.7, -0.7, -1.8]),
        ([[1, 1e-16], [2, 3e-16], [1, 5e-16], [3, 1e-16]], [0, 1, 5, 2.0]),
    ],
)
def test_times_that_hardly_differ_end_with_a_status(t, x):
    found, simplex = tanaka(t, x), tanaka_simplex(t, x)
    assert found.unique == (found.status is Outcome.UNIQUE)
    assert np.isfinite(found.center).all()
    assert found.objective == pytest.approx(simplex.objective, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("unit", [1.0, 1e-6, 1e-12])
def test_a_tie_does_not_depend_on_the_regressors_unit(unit):
    t = unit * np.array([[-1.0, 2], [2, 3], [1, 3], [-1, 3]])
    found = tanaka(t, [4, -1, 2, -4])
    assert found.status is Outcome.SEVERAL
    close(found.center * [1, unit, unit], [17, 1, -6])


def test_answers_that_no_number_holds_are_not_unique():
    for t, x in (
        ([0, 1e-200, 2e-200, 3e-200], [0, 1e200, 5e200, 2e200]),
        (range(3), [1e308, -1e308, 0]),
    ):
        with np.errstate(over="ignore"):
            found = tanaka(t, x)
        assert found.status is Outcome.INEXACT
        assert "larger than any number" in found.message


def test_a_long_window_needs_no_square_of_its_length():
    """20 000 squared would be 3 GB."""
    t = np.linspace(0, 9, 20_000)
    found = tanaka(t, np.random.default_rng(0).normal(size=len(t)))
    assert found.unique
    assert max(found.violation, abs(found.gap) / found.objective) <= 1e-12


def test_for_crisp_samples_h_scales_the_spread_alone():
    """Where the optimum is unique, and where it is not."""
    for t, x in (((1, 2, 3, 4, 5), (8.0, 6.4, 9.5, 13.5, 13.0)), ((0, 1, 2), (0.0, 1.0, 0.0))):
        plain, half = tanaka(t, x), tanaka(t, x, 0.5)
        close(half.center, plain.center)
        close(half.spread, 2 * plain.spread)
        close(half.objective, 2 * plain.objective)


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("span", [1e-12, 1.0, 1e12])
def test_units_do_not_matter(size, span):
    t, x = np.arange(1.0, 6.0), np.array([8.0, 6.4, 9.5, 13.5, 13.0])
    found = tanaka(span * t, size * x)
    assert found.unique
    close(found.center / size * np.array([1.0, span]), floats(("89/20", "11/6")), 10)
    close(found.spread / size * np.array([1.0, span]), floats(("103/60", "0")), 10)


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1.0, 100.0])
def test_the_program_takes_small_samples(size):
    t, x = [1, 2, 3, 4, 5], np.array([8.0, 6.4, 9.5, 13.5, 13.0])
    answer = solve(tanaka_program(t), {"x": size * x})
    assert answer.status is Status.CONVERGED
    np.testing.assert_allclose(answer.variables["center"] / size, tanaka(t, x).center, rtol=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_highs_and_cvxpy_agree_on_the_objective(seed):
    rng = np.random.default_rng(seed)
    t, x = rng.normal(size=(8, 2)), rng.normal(size=8)
    found = tanaka(t, x)
    close(tanaka_simplex(t, x).objective, found.objective, 10)
    close(tanaka_simplex(t, x).center, found.center, 10)
    answer = solve(tanaka_program(t), {"x": x})
    np.testing.assert_allclose(answer.value, found.objective, rtol=1e-7)
    np.testing.assert_allclose(answer.variables["center"], found.center, atol=1e-6)


def test_one_program_takes_many_samples():
    program = tanaka_program([0, 1, 2, 3], h=0.5)
    for x in ([1.0, 3.0, 5.0, 8.0], [2.0, 0.0, 1.0, 0.0]):
        wanted = tanaka([0, 1, 2, 3], x, 0.5, [0.1, 0.2, 0.0, 0.3])
        answer = solve(program, {"x": x, "e": [0.1, 0.2, 0.0, 0.3]})
        np.testing.assert_allclose(answer.value, wanted.objective, rtol=1e-7)
        np.testing.assert_allclose(answer.duals["above"], wanted.above, atol=1e-5)


# --- many windows -------------------------------------------------------------------------------


@pytest.mark.parametrize("m", [2, 7])
@pytest.mark.parametrize("fuzzy", [False, True])
def test_windows_are_those_of_one_by_one(m, fuzzy):
    """An odd number of samples has many ties; signs of t make another dual."""
    rng = np.random.default_rng(m)
    t = np.arange(m) - (2.0 if fuzzy else 0.0)
    x = rng.integers(-3, 4, (many.FEW, m)).astype(float)
    e = rng.uniform(0, 1, x.shape) if fuzzy else None
    found = tanaka_windows(t, x, 0.25, e)
    for i in range(25):
        same(found, i, tanaka(t, x[i], 0.25, None if e is None else e[i]), [4.0, 4.0])


def test_every_window_may_have_its_own_t():
    """Of any scale; one of them determines no center; the last block is not full."""
    rng = np.random.default_rng(0)
    count = many.BLOCK + 7
    t = rng.normal(size=(count, 6, 2)) * 10.0 ** rng.integers(-12, 12, (count, 1, 2))
    t[-1] = 3.0
    x = rng.normal(size=(count, 6)) * 10.0 ** rng.integers(-12, 12, (count, 1))
    e = 0.1 * np.abs(x) * rng.uniform(size=6)
    found = tanaka_windows(t, x, 0.5, e)
    assert found.unique[:-1].mean() > 0.9
    assert not found.unique[-1]
    for i in (0, 1, 2, many.BLOCK, count - 1):
        size = np.abs(x[i]).max() / np.array([1.0, *np.abs(t[i]).max(axis=0)])
        same(found, i, tanaka(t[i], x[i], 0.5, e[i]), size)


def same(found, i, one, size):
    """A window of many is the regression of its own; size: of its coefficients."""
    assert found.unique[i] == one.unique
    np.testing.assert_allclose(found.objective[i] / size[0], one.objective / size[0], atol=EXACT)
    np.testing.assert_allclose(found.center[i] / size, one.center / size, atol=EXACT)
    np.testing.assert_allclose(found.spread[i] / size, one.spread / size, atol=EXACT)


def test_few_windows_long_ones_and_those_of_one_time_are_solved_all_the_same():
    rng = np.random.default_rng(0)
    long = rng.normal(size=(2, 40))
    found = tanaka_windows(np.arange(40), long)
    close(found.center[1], tanaka(np.arange(40), long[1]).center)
    still = tanaka_windows([2, 2, 2], [[0.0, 1.0, 3.0]])
    assert not still.unique[0]
    close(still.objective, Fraction(9, 2))
    assert tanaka_windows([0, 1], np.empty((0, 2))).center.shape == (0, 2)


# --- inside a time loop -------------------------------------------------------------------------


@pytest.mark.parametrize(("m", "k", "count"), [(6, 1, 40), (5, 2, 16)])
def test_random_fractions_are_solved_exactly_there(m, k, count):
    """Side by side: where the optimum is unique it is found, and most often known to be so."""
    rng = np.random.default_rng(m)
    t = rng.integers(-3, 5, (count, m, k))
    x, e = rng.integers(-6, 7, (count, m)), rng.integers(0, 3, (count, m))
    of_t, of_x, of_e = (jnp.asarray(np.moveaxis(a, 0, -1), float) for a in (t, x, e))
    found = quickly(regression)(of_t, of_x, 0.25, of_e)
    exact = [
        oracle.fit(t[i].tolist(), x[i].tolist(), Fraction(1, 4), e[i].tolist())
        for i in range(count)
    ]
    unique = np.array([one.unique for one in exact])
    assert not (found.unique & ~unique).any()
    assert found.unique.sum() > 0.9 * unique.sum()
    assert count / 4 < unique.sum() < count
    for i, one in enumerate(exact):
        if one.unique:
            close(found.center[i], one.p)
            close(found.spread[i], one.c)


def test_derivatives_of_a_regression_are_those_of_the_solution():
    """By t, x, h and e, forwards and backwards, against differences."""
    rng = np.random.default_rng(1)
    given = rng.normal(size=(6, 2)), rng.normal(size=(6, 1)), 0.2, rng.uniform(size=(6, 1))
    fitted = jax.jit(lambda t, x, h, e: regression(t, x, h, e)[:2])
    check_grads(fitted, tuple(jnp.asarray(a) for a in given), order=1, atol=1e-6, rtol=1e-6)


@pytest.mark.parametrize("m", [2, 4, 6, 8, 10, 12])
def test_a_line_inside_the_time_loop(m):
    rng = np.random.default_rng(m)
    window = rng.normal(size=(m, 5))
    found = jax.jit(line, static_argnums=(1, 2))(jnp.asarray(window), 0.25, 0.5)
    for i, x in enumerate(window.T):
        exact = oracle.strip([0.25 * j for j in range(m)], x.tolist(), 0.5, number=float)
        close(found.center[i, 1], exact.p1[0])
        close(found.spread[i, 1], exact.c1[0])
        wanted = tanaka(0.25 * np.arange(m), x, 0.5)
        close(found.center[i], wanted.center)
        close(found.spread[i], wanted.spread)


def test_its_derivative_is_that_of_the_solution():
    window = np.random.default_rng(0).normal(size=(6, 1))
    slope = lambda x: line(x[:, None], 1.0).center[0, 1]  # noqa: E731
    gradient = jax.grad(slope)(jnp.asarray(window[:, 0]))
    for j, step in enumerate(1e-6 * np.eye(6)):
        ahead, behind = (tanaka(np.arange(6), window[:, 0] + s).center[1] for s in (step, -step))
        np.testing.assert_allclose(gradient[j], (ahead - behind) / 2e-6, atol=1e-8)


FUSED = {"xla_cpu_use_fusion_emitters": True, "xla_backend_optimization_level": 3}


@pytest.mark.parametrize("m", [6, 8, 12])
def test_a_line_that_ties_with_others_holds_all_samples(m):
    window = np.random.default_rng(m).integers(-3, 4, (m, 2000)).astype(float)
    found = jax.jit(lambda x: line(x, 1.0), compiler_options=FUSED)(jnp.asarray(window))
    t = np.arange(m)[:, None]
    (p0, p1), (c0, c1) = np.asarray(found.center).T, np.asarray(found.spread).T
    assert (np.abs(window - p0 - t * p1) <= c0 + t * c1 + 1e-12).all()
    assert min(c0.min(), c1.min()) >= -1e-12


@pytest.mark.parametrize("m", [6, 8, 12])
def test_a_line_of_samples_that_lie_on_one_is_that_one(m):
    """All bends are rounding then: whatever decides has to be the same for height and slope.

    XLA works out some numbers twice, rounded otherwise, where it puts operations together.
    """
    rng = np.random.default_rng(m)
    right = rng.integers(-9, 9, (2, 200)).astype(float)
    window = jnp.asarray(right[0] + np.arange(m)[:, None] * right[1])
    found = jax.jit(lambda x: line(x, 1.0), compiler_options=FUSED)(window)
    np.testing.assert_allclose(found.center, right.T, atol=1e-12)
    np.testing.assert_allclose(found.spread, 0.0, atol=1e-13)


@pytest.mark.parametrize("m", [4, 8])
def test_where_lines_tie_derivatives_are_of_the_line_that_is_given(m):
    """Whole numbers tie often; compared one after another or at once, the first one counts."""
    window = jnp.asarray(np.random.default_rng(m).integers(-3, 4, (m, 300)), float)

    def summed(x):
        found = newest_line(x, jnp.array(9.0), 0.5, 0.25)
        return found.center.sum() + found.spread.sum(), found

    alone = jax.jit(newest_line, static_argnums=2)(window, jnp.array(9.0), 0.5, 0.25)
    (_, beside), gradient = jax.jit(jax.value_and_grad(summed, has_aux=True))(window)
    assert np.isfinite(gradient).all()
    for one, other in zip(alone, beside, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-13)


def test_the_line_of_the_newest_samples_is_that_of_their_window():
    """With as many as an even number allows, whatever stands before them."""
    window = np.random.default_rng(7).normal(size=(6, 30)) + np.arange(6)[:, None]
    window[0, 0] = np.nan
    newest = jax.jit(newest_line, static_argnums=2)
    for taken, count in ((0, 2), (2, 2), (3, 2), (4, 4), (5, 4), (6, 6), (9, 6)):
        found, alone = newest(window, float(taken), 0.2, 0.3), line(window[6 - count :], 0.2, 0.3)
        np.testing.assert_allclose(found.center, alone.center, rtol=1e-13, atol=1e-13)
        np.testing.assert_allclose(found.spread, alone.spread, rtol=1e-13, atol=1e-13)
    with pytest.raises(ValueError, match="even"):
        newest_line(window[1:], jnp.array(5.0), 0.2)


def test_an_odd_number_of_samples_is_refused_there():
    with pytest.raises(ValueError, match="a line through 5 equally spaced samples need not be"):
        line(jnp.zeros((5, 1)), 1.0)


# --- bad input ----------------------------------------------------------------------------------

REFUSED = {
    "empty": (([], []), {}, "the window is empty; give at least one sample"),
    "nan": (([0, 1, 2], [0, np.nan, 1]), {}, "x is nan at 1; leave the sample out"),
    "infinite t": (([[0, 1], [np.inf, 2]], [0, 1]), {}, "t is inf at (1, 0); leave the sample"),
    "h = 1": (([0, 1], [0, 1]), {"h": 1.0}, "h must be at least 0 and below 1"),
    "negative h": (([0, 1], [0, 1]), {"h": -0.1}, "got -0.1"),
    "nan h": (([0, 1], [0, 1]), {"h": np.nan}, "got nan"),
    "shapes": (([0, 1, 2], [0, 1]), {}, "t has the shape (3,), x (2,) and e (2,)"),
    "spread": (([0, 1], [0, 1]), {"e": [0.0, -1.0]}, "a spread e is -1 at 1"),
    "tiny x": (([0, 1, 2], [0, 1e-310, 0]), {}, "span 1e-310 only; give them in a smaller unit"),
    "tiny t": (([0, 1e-310, 2e-310], [0, 1, 0]), {}, "a regressor is 2e-310 at most; give t in"),
    "sum": (([0, 1], [1e308, 0]), {"e": [1e308, 0]}, "x and e together are larger than any"),
}


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize("function", [tanaka, tanaka_simplex])
def test_refused(name, function):
    given, more, said = REFUSED[name]
    with pytest.raises(ValueError, match=re.escape(said)):
        function(*given, **more)


def test_windows_refuse_what_one_does():
    with pytest.raises(ValueError, match="x is nan in window 1 at 0; leave the window out"):
        tanaka_windows([0, 1], [[0.0, 1.0], [np.nan, 1.0]])
    with pytest.raises(ValueError, match=r"x has the shape \(2,\); W windows"):
        tanaka_windows([0, 1], [0.0, 1.0])
    with pytest.raises(ValueError, match="a spread e is -1"):
        tanaka_windows([0, 1], [[0.0, 1.0]], e=[0.0, -1.0])
    with pytest.raises(ValueError, match=r"t has the shape \(3,\) and x \(1, 2\); give t as"):
        tanaka_windows([0, 1, 2], [[0.0, 1.0]])
    with pytest.raises(ValueError, match="the windows are empty"):
        tanaka_windows([], np.empty((3, 0)))
    with pytest.raises(ValueError, match="h must be at least 0 and below 1"):
        tanaka_windows([0, 1], np.empty((0, 2)), h=1.0)


@pytest.mark.parametrize(
    ("t", "x"),
    [([3], [5.0]), ([2, 2, 2], [0.0, 1.0, 3.0]), ([[1, 2], [3, 5]], [1.0, 2.0]), ([0], [1.0])],
)
def test_what_t_does_not_determine_is_said(t, x):
    found = tanaka(t, x)
    assert not found.unique
    assert found.status is Outcome.UNDETERMINED
    assert "does not determine" in found.message
    assert (abs(found.violation) + abs(found.gap)) <= EXACT


def test_programs_refuse_what_they_cannot_solve():
    with pytest.raises(ValueError, match="t has rank 1 with the intercept and does not determine"):
        tanaka_program([2, 2, 2])
    with pytest.raises(ValueError, match=r"the largest entries of the regressors are 1 to 3e\+12"):
        tanaka_program([0, 1e12, 3e12])
    with pytest.raises(ValueError, match=r"t has the shape \(\)"):
        tanaka_program(3.0)
    with pytest.raises(ValueError, match="'x': Parameter value must be in bounds"):
        solve(tanaka_program([0, 1, 2]), {"x": [0, 1e12, 0]})


@pytest.mark.parametrize(
    ("h", "e"), [(1.0, 0.0), (2.0, 0.0), (-1.0, 0.0), (np.nan, 0.0), (0.0, -1.0)]
)
def test_in_the_time_loop_bad_degrees_and_spreads_give_no_numbers(h, e):
    x = jnp.array([[0.0], [1.0], [5.0], [2.0]])
    found = quickly(regression)(jnp.arange(4.0), x, h, e * jnp.ones_like(x))
    assert not found.unique.any()
    assert np.isnan(found.center).all()
    if not e:
        assert np.isnan(line(x, 1.0, h).spread).all()


def test_in_the_time_loop_an_empty_window_is_refused():
    with pytest.raises(ValueError, match="the window is empty"):
        regression(jnp.zeros((0, 1)), jnp.zeros((0, 2)))


def test_windows_say_how_each_ended():
    found = tanaka_windows([[[0], [0], [1]], [[2], [2], [2]], [[0], [1], [3]]], [[0, 1, 0.5]] * 3)
    assert list(found.status) == [Outcome.SEVERAL, Outcome.UNDETERMINED, Outcome.UNIQUE]


def test_a_tie_is_said():
    found = tanaka([0, 0, 1], [0.0, 1.0, 0.5])
    assert found.status is Outcome.SEVERAL
    assert "several centers" in found.message
