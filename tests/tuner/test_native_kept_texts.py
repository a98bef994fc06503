"""C that was written once is called again without tracing anything, and gives the same numbers."""

import jax
import numpy as np
import pytest

from filters import ConstantVelocity, LocalLevel
from objectives import Data, InnovationLikelihood
from tests.tuner.code.compiled import needed
from tests.tuner.helpers import OwnLevel
from tests.tuner.model.documents import SHORT, made
from tuner import Problem, Space
from tuner.code.refused import NoCounterpartError
from tuner.native import compiled, route, wanted
from tuner.native.kept_texts import KeptTexts
from tuner.native.loop_score import Judge
from tuner.problem import surface
from tuner.problem.surface import values

STEPS = np.cumsum(np.random.default_rng(3).normal(size=(400, 2)), axis=0)


@pytest.fixture
def forced(stored, monkeypatch):
    needed("cc")
    monkeypatch.setenv("TUNER_NATIVE", "on")
    new_process()
    yield
    new_process()


def new_process():
    for known in (wanted.forwards, wanted._back, wanted.operations):
        known.cache_clear()


@pytest.fixture
def not_traced(monkeypatch):
    """From when it is called, tracing a loop fails."""

    def refused(*_):
        raise AssertionError("traced anew")

    def begun():
        for name in ("runner_of", "iteration", "loop"):
            monkeypatch.setattr(compiled, name, refused)
        monkeypatch.setattr("tuner.native.row_function._source", refused)
        monkeypatch.setattr(wanted, "_counted", refused)
        monkeypatch.setattr("tuner.native.backwards.shortest", refused)
        monkeypatch.setattr("tuner.native.backwards.runner_of", refused)

    return begun


def posed(filter=None):
    filter = filter or LocalLevel(dt=0.1)
    cls = type(filter)
    channels = len(cls.inputs._fields)
    data = Data(cls.inputs(*STEPS.T[:channels]), np.zeros((len(STEPS), 1)))
    space = Space.of_filter(cls)
    return Problem("kept", space, filter, None, InnovationLikelihood(), data)


def both(problem):
    """Value and gradient, value, and those of several points, where the search begins."""
    z = problem.space.start() + 0.1
    value, gradient = problem.value_and_gradient(z)
    assert problem.gradient_by.startswith("C, compiled by")
    many = problem.route.values_and_gradients(np.stack([z, z + 0.2]))
    return np.array([value, *gradient, problem.value(z), *many[0], *many[1].ravel()])


FILTERS = {
    "local level": lambda: LocalLevel(dt=0.1),
    "of a model": lambda: made(SHORT)(dt=0.1),
    "constant velocity": lambda: ConstantVelocity(dt=0.1, axes="xy"),
}


@pytest.mark.usefixtures("forced")
@pytest.mark.parametrize("name", FILTERS)
def test_another_process_traces_nothing(name, not_traced):
    first = both(posed(FILTERS[name]()))
    new_process()
    not_traced()
    assert both(posed(FILTERS[name]())).tolist() == first.tolist()


@pytest.mark.usefixtures("forced")
def test_a_pass_back_is_not_traced_again_either(not_traced, monkeypatch):
    monkeypatch.setattr(wanted, "_FEW", 0)
    monkeypatch.setattr(wanted, "_back_is_less", lambda *_: True)
    first = posed()
    z = first.space.start() + 0.1
    value, gradient = first.value_and_gradient(z)
    assert first.route.goes_back
    right = first.by_xla(z)
    assert value == pytest.approx(right[0], rel=1e-12)
    np.testing.assert_allclose(gradient, right[1], rtol=1e-10, atol=1e-11)
    alone = first.value(z)
    new_process()
    not_traced()
    again = posed()
    same = again.value_and_gradient(z)
    assert again.route.goes_back
    assert (same[0], same[1].tolist(), again.value(z)) == (value, gradient.tolist(), alone)


@pytest.mark.usefixtures("forced")
def test_a_longer_record_takes_the_same_c(not_traced):
    both(posed())
    new_process()
    not_traced()
    longer = posed()
    data = jax.tree.map(lambda leaf: np.concatenate([leaf, leaf]), longer.data)
    longer = Problem("longer", longer.space, longer.filter, None, longer.objective, data)
    z = longer.space.start()
    value, gradient = longer.value_and_gradient(z)
    right = longer.by_xla(z)
    assert value == pytest.approx(right[0], rel=1e-12)
    np.testing.assert_allclose(gradient, right[1], rtol=1e-10, atol=1e-11)


@pytest.mark.usefixtures("forced")
def test_c_that_differs_from_xla_is_not_used_though_it_is_kept(monkeypatch):
    both(posed())
    new_process()
    weights = Judge.weights
    monkeypatch.setattr(Judge, "weights", lambda *given: weights(*given)._replace(value=1.0))
    wrong = posed()
    z = wrong.space.start()
    value, gradient = wrong.value_and_gradient(z)
    assert wrong.gradient_by.startswith("XLA")
    assert "differs" in wrong.gradient_by
    assert (value, gradient.tolist()) == (wrong.by_xla(z)[0], wrong.by_xla(z)[1].tolist())


@pytest.mark.usefixtures("forced")
def test_a_filter_of_the_user_s_own_is_traced_in_every_run(monkeypatch):
    first = both(posed(OwnLevel(dt=0.1)))
    new_process()
    traced, runner_of = [], compiled.runner_of
    monkeypatch.setattr(compiled, "runner_of", lambda *a: traced.append(a) or runner_of(*a))
    assert both(posed(OwnLevel(dt=0.1))).tolist() == first.tolist()
    assert traced


@pytest.mark.usefixtures("stored")
def test_a_refusal_is_kept_with_its_words():
    asked = []

    def refused():
        asked.append("asked")
        raise NoCounterpartError("sorting (sort) has no counterpart among scalars")

    texts = KeptTexts((LocalLevel(dt=0.2),))
    for _ in range(2):
        with pytest.raises(NoCounterpartError, match=r"sorting \(sort\) has no counterpart"):
            texts.of("loop", refused)
    assert len(asked) == 1


@pytest.mark.usefixtures("forced")
def test_c_pays_sooner_where_it_is_kept(monkeypatch):
    monkeypatch.setenv("TUNER_NATIVE", "auto")
    monkeypatch.setattr(route, "KEPT_PAYS", -np.inf)
    assert both(posed()).size
    foreign = posed(OwnLevel(dt=0.1))
    foreign.value_and_gradient(foreign.space.start())
    assert foreign.gradient_by.endswith("the record is too short for compiling C to pay")
    monkeypatch.delenv("TUNER_PROGRAMS")
    here = posed()
    here.value_and_gradient(here.space.start())
    assert here.gradient_by.endswith("the record is too short for compiling C to pay")


@pytest.mark.usefixtures("forced")
def test_values_of_many_points_go_by_the_same_c(monkeypatch):
    problem = posed()
    Z = problem.space.starts(9, seed=0)
    right = [problem.value_by_xla(z) for z in Z]

    def refused(*_):
        raise AssertionError("by XLA")

    monkeypatch.setattr(surface, "_values", refused)
    np.testing.assert_allclose(values(problem, Z), right, rtol=1e-11)
    monkeypatch.undo()
    np.testing.assert_allclose(values(problem, Z), right, rtol=1e-11)
