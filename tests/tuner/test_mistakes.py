"""Mistakes in a filter of one's own: each is told in one sentence before anything is compiled."""

import time
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import tuner
from filters import (
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    LinearKalman,
    LinearModel,
    LocalLevel,
    Transition,
)
from filters import Sample as Measurement
from objectives import InnovationLikelihood
from tuner.problem import shape_checks
from tuner.run.own_file import own_file

GOOD = '''
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Channel, Estimate, Param, linearised, predict

PLACE = Channel("m", "place", ("east", "north"))
NARROW = jnp.ones((2, 2), jnp.float32)
KEY = jax.random.key(0)


class Noise(NamedTuple):
    q: Annotated[Array, Param("m^2/s", "density of the walk", 1.0, 1e-3, 1e3)]
    R: Annotated[Array, Param("m^2", "variance of a measurement", 1.0, 1e-3, 1e3)]


class Sample(NamedTuple):
    z: Annotated[Array, Channel("m", "measured place", ("east", "north"))]


class State(NamedTuple):
    x: Array
    P: Array


class Outputs(NamedTuple):
    place: Annotated[Array, PLACE]
    innovation: Annotated[Array, Channel("m", "of the place", ("east", "north"), "detail")]
    variance: Annotated[Array, Channel("m^2", "of these", ("east", "north"), "detail")]


@dataclass(frozen=True)
class Robot:
    """A walk in the plane."""

    dt: float
    params, inputs, outputs = Noise, Sample, Outputs
    states = {"place": PLACE}

    def init(self, params):
        return State(jnp.zeros(2), 10.0 * jnp.eye(2))

    def step(self, params, state, inputs):
        F = jnp.eye(2)
        Q = params.q * self.dt * jnp.eye(2)
        ahead = predict(Estimate(state.x, state.P), F, Q)
        H, R = jnp.eye(2), jnp.stack([params.R, params.R])
        found, taken = linearised(ahead, H, R, inputs.z, ahead.x)
        outputs = Outputs(found.x, taken.innovation, taken.variance)
        return State(found.x, found.P), outputs
'''


def record():
    draw = np.random.default_rng(1)
    z = np.cumsum(draw.standard_normal((40, 2)), axis=0)
    return tuner.Record.of({"z": z}, rate_hz=10.0)


def robot(here, *changes):
    """The class with some text replaced."""
    text = GOOD
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (here / "robot.py").write_text(text)
    return own_file(str(here / "robot.py") + ":Robot").load()


AHEAD = "        ahead = predict("
RETURN = "        return State(found.x, found.P), outputs"
INIT = "        return State(jnp.zeros(2), 10.0 * jnp.eye(2))"
CLASS = "@dataclass(frozen=True)"
LINE = "        F = jnp.eye(2)\n"

