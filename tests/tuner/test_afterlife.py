"""What a problem says of its solutions: parameters, outputs, quantities, single precision."""

from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

import tuner.problem.problem
from filters import Channel, GyroscopeFilter, Param, run
from objectives import Data
from tests.tuner.helpers import Solved, problem, toy_plan, trench
from tuner.certificate.solution import TunedParameter
from tuner.data.source import Source
from tuner.problem.exported import Exported, Trial, exported_of
from tuner.problem.parameters import Fixed, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers import Known, NelderMead

CALLS = []


class Gain(NamedTuple):
    alpha: Annotated[Array, Param("1", "share of the new sample", 0.5, 1e-3, 10.0)]
    start: Annotated[Array, Param("m", "where it begins", 1.5)]


class Levels(NamedTuple):
    level: Annotated[Array, Channel("m", "smoothed", ("x", "y"))]
    innovation: Annotated[Array, Channel("m", "what was new", ("x", "y"), kind="detail")]


INPUTS = {"z": Channel("m", "measured", ("x", "y"))}
STATES = {"level": Channel("m", "smoothed", ("x", "y")), "age": Channel("s", "age")}
DERIVED = {
    "tau": Param("s", "time constant", 1.0),
    "Alpha": Param("1", "named like another but for capitals", 0.5),
    "alpha": Param("1", "named like another", 0.5),
    "never": Param("s", "infinite here", 1.0),
}


@dataclass(frozen=True)
class Smoother:
    """Two numbers, smoothed; it notes whenever its step is traced or called."""

    dt: float
    params, outputs = Gain, Levels
    inputs, states, derived = INPUTS, STATES, DERIVED

    def init(self, params):
        return jnp.broadcast_to(params.start, (2,))

    def step(self, params, state, inputs):
        CALLS.append(inputs)
        innovation = inputs - state
        state = state + params.alpha * innovation
        return state, Levels(state, innovation)

    def derive(self, params):
        numbers = {"tau": self.dt / params.alpha, "Alpha": -params.alpha, "alpha": -params.alpha}
        return numbers | {"never": jnp.array(jnp.inf)}


def squares(outputs, truth):
    return jnp.sum((outputs.level - truth) ** 2)


Z = np.random.default_rng(3).standard_normal((40, 2))


def smoothing(**changed):
    fields = {
        "name": "smooth",
        "space": Space.of_filter(Smoother),
        "filter": Smoother(0.1),
        "build": None,
        "objective": squares,
        "data": Data(Z, 0.5 * Z),
    }
    return Problem(**fields | changed)


def at(posed, **values):
    """The solution at given parameters."""
    return Known("given", lambda _: values, "as given")(posed)


def smoothed(alpha, start):
    """The same in a plain loop."""
    state, levels = np.full(2, start), []
    for sample in Z:
        state = state + alpha * (sample - state)
        levels.append(state)
    return np.array(levels)


# Parameters and outputs.


def test_a_filter_that_declares_its_parameters_needs_no_build():
    posed = smoothing()
    params = posed.params(at(posed, alpha=0.25))
    assert isinstance(params, Gain)
    assert params.alpha == pytest.approx(0.25, rel=1e-15)
    assert params.start == 1.5
    expected = ((smoothed(0.25, 1.5) - 0.5 * Z) ** 2).sum()
    assert at(posed, alpha=0.25).value == pytest.approx(expected, rel=1e-12)


def test_a_build_of_ones_own():
    posed = smoothing(
        space=Space.of(half=Positive(0.2, 0.01, 1.0)),
        build=lambda values: Gain(2 * values["half"], jnp.array(0.0)),
    )
    assert posed.params(at(posed)).alpha == pytest.approx(0.4, rel=1e-15)


def test_outputs_are_those_of_a_plain_loop():
    posed = smoothing()
    outputs = posed.outputs(at(posed, alpha=0.25))
    np.testing.assert_allclose(outputs.level, smoothed(0.25, 1.5), rtol=1e-12)
    assert outputs.level.dtype == jnp.float64


def test_outputs_are_run_once_a_solution(monkeypatch):
    ran = []

    def counting(*given):
        ran.append(given)
        return run(*given)[1]

    monkeypatch.setattr(tuner.problem.problem, "run_filter", counting)
    posed = smoothing()
    quick, slow = at(posed, alpha=0.25), at(posed, alpha=0.75)
    first = posed.outputs(quick)
    assert posed.outputs(quick) is first
    assert len(ran) == 1
    assert posed.outputs(slow) is not first
    assert len(ran) == 2
    # By the parameters, not by where a search found them.
    edited = replace(quick, parameters=slow.parameters)
    assert posed.outputs(edited) is posed.outputs(slow)
    # A problem of other data remembers nothing of this one.
    other = replace(posed, data=Data(2 * Z, Z))
    assert not np.array_equal(other.outputs(quick).level, first.level)
    assert len(ran) == 3


def test_problems_share_one_compilation_of_their_outputs():
    posed = smoothing()
    posed.outputs(at(posed, alpha=0.3))
    before = len(CALLS)
    again = smoothing(name="again", data=Data(3 * Z, Z))
    again.outputs(at(posed, alpha=0.4))
    assert len(CALLS) == before  # its step is not even traced again


def test_a_design_has_no_outputs():
    design = Problem(
        "design", Space.of(a=Positive(1.0, 0.1, 10.0)), None, dict, lambda v, _: v["a"] ** 2
    )
    solution = at(design)
    with pytest.raises(ValueError, match=r"^design runs no filter, so it has no outputs$"):
        design.outputs(solution)
    assert design.single_precision(solution) == ()
    assert design.what_is_exported().filter == "Design"
    (told,) = design.quantities(solution)
    assert (told.name, float(told.value)) == ("a", 1.0)


