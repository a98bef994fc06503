"""A loop in two phases: while a start is unknown, and from then on."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import LinearKalman, LinearModel, Sample, Transition
from objectives import Data, InnovationLikelihood, score_and_gradient
from tests.tuner.code.compiled import needed
from tuner.code.graph import Graph
from tuner.native.compiled import Native
from tuner.native.loop import Carried, Loop, loop
from tuner.native.phases import phases

N = 60
ALL = (0, 1, 2, 3)


def tracker(z):
    """Two axes with a noise each, of which nothing is known at first."""
    q, r, across, other = jnp.exp(z)
    move = jnp.kron(jnp.eye(2), jnp.array([[1.0, 0.1], [0.0, 1.0]]))
    push = jnp.kron(jnp.eye(2), jnp.array([[0.005], [0.1]]))
    seen = jnp.kron(jnp.eye(2), jnp.array([[1.0, 0.0]]))
    noise = jnp.diag(jnp.stack([q, across]))
    parts = Transition(move, push, noise), seen, jnp.stack([r, other]), jnp.eye(4), jnp.zeros(4)
    return LinearModel(*parts)


def record(missing=(), count=N):
    draw = np.random.default_rng(7)
    z = np.cumsum(draw.normal(size=(count, 2)), 0) + draw.normal(size=(count, 2))
    for rows in missing:
        z[rows] = np.nan
    return Data(Sample(z), np.zeros(count))


def compiled(folder, data=None, diffuse=ALL):
    needed("cc")
    filter = LinearKalman(diffuse=diffuse)
    return Native(filter, InnovationLikelihood(), tracker, 4, data or record(), folder)


@pytest.fixture(scope="module")
def native(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("code"))


@partial(jax.jit, static_argnames="diffuse", compiler_options={"xla_backend_optimization_level": 0})
def by_xla(data, z, diffuse=ALL):
    return score_and_gradient(
        LinearKalman(diffuse=diffuse), InnovationLikelihood(), tracker, z, data
    )


@pytest.mark.parametrize(
    "missing",
    [
        (),
        (slice(0, 1),),
        (slice(0, 9), slice(20, 30)),
        ((slice(0, 40), 1),),
        (slice(0, N),),
    ],
)
def test_a_start_of_which_nothing_is_known(missing, native):
    data = record(missing)
    assert native._loop.first is not None
    assert native._loop.main.operations < 0.3 * native._loop.first.operations
    rows, points = native.rows(data), np.array([[0.3, -0.5, 0.2, 0.1], [0.0, 1.0, -2.0, 0.5]])
    values, gradients = native.values_and_gradients(points, rows, data)
    for k, z in enumerate(points):
        value, gradient = by_xla(data, z)
        one, slopes = native.value_and_gradient(z, rows, data)
        same = [one, values[k], native.value(z, rows, data)]
        assert same == pytest.approx([float(value)] * 3, rel=1e-12, nan_ok=True)
        np.testing.assert_allclose([slopes, gradients[k]], [gradient] * 2, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("count", [1, 3])
def test_a_record_that_ends_before_the_start_is_known(count, native):
    data, z = record(count=count), np.array([0.3, -0.5, 0.2, 0.1])
    value, gradient = by_xla(data, z)
    one, slopes = native.value_and_gradient(z, native.rows(data), data)
    assert one == pytest.approx(float(value), rel=1e-12, nan_ok=True)
    np.testing.assert_allclose(slopes, gradient, rtol=1e-11, atol=1e-12)


def test_of_some_states_something_is_known(tmp_path):
    data, z = record(), np.array([0.3, -0.5, 0.2, 0.1])
    native = compiled(tmp_path / "code", diffuse=(1,))
    assert native._loop.first is not None
    value, gradient = by_xla(data, z, diffuse=(1,))
    one, slopes = native.value_and_gradient(z, native.rows(data), data)
    assert one == pytest.approx(float(value), rel=1e-12)
    np.testing.assert_allclose(slopes, gradient, rtol=1e-11)


def test_other_filters_have_one_phase(tmp_path):
    assert compiled(tmp_path / "code", diffuse=())._loop.first is None


def test_what_the_second_phase_takes_over(native):
    """The second phase begins with numbers of the first that are not zero."""
    whole = loop(native._iteration, [np.ones(len(native._moves), bool)])
    both = phases(whole)
    zero = {whole.carried[k].input for k in both.zero}
    nodes = whole.graph.nodes
    assert all(nodes[k].kind == "real" for k in zero)
    assert not zero & {k for row in whole.total for k in row}
    before = {
        node.value[1]
        for node in both.main.graph.nodes
        if node.op == "input" and node.value[0] == "before"
    }
    assert not before & {*both.zero}


def test_what_is_read_at_the_end_keeps_the_loop_whole():
    graph = Graph()
    x, w, z = (graph.input(key) for key in (("s", 0), ("s", 1), ("u", 0)))
    one, zero = graph.constant(1.0), graph.constant(0.0)
    left = graph.choose(graph.apply("lt", z, graph.constant(9.0)), one, zero)
    after = graph.apply("add", graph.apply("sin", graph.apply("mul", x, w)), z)
    carried = [Carried(x, one, after), Carried(w, one, graph.apply("mul", w, left))]
    assert phases(Loop(graph, carried, [[x]], [], 0)).zero == (1,)
    assert phases(Loop(graph, carried, [[x], [w]], [], 0)).first is None
    still = [carried[0], Carried(w, zero, carried[1].after)]
    assert phases(Loop(graph, still, [[x]], [], 0)).first is None