MISTAKES = {
    # what it is: (old text, new text, words of the sentence)
    "wrong shape": ("F = jnp.eye(2)", "F = jnp.eye(3)", ("Robot.step (robot.py line", "shape")),
    "np.sin of a traced value": (
        LINE,
        LINE + "        s = np.sin(state.x)\n",
        ("Robot.step (robot.py line 50: s = np.sin(state.x))", "write jnp.sin"),
    ),
    "np.linalg of a traced value": (
        LINE,
        LINE + "        s = np.linalg.norm(state.x)\n",
        ("np.linalg.norm is NumPy's", "write jnp.linalg.norm"),
    ),
    "math.sin of a traced value": (
        LINE,
        LINE + "        import math\n        s = math.sin(state.x[0])\n",
        ("math.sin takes no traced value; write jnp.sin",),
    ),
    "float of a traced value": (
        LINE,
        LINE + "        s = float(state.x[0])\n",
        ("float(...) makes a number of a traced value; leave it out",),
    ),
    "np.float64 of a traced value": (
        LINE,
        LINE + "        s = np.float64(state.x[0])\n",
        ("np.float64(...) makes a number of a traced value; leave it out",),
    ),
    "a Python if on a traced value": (
        LINE,
        LINE + "        if state.x[0] > 1:\n            pass\n",
        ("robot.py line 50: if state.x[0] > 1:", "write jnp.where(condition, a, b)"),
    ),
    "a range of a traced value": (
        LINE,
        LINE + "        for _ in range(state.x[0].astype(int)):\n            pass\n",
        ("no index, size or count of Python",),
    ),
    "a traced mask": (
        LINE,
        LINE + "        s = state.x[state.x > 0]\n",
        ("write jnp.where(mask, a, b)",),
    ),
    "assignment in place": (
        LINE,
        LINE + "        F[0, 1] = self.dt\n",
        ("write x = x.at[i].set(value)",),
    ),
    "assignment to the filter": (
        LINE,
        LINE + "        self.last = state.x\n",
        ("a filter cannot be assigned to", "belongs to the state"),
    ),
    "a value kept in a global": (
        INIT,
        "        global kept\n        kept = params.q * jnp.ones(2)\n" + INIT,
        ("another evaluation", "return it in the state"),
        (LINE, "        F = jnp.eye(2) * kept\n"),
    ),
    "a scalar Q": (
        "params.q * self.dt * jnp.eye(2)",
        "params.q * self.dt",
        ("robot.py line", "covariance of the noise", "(2, 2)", "jnp.eye(2)"),
    ),
    "an integer state": (
        INIT,
        "        return State(jnp.array([0, 0]), 10.0 * jnp.eye(2))",
        ("the state.x is int64 after Robot.init and float64 after Robot.step", "jnp.zeros((2,))"),
    ),
    "a state in single precision": (
        INIT,
        "        return State(jnp.zeros(2, jnp.float32), 10.0 * jnp.eye(2))",
        ("the state.x is float32 after Robot.init and float64 after Robot.step",),
    ),
    "a state of another shape": (
        RETURN,
        "        return State(found.x[:, None], found.P), outputs",
        ("the state.x has shape (2,) after Robot.init and (2, 1) after Robot.step",),
    ),
    "a state of another structure": (
        RETURN,
        "        return (found.x, found.P), outputs",
        ("the state is State(x, P) after Robot.init and a tuple of 2 after Robot.step",),
    ),
    "a list and then a tuple": (
        INIT,
        "        return [jnp.zeros(2), 10.0 * jnp.eye(2)]",
        ("the state is a list of 2 after Robot.init and",),
        ("Estimate(state.x, state.P)", "Estimate(*state)"),
    ),
    "a state that is no tuple": (
        "class State(NamedTuple):",
        "@dataclass(frozen=True)\nclass State:",
        ("Robot.init", "State is neither an Array nor a tuple of them; make it a NamedTuple"),
    ),
    "no outputs returned": (
        RETURN,
        "        return State(found.x, found.P)",
        ("Robot.step returns State(x, P); return the two (state, outputs)",),
    ),
    "a list returned": (
        RETURN,
        "        return [State(found.x, found.P), outputs]",
        ("Robot.step returns a list of 2; return the two (state, outputs) as a tuple",),
    ),
    "nothing returned": (RETURN, "        pass", ("Robot.step returns None",)),
    "outputs without the fields declared": (
        RETURN,
        "        return State(found.x, found.P), (found.x, taken.innovation)",
        ("a tuple of 2 as outputs, which has no place, innovation, variance", "return the Outputs"),
    ),
    "axes that do not match": (
        'PLACE = Channel("m", "place", ("east", "north"))',
        'PLACE = Channel("m", "place", ("east", "north", "up"))',
        ("the output place of Robot declares 3 axes (east, north, up)", "shape (2,)"),
    ),
    "axes in one text": (
        'PLACE = Channel("m", "place", ("east", "north"))',
        'PLACE = Channel("m", "place", "xy")',
        ("the axes of place in Robot are 'xy'; give a tuple",),
    ),
    "an innovation without an axis": (
        "taken.innovation, taken.variance)",
        "taken.innovation, taken.variance.sum())",
        ("variance in shape ()", "both are (m,)"),
        ('"of these", ("east", "north"), "detail"', '"of these", (), "detail"'),
    ),
    "NaN as typical value": (
        '"density of the walk", 1.0,',
        '"density of the walk", float("nan"),',
        ("the facts of q in Robot have the typical value nan; give a finite number",),
    ),
    "a range that falls": (
        '"density of the walk", 1.0, 1e-3, 1e3',
        '"density of the walk", 1.0, 1e3, 1e-3',
        ("the facts of q in Robot have a range from 1000 to 0.001",),
    ),
    "a typical value outside": (
        '"density of the walk", 1.0,',
        '"density of the walk", 0.0,',
        ("the typical value 0.0 outside its range 0.001 to 1000",),
    ),
    "a parameter without facts": (
        'R: Annotated[Array, Param("m^2", "variance of a measurement", 1.0, 1e-3, 1e3)]',
        "R: Array",
        ("Noise.R says nothing about itself; write R: Annotated[Array, Param(...)]",),
    ),
    "a name that no export can hold": (
        "    q: Annotated",
        "    q__walk: Annotated",
        ("named 'q__walk'; give at most 25 letters",),
        ("params.q *", "params.q__walk *"),
    ),
    "no parameters declared": (
        "params, inputs, outputs = Noise, Sample, Outputs",
        "inputs, outputs = Sample, Outputs",
        ("Robot declares no params; give the class an attribute params",),
    ),
    "a mapping of several outputs": (
        "params, inputs, outputs = Noise, Sample, Outputs",
        "params, inputs, outputs = Noise, Sample, {'x': PLACE, 'y': PLACE}",
        ("Robot declares x, y of its outputs by a mapping",),
    ),
    "a field that is not there": (
        "        Q = params.q",
        "        Q = params.Q",
        ("unknown field of Noise 'Q'", "there are: R, q"),
    ),
    "no dt": (
        "    dt: float\n",
        "",
        (
            "Robot.step (robot.py line",
            "Robot has no dt; give the class a field dt",
        ),
    ),
    "dt is no field": (
        "    dt: float\n",
        "    dt = 0.1\n",
        ("Robot.dt is not a field", "write dt: float"),
    ),
    "not frozen": (CLASS, "@dataclass", ("write @dataclass(frozen=True)",)),
    "no dataclass": (
        CLASS + "\n",
        "",
        ("Robot is not a dataclass; write @dataclass(frozen=True)",),
    ),
    "an unhashable field": (
        "    dt: float\n",
        "    dt: float\n    H: tuple = ([1.0, 0.0],)\n",
        ("the field H of Robot is a tuple, which cannot be hashed",),
    ),
    "a field without a default": (
        "    dt: float\n",
        "    dt: float\n    order: int\n",
        ("Robot needs order, a field without a default", "--set order=..."),
    ),
    "step with a wrong signature": (
        "def step(self, params, state, inputs):",
        "def step(self, state, inputs):",
        (
            "Robot.step takes (state, inputs), and the time loop gives it params and state and",
            "write def step(self, params, state, inputs)",
        ),
    ),
    "no step": (
        "def step(self, params",
        "def update(self, params",
        ("Robot has no method step; write def step(self, params, state, inputs)",),
    ),
    "a constant in single precision": (
        LINE,
        LINE + "        s = NARROW @ state.x\n",
        ("Robot.step takes a constant float32[2, 2]", "float64"),
    ),
    "single precision within": (
        LINE,
        LINE + "        s = state.x.astype(jnp.float32)\n",
        ("Robot.step computes in float32", "leave out float32 and astype"),
    ),
    "a random key of the module": (
        LINE,
        LINE + "        s = jax.random.normal(KEY, (2,))\n",
        ("Robot.step draws random numbers", "give them as an input"),
    ),
    "a name that is not there": (
        LINE,
        LINE + "        s = unheard\n",
        ("Robot.step (robot.py line 50: s = unheard)", "'unheard' is not defined"),
    ),
    "annotations that cannot be read": (
        "    z: Annotated[Array,",
        "    z: Annotated['Arrray',",
        ("the annotations of inputs in Robot cannot be read", "'Arrray' is not defined"),
    ),
}


