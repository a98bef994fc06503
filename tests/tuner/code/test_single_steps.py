"""Single steps of a self-test: whether a wrong constant shows in them."""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

from tests.tuner.code.compiled import compile_in, needed, ran
from tests.tuner.export_cases import tuned
from tuner.code.array_step import Step
from tuner.code.document import files
from tuner.code.form import form
from tuner.code.program import as_graph
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
    (limited, out) = step.results(given)
    assert limited.tolist() == [7.0, 0.0005]
    lanes = step.results(given, step.mutants)
    moved = np.array([np.broadcast_to(lanes[0], (len(step.mutants), 2)) != limited])
    assert moved.any(axis=-1).sum() >= 2
    assert np.broadcast_to(lanes[1], (len(step.mutants), 2)).shape == (len(step.mutants), len(out))
