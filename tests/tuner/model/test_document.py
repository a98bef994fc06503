"""What a document is read as, and what comes of it."""

import json
import pickle
import tomllib

import jax.numpy as jnp
import numpy as np
import pytest
import tomli_w

import tuner
from filters import channel_facts, measured_entries, parameter_facts, run
from objectives import ChannelRmse, Data
from tests.tuner.model.documents import COMPASS, GPS, ROBOT, SHORT, VERTICAL, WHEELS, made
from tuner import Problem, Space
from tuner.model import model_filter, read_model, template
from tuner.model.template import KINDS
from tuner.run.variance_scaling import nees_of


@pytest.fixture
def read(tmp_path):
    def of(text, name="mine"):
        path = tmp_path / f"{name}.toml"
        path.write_text(text)
        return read_model(path)

    return of


@pytest.mark.parametrize("kind", KINDS)
def test_templates_are_models_that_survive_being_kept(kind, read):
    """As JSON and as TOML, which writes tables after numbers."""
    document = read(template(kind))
    cls = model_filter(document)
    assert cls.__name__ == "Mine"
    kept = json.loads(json.dumps(document, allow_nan=False))
    assert model_filter(kept) is cls
    assert model_filter(tomllib.loads(tomli_w.dumps(document))) is cls
    assert type(pickle.loads(pickle.dumps(cls(0.1)))) is cls


def test_a_file_gives_its_name_where_a_document_has_none(read):
    assert read(SHORT, "water-level")["name"] == "water-level"
    assert model_filter(read(SHORT, "water-level")).__name__ == "WaterLevel"
    assert model_filter(read(f'name = "tank"\n{SHORT}')).__name__ == "Tank"
    assert "name" not in read(SHORT, "2 tanks")


def test_facts_are_those_of_the_document():
    robot = made(ROBOT)
    fact = parameter_facts(robot)["q_turn"]
    assert (fact.unit, fact.low, fact.high) == ("rad^2/s", 1e-8, 10)
    assert channel_facts(robot, "inputs")["gps"].axes == ("x", "y")
    assert channel_facts(robot, "outputs")["heading"].kind == "angle"
    assert channel_facts(robot, "outputs")["innovation"].unit == "m"


def test_numbers_of_parameters_become_si():
    text = SHORT.replace("q = {}", 'q = { start = 180, unit = "deg/s" }')
    fact = parameter_facts(made(text))["q"]
    assert fact.unit == "rad/s"
    assert fact.typical == pytest.approx(3.141592653589793, rel=1e-15)
    assert fact.low < fact.typical < fact.high


def test_a_fixed_parameter_is_not_searched():
    text = SHORT.replace("R = {}\n", "R = { fixed = 2.0 }\n", 1)
    assert parameter_facts(made(text))["R"].low is None


def test_which_filter_it_is_follows_from_the_equations():
    assert made(VERTICAL).model.method == "kalman"  # linear, though written as expressions
    assert made(ROBOT).model.method == "extended"
    assert made(f'method = "unscented"\n{ROBOT}').model.method == "unscented"


def test_a_linear_model_has_what_the_rank_test_needs():
    track = made(GPS)
    form = track(2.0).linear(track.params(q=jnp.array(3.0), s=jnp.array(0.5)))
    assert form.transition.F[0].tolist() == [1.0, 2.0, 0.0, 0.0]
    assert form.R.tolist() == [0.25, 0.25]  # factors on the squares of what the channel tells
    inputs = track.inputs(accuracy=jnp.array([2.0, 0.0]), gps=jnp.ones((2, 2)))
    measured = track(2.0).measured(inputs)
    assert measured.sigma.tolist() == [[2.0, 2.0], [0.0, 0.0]]
    assert not hasattr(made(ROBOT), "linear")


def test_the_nees_of_one_state_is_told():
    """Of an angle within half a turn."""
    compass, rng = made(COMPASS), np.random.default_rng(3)
    rate = 0.3 + np.cumsum(0.1 * rng.normal(size=200))
    true = 0.5 * np.cumsum(rate)
    z = true + 0.1 * rng.normal(size=200)
    values = {"q": 0.02, "R": 0.01}
    found = []
    for truth in (true, (true + np.pi) % (2 * np.pi) - np.pi):
        data = Data(compass.inputs(jnp.asarray(z)), truth)
        objective = ChannelRmse.of(compass, "heading")
        problem = Problem("c", Space.of_filter(compass), compass(0.5), None, objective, data)
        found.append(nees_of(problem, values))
    params = compass.params(*map(jnp.array, values.values()))
    out = run(compass(0.5), params, compass.inputs(jnp.asarray(z)))[1]
    expected = np.mean((np.asarray(out.heading) - true) ** 2 / np.asarray(out.P)[:, 0, 0])
    assert found == pytest.approx([expected, expected], rel=1e-12)


def test_a_gate_takes_a_group_as_missing():
    """With the accuracy that belongs to it, by which its parts go together; no known input."""
    wheels, rng = made(WHEELS), np.random.default_rng(4)
    given = *rng.uniform(1, 2, (3, 9)), np.zeros((9, 2)), np.zeros(9)
    inputs = wheels.inputs(*map(jnp.asarray, given))
    params = wheels.params(*map(jnp.array, (0.1, 0.1, 1.0)))
    parts = measured_entries(wheels(0.1), params, inputs)
    # Leaves 0 to 4 are speed, turn, accuracy, gps and compass.
    assert parts == (((2, 0), (3, 0)), ((2, 0), (3, 1)), ((4, 0),))


def test_a_fit_is_that_of_the_catalogue(read):
    rng = np.random.default_rng(5)
    z = np.cumsum(rng.normal(size=300)) + 2 * rng.normal(size=300)
    record = tuner.Record.of({"z": z}, rate_hz=10.0, units={"z": "Pa"}, truth={})
    ours = tuner.fit(read(template("level")), record, starts=1, hold_out=False)
    theirs = tuner.fit("local-level", record, starts=1, hold_out=False)
    for name in ("q", "R"):
        one, other = (fit.solution.parameters[name] for fit in (ours, theirs))
        assert one.value == pytest.approx(other.value, rel=1e-6)
        assert one.unit == other.unit
    assert ours.solution.derived["Q"] == pytest.approx(theirs.solution.derived["Q"], rel=1e-6)
    assert ours.solution.derived["K"] == pytest.approx(theirs.solution.derived["K"], rel=1e-6)