def test_without_a_mistake_it_is_tuned(here):
    found = tuner.fit(robot(here), record(), starts=1, hold_out=False)
    assert found.solution.parameters["R"].unit == "m^2"


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told(here, mistake):
    old, new, words, *more = MISTAKES[mistake]
    cls = robot(here, (old, new), *more)
    begun = time.perf_counter()
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        tuner.fit(cls, record(), starts=1, hold_out=False)
    # Nothing was compiled: a fit takes longer by far. A shared machine may be slow.
    assert time.perf_counter() - begun < 5.0
    told = str(caught.value)
    for word in words:
        assert word in told, told
    assert "\n" not in told
    assert "Tracer<" not in told
    assert "; " in told  # the way out


# The same where a problem is put together by hand.


def linear(**changed):
    F, G, Q = jnp.eye(2), jnp.eye(2), jnp.eye(2)
    parts = {"F": F, "G": G, "Q": Q, "B": None, "H": jnp.ones((1, 2)), "R": jnp.ones(1)}
    parts |= {"P0": jnp.eye(2), "x0": jnp.zeros(2)} | changed
    move = Transition(*(parts.pop(name) for name in "FGQB"))

    def build(v):
        return LinearModel(move, parts["H"], v["R"] * parts["R"], parts["P0"], parts["x0"])

    return build


