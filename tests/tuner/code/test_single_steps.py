"""Single steps of a self-test: whether a wrong constant shows in them."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

from benchmarks.effects import effects
from benchmarks.numbers_in_c import Changed, changeable
from tests.tuner.code.compiled import compile_in, needed, ran
from tests.tuner.export_cases import tuned
from tuner.code.array_step import Step
from tuner.code.document import files
from tuner.code.expected import expected
from tuner.code.form import Form, form, ready
from tuner.code.graph import Graph
from tuner.code.mutants import OTHERWISE, Mutant
from tuner.code.program import as_graph
from tuner.code.sensitivity import sensitivities
from tuner.code.trace import traced


class Place(NamedTuple):
    x: Array


@dataclass(frozen=True)
class Bent:
    """What a record near zero does not reach: a limit, a term of a series, and a far branch."""

    def init(self, params):
        return Place(jnp.zeros((), jnp.asarray(params).dtype))

    def step(self, params, state, inputs):
        x = state.x + params * inputs
        series = jnp.where(x * x < 1e-2, 1 - x * x / 6, jnp.sin(x) / x)
        return Place(jnp.minimum(x, 7.0)), jnp.where(x > 5.0, 3.0 * series, series)


class Waiting(NamedTuple):
    mean: Array
    seconds: Array


@dataclass(frozen=True)
class Resting:
    """What is at rest while its measurement stays near its mean: the record never is."""

    def init(self, params):
        zero = jnp.zeros((), jnp.asarray(params).dtype)
        return Waiting(zero, zero)

    def step(self, params, state, inputs):
        mean = state.mean + params * (inputs - state.mean)
        still = (inputs - mean) ** 2 < 0.0121
        seconds = jnp.where(still, state.seconds + 0.25, 0.0)
        rest = seconds > 1.7
        return Waiting(jnp.where(rest, 0.875 * mean, mean), seconds), jnp.where(rest, 3.5, mean)


@dataclass(frozen=True)
class UpsideDown:
    """A decision close to the end of what a cosine may be, and only from a state of zeros."""

    def init(self, params):
        return Place(jnp.zeros(2, jnp.asarray(params).dtype))

    def step(self, params, state, inputs):
        cosine = inputs[1] / jnp.sqrt(inputs @ inputs)
        begun = jnp.where(cosine < -1 + 1e-4, 2.5, cosine)
        x = jnp.where(state.x @ state.x > 0, state.x, params * begun)
        return Place(0.5 * x), x


RECORD = 1e-3 * np.sin(np.arange(80.0))


def numbers_of(precision):
    step = traced(Bent(), 0.5, RECORD[0], precision)
    return Step(as_graph(step))


@pytest.mark.parametrize("precision", ["double", "float"])
def test_limits_and_series_show(precision):
    found = form("bent", Bent(), 0.5, RECORD, precision)
    steps = found.reference.steps
    assert steps.constants == len(numbers_of(precision).mutants)
    # In float the series and the function agree where they meet, to rounding.
    assert steps.constants - steps.detected == (1 if precision == "float" else 0)


@pytest.mark.parametrize("precision", ["double", "float"])
def test_what_only_rest_shows_is_reached(precision):
    record = 5 * (-1.0) ** np.arange(80) + 0.1 * RECORD
    found = ready(Resting(), 0.5, record, precision)
    nodes = found.program.graph.nodes
    hidden = {nodes[nodes[one.node].args[one.at]].value for one in found.reference.steps.undetected}
    assert hidden <= {found.traced.dtype(1.7)}  # seconds close to that have to meet with rest


@pytest.mark.parametrize("precision", ["double", "float"])
def test_a_limit_is_reached_where_it_matters(precision):
    record = np.stack([np.ones(80), 1e3 * RECORD], 1)
    steps = form("down", UpsideDown(), 0.5, record, precision).reference.steps
    assert (steps.constants, steps.undetected) == (steps.detected, [])


def test_a_decision_is_taken_otherwise():
    graph = Graph()
    x, limit = graph.input(("in", "x")), graph.constant(2.0)
    less, most = graph.apply("lt", x, limit), graph.apply("min", x, limit)
    out = graph.choose(less, most, graph.constant(5.0))
    step = Step(SimpleNamespace(graph=graph, state=[], after=[], outputs=[], out=[]))
    step.__dict__["roots"] = [out]
    turned = [Mutant(less, OTHERWISE), Mutant(most, OTHERWISE)]
    (found,) = step.results(step.all_values({x: np.array([1.0, 3.0])}), turned)
    assert found.tolist() == [[1.0, 5.0], [5.0, 3.0]]


def test_where_rounding_may_decide_nothing_is_compared():
    step = numbers_of("float")
    x, u = (next(iter(step.program.known[part][0].flat)) for part in ("state", "in"))
    given = {int(x): np.array([4.9, 5.0 - 2e-6]), int(u): np.array([0.05, 4e-6])}
    assert expected(step, given, np.random.default_rng(0)).steady.tolist() == [True, False]


@pytest.mark.parametrize(("right", "wrong"), [("7.0", "7.007"), ("5.0", "5.005"), ("3.0", "3.003")])
def test_c_with_another_constant_fails(right, wrong, tmp_path):
    needed("gcc")
    found = form("bent", Bent(), 0.5, RECORD)
    text = files(tuned(name="bent"), "bent.h", [found])
    assert text.source.count(right) > 0
    for k in range(text.source.count(right)):
        source = wrong.join(
            [right.join(part) for part in _split(text.source.split(right), k)],
        )
        for end, part in ((".h", text.header), (".c", source), ("_selftest.c", text.selftest)):
            (tmp_path / f"bent{end}").write_text(part)
        compile_in(
            tmp_path, "gcc", "-DSELFTEST_MAIN", "bent.c", "bent_selftest.c", "-o", "a", "-lm"
        )
        assert ran(tmp_path, "./a").stdout != "the filter does what it should\n"


def _split(parts, k):
    return parts[: k + 1], parts[k + 1 :]


def test_a_changed_constant_is_one_lane():
    step = numbers_of("double")
    x, u = (next(iter(step.program.known[part][0].flat)) for part in ("state", "in"))
    given = {int(x): np.array([8.0, 0.0]), int(u): np.array([0.0, 1e-3])}
    values = step.all_values(given)
    (limited, out) = step.results(values)
    assert limited.tolist() == [7.0, 0.0005]
    lanes = step.results(values, step.mutants)
    moved = np.array([np.broadcast_to(lanes[0], (len(step.mutants), 2)) != limited])
    assert moved.any(axis=-1).sum() >= 2
    assert np.broadcast_to(lanes[1], (len(step.mutants), 2)).shape == (len(step.mutants), len(out))


def test_derivatives_tell_how_far_a_change_moves_a_result():
    step = numbers_of("double")
    x, u = (next(iter(step.program.known[part][0].flat)) for part in ("state", "in"))
    given = {int(x): np.array([0.03, 5.7]), int(u): np.array([0.02, 0.1])}
    values = step.all_values(given)
    plain = [np.broadcast_to(row, 2) for row in step.results(values)]
    changed = step.results(values, step.mutants)
    for root, row in enumerate(changed):
        scales = np.full((len(changed), 2), np.inf)
        scales[root] = 1.0
        found = sensitivities(step, values, scales, np.random.default_rng(0))
        moved = np.abs(np.broadcast_to(row, (len(step.mutants), 2)) - plain[root])
        moved[[k for k, one in enumerate(step.mutants) if not found[one].any()]] = 0.0
        at, size = moved > 1e-12, np.array([found[one] for one in step.mutants])
        assert not size[~at].any()
        shares = size[at] / moved[at]  # of the random weight of that result
        assert np.allclose(shares, shares[0], rtol=5e-3)


def test_constants_of_long_steps_are_judged_by_derivatives(monkeypatch):
    for module in ("batches", "detection", "expected", "hidden", "search"):
        monkeypatch.setattr(f"tuner.code.{module}.LONG", 0)
    steps = form("bent", Bent(), 0.5, RECORD).reference.steps
    assert steps.constants - steps.detected <= 1
    assert len(steps.undetected) == steps.constants - steps.detected


@dataclass(frozen=True)
class Guarded:
    """Numbers that no result depends on, and one that is too small to show."""

    def init(self, params):
        return Place(jnp.zeros((), jnp.asarray(params).dtype))

    def step(self, params, state, inputs):
        missing = jnp.isnan(inputs)
        z = jnp.where(missing, 0.0, inputs)
        ratio = jnp.where(missing, 0.625, state.x / jnp.where(missing, 1.5, inputs))
        x = state.x + 1.25
        nothing = (x * x - state.x**2) - (2.5 * state.x + 1.5625)
        after = params * (x + jnp.where(z * z > 1e200, 8.5 * z, 0.0)) + 3e-19 * jnp.sin(z)
        circle = jnp.sin(z) ** 2 + jnp.cos(z) ** 2 - 1.0
        return Place(after), (ratio, 2.25 * nothing, 4.75 * circle)


def test_what_hidden_numbers_do_is_found(tmp_path):
    needed("gcc")
    found = ready(Guarded(), 0.75, 1 + RECORD)
    code, data = found.form("guarded")
    text = files(tuned(name="guarded"), "guarded.h", [Form(code, data)])
    source, lines = changeable(text.source, "double")
    texts = code, text.header, source, tmp_path
    plain, wide = Changed(*texts), Changed(*texts, wide=True)
    of_lines = {}
    step, hidden = Step(found.program), dict(enumerate(lines))
    for one in effects(step, data.steps.around, data.steps.undetected, plain, wide, hidden):
        of_lines.setdefault(one.line, []).append(one.kind)
    for number, kind in {
        "1.5 ": "proven",
        "2.25": "by rounding",
        "4.75": "without effect",
        "3e-19": "below tolerance",
        "8.5": "not reached",
        "0.625": "missed",
    }.items():
        (kinds,) = (kinds for line, kinds in of_lines.items() if number in line)
        assert kind in kinds, (number, of_lines)