# Quantities.


def table(quantities):
    return {q.name: (float(q.value), q.unit, q.meaning) for q in quantities}


def test_quantities_of_a_filter_that_declares_them():
    posed = smoothing()
    solution = at(posed, alpha=0.25)
    alpha = float(solution.parameters["alpha"].value)
    assert table(posed.quantities(solution)) == {
        "alpha": (alpha, "1", "share of the new sample"),
        "start": (1.5, "m", "where it begins"),
        "tau": (0.1 / alpha, "s", "time constant"),
        # Beside alpha it would be the same name in C; what is infinite is left out.
        "Alpha_derived": (-alpha, "1", "named like another but for capitals"),
    }


def test_the_filters_own_parameters_stand_beside_those_of_another_space():
    posed = smoothing(
        space=Space.of(
            tau=Positive(0.4, 0.1, 10.0, unit="ms", meaning="said by the space"),
            twice=Fixed(2.0, meaning="not the filter's"),
        ),
        build=lambda values: Gain(0.1 / values["tau"], jnp.array(0.0)),
    )
    told = table(posed.quantities(at(posed)))
    assert list(told) == ["tau", "twice", "alpha", "start", "Alpha_derived"]
    # The space's word counts where both have one of the name.
    assert told["tau"] == (pytest.approx(0.4, rel=1e-15), "ms", "said by the space")
    assert told["twice"] == (2.0, "", "not the filter's")
    assert told["alpha"] == (pytest.approx(0.25, rel=1e-15), "1", "share of the new sample")


def test_a_filter_that_declares_nothing_exports_its_space():
    told = toy_plan_problem().quantities(at(toy_plan_problem(), a=2.0, b=3.0))
    found = table(told)
    assert list(found) == ["a", "b", "gain"]
    assert found["a"] == (pytest.approx(2.0, rel=1e-15), "m", "the first")
    assert found["b"][1:] == ("", "")


def toy_plan_problem():
    from tests.tuner.helpers import ToySettings

    def none(name, **options):
        return Solved(name, None)

    return toy_plan(ToySettings(), (), 0, "", solver=none).tasks[0].problem


def test_what_a_filter_says_of_itself():
    told = exported_of(Smoother(0.1))
    assert (told.filter, told.dt) == ("Smoother", 0.1)
    assert told.states == ("level_x", "level_y", "age")
    plain = exported_of(GyroscopeFilter(0.01))
    assert (plain.filter, plain.states, plain.dt) == ("GyroscopeFilter", ("omega", "epsilon"), 0.01)
    assert smoothing().what_is_exported().states == told.states
    own = Exported("Mine")
    assert smoothing(exported=own).what_is_exported() is own
    assert own.derived(None) == ()


def test_what_runs_in_a_designs_place_is_what_is_tried():
    samples = np.linspace(0.0, 1.0, 20)[:, None] * np.ones(2)

    def runs(params):
        return {"every step": Trial(Smoother(0.1), Gain(params["gain"], jnp.array(0.0)), samples)}

    design = Problem(
        name="design",
        space=Space.of(gain=Positive(0.25, 0.1, 1.0)),
        filter=None,
        build=dict,
        objective=lambda params, _: params["gain"] ** 2,
        exported=Exported("Smoother", runs=runs),
    )
    (check,) = design.single_precision(at(design))
    assert (check.form, check.output) == ("every step", "level")
    assert 0 < check.share < 1e-6  # a gain below 1 averages the rounding, 6e-8, of each step


# Single precision.


def test_single_precision_of_a_problem():
    posed = smoothing()
    (check,) = posed.single_precision(at(posed, alpha=0.25))
    assert (check.form, check.output, check.warning) == ("full", "level", "")
    assert 0 < check.share < 1e-6


@dataclass(frozen=True)
class Settling(Smoother):
    """It has a steady form: another filter, with parameters of its own."""

    def steady(self, params):
        return Smoother(self.dt), Gain(params.alpha, jnp.array(0.0))


def test_the_steady_form_is_checked_as_well():
    posed = smoothing(filter=Settling(0.1), space=Space.of_filter(Settling))
    full, steady = posed.single_precision(at(posed, alpha=0.25))
    assert (full.form, steady.form) == ("full", "steady")
    assert full.rms != steady.rms


@dataclass(frozen=True)
class Stubborn:
    """Falls back to double precision."""

    dt: float = 0.1
    params: Any = None

    def init(self, params):
        return jnp.zeros(())

    def step(self, params, state, inputs):
        return state, jnp.sum(inputs).astype(jnp.float64)


def test_a_filter_that_falls_back_is_an_error():
    posed = Problem(
        "stubborn",
        Space.of(a=Positive(1.0, 0.1, 10.0)),
        Stubborn(),
        dict,
        lambda outputs, _: 1.0 + outputs[-1] ** 2,
        Data(Z, Z),
    )
    with pytest.raises(TypeError, match="is float64 for float32 inputs$"):
        posed.single_precision(at(posed))


# Where the data come from.


def test_a_problem_knows_its_source():
    source = Source.simulated("noise", [Z], 10.0)
    assert smoothing(source=source).source is source
    assert smoothing().source is None
    assert problem(trench).source is None


def test_edited_parameters_are_the_ones_that_count():
    posed = smoothing()
    found = NelderMead(seed=0, starts=1)(posed)
    edited = replace(found, parameters={**found.parameters, "alpha": tuned(0.125)})
    assert posed.params(edited).alpha == 0.125
    assert table(posed.quantities(edited))["tau"][0] == 0.8


def tuned(value):
    return TunedParameter(np.array(value), "1", None)