def nine():
    return Measurement(jnp.zeros((9, 1)))


def posed(build, inputs=None, filter=None, **changed):
    made = {
        "name": "cart",
        "space": tuner.Space.of(R=tuner.Positive(1.0, 1e-3, 1e3)),
        "filter": filter or LinearKalman(),
        "build": build,
        "objective": InnovationLikelihood(),
        "data": tuner.Data(
            Measurement(jnp.zeros((9, 1))) if inputs is None else inputs, np.zeros(9)
        ),
    }
    return tuner.Problem(**{**made, **changed})


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (
            {"Q": jnp.array(1.0)},
            "the Q of cart has shape (), and (2, 2) is needed; write Q * jnp.eye(2)",
        ),
        ({"F": jnp.array(1.0)}, "the F of cart has shape (), and (n, n) is needed"),
        ({"R": jnp.array(1.0)}, "the R of cart has shape (), and (1,) or (1, 1) is needed"),
        ({"H": jnp.ones(2)}, "the H of cart has shape (2,), and (m, 2) is needed"),
        (
            {"G": jnp.ones((3, 1))},
            "the G of cart has shape (3, 1), and (2, p) is needed, for F says that n is 2",
        ),
        ({"P0": jnp.eye(3)}, "the P0 of cart has shape (3, 3), and (2, 2) is needed"),
        ({"x0": jnp.zeros(3)}, "the x0 of cart has shape (3,), and (2,) is needed"),
    ],
)
def test_matrices_that_do_not_fit(changed, words):
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        posed(linear(**changed))
    assert words in str(caught.value)


def test_a_matrix_that_is_no_matrix_of_an_extended_filter():
    def still(p, x, u):
        return x

    filter = ExtendedKalman(still, lambda p, x, u: jnp.eye(2), still)
    samples = ExtendedSample(jnp.zeros((9, 2)))

    def build(v):
        return ExtendedModel(None, v["R"], jnp.zeros(2), jnp.eye(2))

    with pytest.raises(ValueError, match=r"the R of cart has shape \(\), and \(m,\) is needed"):
        posed(build, samples, filter)


