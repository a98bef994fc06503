"""The graph of scalars: simpler, equal, and the same numbers."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tuner.code import operations
from tuner.code.graph import Graph, TooLargeError
from tuner.code.interpreter import objects
from tuner.code.operations import in_numpy
from tuner.code.primitives import interpreter
from tuner.code.refused import NoCounterpartError


def graph_of(function, *shapes, **options):
    """The graph of a function of arrays, its inputs and its result."""
    graph = Graph(**options)
    given = []
    for k, shape in enumerate(shapes):
        entries = np.empty(shape, object)
        for index in np.ndindex(shape):
            entries[index] = graph.input((k, index))
        given.append(entries)
    traced = jax.make_jaxpr(function)(*(jnp.zeros(shape) for shape in shapes))
    (result,) = objects(graph, interpreter(graph).closed(traced, given))
    return graph, given, result


def value(graph, result, *arrays):
    """The result at a point, by a loop over the nodes."""
    values = []
    for node in graph.nodes:
        given = [values[k] for k in node.args]
        if node.op == "constant":
            values.append(node.value)
        elif node.op == "input":
            k, index = node.value
            values.append(arrays[k][index])
        elif node.op == "choose":
            values.append(given[1] if given[0] else given[2])
        elif node.op == "convert":
            values.append({"real": float, "whole": int, "truth": bool}[node.kind](given[0]))
        else:
            values.append(operations.worked_out(node.op, *given))
    return np.array([values[k] for k in result.ravel()]).reshape(result.shape)


x0 = np.array([0.1, -0.3, 0.5])
FUNCTIONS = {
    "arithmetic": lambda x: (x * 2 - x / 3 + 1) ** 3 + x**-2 - (-x) * 0.5,
    "functions": lambda x: jnp.exp(jnp.sin(x)) + jnp.sqrt(x**2 + 1) * jnp.arctan2(x, 2.0),
    "logistic": lambda x: jax.nn.sigmoid(x) + jax.lax.rsqrt(1 + x**2) + jnp.sign(x - 0.3),
    "sums": lambda x: jnp.cumsum(x) + x.sum() - x.max() * x.min() + jnp.prod(x),
    "places": lambda x: jnp.roll(x, 1) + x[::-1] + x[jnp.array([2, 0, 1])] + jnp.argmax(x),
    "matrices": lambda x: jnp.outer(x, x) @ x + jnp.eye(3) @ x + jnp.diag(x).sum(axis=0),
    "set": lambda x: x.at[1].set(x[0]).at[2].add(x[1]) + jnp.pad(x, 1)[1:4],
    "padded with less": lambda x: jax.lax.pad(x, 2.0, [(-1, 3, 1)])[:3] + x,
    "decisions": lambda x: jnp.where(x > 0.2, x, -x) + jnp.clip(x, -0.5, 0.5) + jnp.abs(x),
    "rounding": lambda x: jnp.floor(3 * x) + jnp.round(2 * x) + jnp.fmod(x, 0.3),
    "a branch": lambda x: jax.lax.cond(x[0] > 0, lambda: x, lambda: 2 * x),
    "a switch": lambda x: jax.lax.switch(
        jnp.int32(3 * x[0]), [lambda: x, lambda: -x, lambda: 0 * x]
    ),
    "a loop": lambda x: jax.lax.scan(lambda s, u: (s * u + x, s.sum()), x, x)[1],
    "whole numbers": lambda x: (
        jnp.int32(50 * x) // 3 + jnp.where(x > 0, 7, 7) // 2 + jnp.sign(jnp.int32(9 * x))
    ),
    "too large for a whole number": lambda x: jnp.int32(x * 1e12) * 1.0,
    "no number made whole": lambda x: jnp.int32(jnp.sqrt(x)) * 1.0,
    "the order of all numbers": lambda x: jnp.searchsorted(jnp.sort(x0), x, method="compare_all"),
    "a table": lambda x: jnp.array([1.0, 4.0, 9.0])[jnp.clip(jnp.int32(3 * x), 0, 2)[0]] * x,
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("point", [(0.7, -0.2, 0.1), (-0.4, 0.9, 0.35)])
def test_it_gives_what_jax_gives(name, point):
    graph, _, result = graph_of(FUNCTIONS[name], (3,))
    x = np.array(point)
    np.testing.assert_allclose(value(graph, result, x), FUNCTIONS[name](jnp.asarray(x)), rtol=1e-13)


numbers = st.sampled_from([0.0, 1.0, -1.0, 0.5, 2.0, 3.0, -0.25])


@st.composite
def formulas(draw, depth=4):
    if depth == 0 or draw(st.booleans()):
        return draw(numbers | st.sampled_from(["x", "y"]))
    op = draw(st.sampled_from(["add", "sub", "mul", "neg", "max", "min", "where"]))
    return (op, *(draw(formulas(depth - 1)) for _ in range({"neg": 1, "where": 4}.get(op, 2))))


def worked_out(formula, apply, choose, known):
    if not isinstance(formula, tuple):
        return known(formula)
    op, *rest = formula
    parts = [worked_out(one, apply, choose, known) for one in rest]
    return choose(apply("gt", *parts[:2]), *parts[2:]) if op == "where" else apply(op, *parts)


@settings(max_examples=60, deadline=None)
@given(formulas(), st.floats(-3, 3), st.floats(-3, 3))
def test_simpler_formulas_are_the_same(formula, x, y):
    graph = Graph()
    known = {"x": graph.input((0, ())), "y": graph.input((1, ()))}
    node = worked_out(
        formula,
        graph.apply,
        graph.choose,
        lambda leaf: known[leaf] if isinstance(leaf, str) else graph.constant(leaf),
    )
    right = worked_out(
        formula,
        in_numpy,
        lambda c, no, yes: yes if c else no,
        lambda leaf: {"x": x, "y": y}[leaf] if isinstance(leaf, str) else leaf,
    )
    found = value(graph, np.array(node), np.array(x), np.array(y))
    np.testing.assert_allclose(found, right, rtol=1e-13, atol=1e-13)


def test_equal_nodes_are_one_and_constants_are_folded():
    graph, (x,), result = graph_of(lambda x: x * 1 + 0 * jnp.exp(x) + (2 - 2) + x - x * 0, ())
    two, same = graph.nodes[result[()]].args
    assert (graph.nodes[two].value, same) == (2.0, x[()])
    graph, _, result = graph_of(lambda x, y: jnp.stack([x + y, y + x]), (), ())
    assert result[0] == result[1]


def test_nan_is_tested_for_and_not_folded_away():
    graph, _, result = graph_of(lambda x: jnp.where(jnp.isnan(x), 0.0, x), ())
    assert [node.op for node in graph.nodes if node.kind == "truth"] == ["isnan"]
    assert value(graph, result, np.array(np.nan)) == 0


def test_a_condition_that_is_chosen_by_already_chooses_nothing():
    graph = Graph()
    far, (x, y, z) = graph.input("far", "truth"), (graph.input(name) for name in "xyz")
    assert graph.choose(far, graph.choose(far, x, y), z) == graph.choose(far, x, z)
    assert graph.choose(far, z, graph.choose(far, x, y)) == graph.choose(far, z, y)
    near = graph.input("near", "truth")
    inner = graph.choose(near, x, y)
    assert graph.nodes[graph.choose(far, inner, z)].args == (far, z, inner)


def test_nan_in_the_place_of_nan_is_the_number_itself():
    graph = Graph()
    x, nan = graph.input("x"), graph.constant(np.nan)
    missing = graph.apply("isnan", x)
    assert graph.choose(missing, x, nan) == x
    filled = graph.choose(missing, x, graph.constant(0.0))
    assert graph.choose(missing, filled, nan) == x
    assert graph.choose(missing, graph.input("y"), nan) != x


def mean(A):
    return (A + A.T) / 2


def test_a_mean_of_what_is_symmetric_by_its_formula_is_one_of_both():
    graph, _, result = graph_of(lambda F: mean(F @ F.T), (3, 3))
    assert not any(
        node.op == "mul" and graph.is_constant(node.args[0], 0.5) for node in graph.nodes
    )
    F = np.random.default_rng(0).normal(size=(3, 3))
    np.testing.assert_allclose(value(graph, result, F), F @ F.T, rtol=1e-13)


@pytest.mark.parametrize(
    "change",
    [
        lambda x, A: jnp.where(x > 100, A, 0.0),
        lambda x, A: jnp.maximum(x - 100, 0.0) * A,
        lambda x, A: jnp.where(jnp.isnan(x), A, 0.0),
        lambda x, A: 1e-9 * A,
    ],
    ids=["beyond a threshold", "above a limit", "where it is missing", "small"],
)
def test_what_is_symmetric_only_where_numbers_are_as_usual_stays_two(change):
    """Far from the points that it is looked at, too."""

    def function(x, F):
        A = F @ F.T
        return mean(A + change(x, F))

    graph, _, result = graph_of(function, (), (2, 2))
    F = np.array([[1.0, 2.0], [5.0, 3.0]])
    for x in (1.0, 1000.0, np.nan):
        right = function(jnp.asarray(x), jnp.asarray(F))
        np.testing.assert_allclose(value(graph, result, np.array(x), F), right, rtol=1e-14)


def test_a_mean_with_what_is_rarely_chosen_stays_one():
    """What an acceleration's length decides is decided the other way at most points."""

    def function(x, s):
        return (1 + jnp.where((s > 0) & (s < jnp.inf) & (s != 1), x, 1.0)) / 2

    graph, _, result = graph_of(function, (), ())
    for x, s in ((3.0, 2.0), (3.0, -2.0), (3.0, np.inf)):
        assert value(graph, result, np.array(x), np.array(s)) == function(x, jnp.asarray(s))