def test_samples_that_are_no_samples():
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        posed(linear(), jnp.zeros((9, 1)))
    assert "an Array of shape (1,) has no field" in str(caught.value)
    assert "Data(Sample(...), truth)" in str(caught.value)
    with pytest.raises(ValueError, match="hold a single number, and time is their first axis"):
        posed(linear(), Measurement(jnp.zeros((9, 1)), u=jnp.array(1.0)))


def test_a_build_that_fails():
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        posed(lambda v: v["Q"])
    assert "the parameters of cart (test_mistakes.py line" in str(caught.value)
    assert "there is no parameter 'Q'" in str(caught.value)
    with pytest.raises(ValueError, match="a dict has no field 'x0'; write"):
        posed(lambda v: v)


def mean_square(outputs, truth):
    return ((outputs.x - truth) ** 2).mean()


def test_a_truth_that_does_not_fit():
    two = np.zeros((9, 2))
    assert posed(linear(), objective=mean_square, data=tuner.Data(nine(), two))
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        posed(linear(), objective=mean_square, data=tuner.Data(nine(), np.zeros((9, 3))))
    for word in ("the objective mean_square on LinearKalman", "(9, 3)", "compare the shapes"):
        assert word in str(caught.value)
    build = linear(H=jnp.ones((2, 2)), R=jnp.ones(2))
    data = tuner.Data(Measurement(jnp.zeros((9, 2))), np.zeros((9, 3)))
    with pytest.raises(ValueError, match=r"the objective InnovationLikelihood on LinearKalman"):
        posed(build, data=data)
    with pytest.raises(ValueError, match="returns one Array .* and one number is needed"):
        posed(linear(), objective=lambda outputs, truth: outputs.x, data=tuner.Data(nine(), two))


def test_an_objective_that_is_no_key():
    @dataclass(frozen=True)
    class Weighed:
        weights: list

        def __call__(self, outputs, truth):
            return mean_square(outputs, truth)

    with pytest.raises(ValueError, match="the field weights of Weighed is a list"):
        posed(linear(), objective=Weighed([1.0]), data=tuner.Data(nine(), np.zeros((9, 2))))


def test_a_parameter_that_is_not_in_the_space():
    space = tuner.Space.of(q=tuner.Positive(1.0, 1e-3, 1e3))
    with pytest.raises(ValueError, match=r"^the parameters of cart: LocalLevelNoise needs R \("):
        posed(None, filter=LocalLevel(dt=1.0), space=space)


def test_a_class_in_place_of_a_filter():
    with pytest.raises(ValueError, match="LinearKalman is a class; give a filter of it"):
        posed(linear(), filter=LinearKalman)


def test_every_mistake_comes_from_an_exception(here):
    """What JAX said stays within reach of who wants to know."""
    with pytest.raises(ValueError, match=r"jnp\.sin") as caught:
        tuner.fit(robot(here, (LINE, LINE + "        s = np.sin(state.x)\n")), record(), starts=1)
    assert isinstance(caught.value.__cause__, jax.errors.TracerArrayConversionError)


def test_a_filter_is_tried_once(monkeypatch):
    """However many problems it is in, and whatever the values of its parameters are."""
    build, seen = linear(), []

    @dataclass(frozen=True)
    class Counted:
        inputs, outputs = LinearKalman.inputs, LinearKalman.outputs

        def init(self, params):
            return LinearKalman().init(params)

        def step(self, params, state, inputs):
            seen.append(1)
            return LinearKalman().step(params, state, inputs)

    for init in (1.0, 2.0, 3.0):
        space = tuner.Space.of(R=tuner.Positive(init, 1e-3, 1e3))
        posed(build, filter=Counted(), space=space)
    assert len(seen) == 1
    begun = time.perf_counter()
    for _ in range(20):
        posed(build)
    assert (time.perf_counter() - begun) / 20 < 0.05  # some 2 ms; a shared machine may be slow
    assert shape_checks._tried.cache_info().hits >= 20