def test_a_graph_may_be_limited():
    with pytest.raises(TooLargeError, match="takes more than 20 operations"):
        graph_of(lambda A: A @ A, (4, 4), most=20)


REFUSED = {
    "(while)": lambda x: jax.lax.while_loop(lambda s: s[0] < 1, lambda s: 2 * s, x),
    "(sort)": jnp.sort,
    "(fft)": lambda x: jnp.fft.fft(x).real,
    "(pure_callback)": lambda x: jax.pure_callback(
        np.asarray, jax.ShapeDtypeStruct((3,), float), x
    ),
    "gather by an index": lambda x: jnp.arange(100.0)[jnp.int32(x)],
    "a table of 98 entries": lambda x: jax.lax.dynamic_slice(
        jnp.arange(100.0), [jnp.int32(x[0])], [3]
    ),
    "rounding to fewer digits": lambda x: jax.lax.reduce_precision(x, 5, 10),
    "float32 among those of float64": lambda x: x.astype(jnp.float32) * 2.0,
    "numbers of complex128": lambda x: jnp.exp(1j * x).real,
    "numbers of uint8": lambda x: x.astype(jnp.uint8) * 1.0,
    "drawing random numbers": lambda x: x * jax.random.normal(jax.random.key(0)),
    "(lu)": lambda x: jnp.linalg.solve(jnp.outer(x, x) + jnp.eye(3), x),
}


@pytest.mark.parametrize("told", REFUSED)
def test_what_scalars_do_not_have_is_refused_by_its_name(told):
    with pytest.raises(NoCounterpartError) as refused:
        graph_of(REFUSED[told], (3,))
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)
