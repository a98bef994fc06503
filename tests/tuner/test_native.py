"""Gradients by C that is compiled for a problem, against XLA's."""

import os
import stat
from dataclasses import dataclass, replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import LinearKalman, LinearModel, Sample, Transition
from objectives import Data, InnovationLikelihood, score_and_gradient
from tests.filters.battery import CASES
from tests.tuner.code.compiled import needed
from tuner import Gradient, Positive, Problem, Space, compiler, values_and_gradients
from tuner.cached import own
from tuner.code.graph import TooLargeError
from tuner.code.refused import NoCounterpartError
from tuner.compiler import NoCodeError, library
from tuner.native import route
from tuner.native.compiled import Native

quickly = partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0})
N = 300


@dataclass(frozen=True)
class Weighed:
    """A weighted sum of all that a filter outputs."""

    def init(self):
        return jnp.zeros(())

    def update(self, total, output, truth):
        for k, leaf in enumerate(jax.tree.leaves(output)):
            weight = (1 + 0.1 * k) * truth
            total = total + weight * jnp.where(jnp.isnan(leaf), 0.0, leaf).sum()
        return total, None

    def value(self, total, kept):
        return total


def at_end(outputs, _):
    """An objective that looks at some of the outputs, after the loop."""
    return (outputs.x[-1] ** 2).sum() + jnp.abs(outputs.innovation).max()


def ballistic(values):
    """A place on two axes, measured on both."""
    move = jnp.kron(jnp.eye(2), jnp.array([[1.0, 0.1], [0.0, 1.0]]))
    push = jnp.kron(jnp.eye(2), jnp.array([[0.005], [0.1]]))
    noise = jnp.diag(jnp.stack([values["q"], values["q_across"]]))
    seen = jnp.kron(jnp.eye(2), jnp.array([[1.0, 0.0]]))
    return LinearModel(
        Transition(move, push, noise), seen, jnp.full(2, values["r"]), jnp.eye(4), jnp.zeros(4)
    )


def measured():
    draw = np.random.default_rng(7)
    z = np.cumsum(draw.normal(size=(N, 2)), 0) + draw.normal(size=(N, 2))
    z[draw.random((N, 2)) < 0.1] = np.nan
    return z


def posed(objective=None, **changes):
    names = ("q", "q_across", "r")
    return Problem(
        **{
            "name": "ballistic",
            "space": Space.of(**{name: Positive(1.0, 1e-3, 1e3) for name in names}),
            "filter": LinearKalman(),
            "build": ballistic,
            "objective": objective or InnovationLikelihood(),
            "data": Data(Sample(measured()), np.zeros(N)),
        }
        | changes
    )


@pytest.fixture
def forced(monkeypatch):
    needed("cc")
    monkeypatch.setenv("TUNER_NATIVE", "on")


# The same numbers.

BATTERY = (
    "linear, full R, varying dt",
    "extended, two rates",
    "Mahony, field",
    "a gate",
    "several records",
)


@pytest.mark.parametrize("name", BATTERY)
def test_gradients_of_the_battery(name, tmp_path):
    needed("cc")
    case = next(case for case in CASES if case.name == name)
    z, truth = np.asarray(case.point, float), 1.0 + np.arange(len(case.measured))
    case.build(case.point)
    data = jax.tree.map(np.asarray, Data(case.inputs(case.measured), truth))
    native = Native(case.filter, Weighed(), case.build, len(z), data, tmp_path / "code")
    rows = native.rows(data)
    right = quickly(partial(score_and_gradient, case.filter, Weighed(), case.build))
    points = np.stack([z, z + 0.01])
    values, gradients = native.values_and_gradients(points, rows, data)
    for k, point in enumerate(points):
        value, gradient = right(jnp.asarray(point), data)
        one, slopes = native.value_and_gradient(point, rows, data)
        large = 1e-11 * np.abs(gradient).max()
        same = [one, values[k], native.value(point, rows, data)]
        assert same == pytest.approx([float(value)] * 3, rel=1e-12)
        np.testing.assert_allclose([slopes, gradients[k]], [gradient] * 2, rtol=1e-11, atol=large)


@pytest.mark.parametrize("objective", [InnovationLikelihood(), at_end])
def test_a_problem_goes_by_c_and_says_so(objective, forced):
    problem = posed(objective)
    for z in (np.zeros(3), np.array([0.3, -1.0, 0.5])):
        value, gradient = problem.value_and_gradient(z)
        right = problem.by_xla(z)
        assert value == pytest.approx(right[0], rel=1e-12)
        np.testing.assert_allclose(gradient, right[1], rtol=1e-11, atol=1e-11)
        assert problem.value(z) == pytest.approx(right[0], rel=1e-12)
    assert problem.route.choice.startswith("C, compiled by ")
    assert problem.route.values_by.startswith("values by C, compiled by ")


def test_many_points_side_by_side(forced, monkeypatch):
    problem, Z = posed(), np.random.default_rng(0).normal(size=(11, 3))
    values, gradients = values_and_gradients(problem, Z)
    monkeypatch.setenv("TUNER_NATIVE", "off")
    right = values_and_gradients(posed(), Z)
    np.testing.assert_allclose(values, right[0], rtol=1e-12)
    np.testing.assert_allclose(gradients, right[1], rtol=1e-11, atol=1e-11)


def posed_with(count):
    """The same with so many parameters."""
    names = [f"r{k}" for k in range(count)]
    build = lambda v: ballistic({"q": v["r0"], "q_across": 1.0, "r": sum(v[n] for n in names)})  # noqa: E731
    return posed(build=build, space=Space.of(**{n: Positive(1.0, 1e-3, 1e3) for n in names}))


def test_more_coordinates_than_lanes(forced):
    problem = posed_with(11)
    z = np.linspace(-1, 1, 11)
    right = problem.by_xla(z)[1]
    np.testing.assert_allclose(problem.value_and_gradient(z)[1], right, rtol=1e-11)
    assert problem.route.choice.startswith("C")


def test_a_search_ends_at_the_same_point(forced, monkeypatch):
    by_c = Gradient("l-bfgs-b", seed=0, starts=1)(posed())
    monkeypatch.setenv("TUNER_NATIVE", "off")
    by_xla = Gradient("l-bfgs-b", seed=0, starts=1)(posed())
    np.testing.assert_allclose(by_c.z, by_xla.z, rtol=1e-6)
    assert by_c.gradient_by.startswith("C, compiled by")
    assert by_xla.gradient_by == "XLA, forwards: TUNER_NATIVE is off"


def test_what_is_not_a_number_is_none(forced):
    problem = posed()
    assert problem.value(np.full(3, np.nan)) == np.inf
    assert problem.value_and_gradient(np.full(3, np.nan))[0] == np.inf
    assert problem.route.choice == problem.route.values_by == ""
    assert np.isfinite(problem.value(np.zeros(3)))
    assert problem.route.values_by


@dataclass(frozen=True)
class Chaotic:
    """A number that the last digits of all estimates decide."""

    def init(self):
        return jnp.zeros(())

    def update(self, total, output, truth):
        return total + jnp.log1p(output.x**2).sum(), None

    def value(self, total, kept):
        return jnp.sin(2.0**50 * total)


def test_a_point_where_rounding_decides_judges_nothing(forced, monkeypatch):
    monkeypatch.setattr(route, "AGREED", -1.0)
    problem, z = replace(posed(), objective=Chaotic()), np.array([0.3, -0.2, 0.1])
    problem.value_and_gradient(z)
    problem.value(z)
    assert problem.route.choice == problem.route.values_by == ""


# Which way.


def refused(problem):
    """Why it goes by XLA."""
    value, gradient = problem.value_and_gradient(np.zeros(problem.space.size))
    right = problem.by_xla(np.zeros(problem.space.size))
    assert value == right[0]
    assert gradient.tolist() == right[1].tolist()
    return problem.route.choice


def test_a_short_record_goes_by_xla(monkeypatch):
    monkeypatch.setenv("TUNER_NATIVE", "auto")
    assert refused(posed()) == "XLA: the record is too short for compiling C to pay"


def test_a_long_record_goes_by_c(monkeypatch):
    needed("cc")
    monkeypatch.delenv("TUNER_NATIVE")
    monkeypatch.setattr(route, "PAYS", 8e6)
    z = np.tile(measured(), (40, 1))
    long = posed(data=Data(Sample(z), np.zeros(len(z))))
    long.value_and_gradient(np.zeros(3))
    assert long.route.choice.startswith("C, compiled by ")


def test_a_shorter_way_back_is_xla_s(monkeypatch):
    needed("cc")
    monkeypatch.setenv("TUNER_NATIVE", "auto")
    monkeypatch.setattr(route, "PAYS", -np.inf)
    monkeypatch.setattr(route, "operations", lambda *_: 10)
    problem = posed()
    exact = problem.by_xla, problem.value_by_xla
    price = route.PRICES["backwards"], 0.0
    back = route.Route(problem.static, problem.data, 3, *exact, lambda: price)
    assert back.value_and_gradient(np.zeros(3)) is None
    assert back.choice == "XLA: its way back through the loop is shorter than C's"


def with_constant_gains(monkeypatch, *, settle=True):
    needed("cc")
    monkeypatch.setenv("TUNER_NATIVE", "auto")
    monkeypatch.setattr(route, "PAYS", -np.inf)
    problem = posed()
    exact = problem.by_xla, problem.value_by_xla
    given = problem.static, problem.data, 3, *exact, lambda: (3, 0.9)
    return route.Route(*given, settle=settle)


def test_constant_gains_are_c_s(monkeypatch):
    monkeypatch.setattr(route, "LEAST", 0.0)
    long = with_constant_gains(monkeypatch)
    assert long.value_and_gradient(np.zeros(3)) is not None
    assert long.choice.startswith("C, compiled by ")
    assert long.choice.endswith(f", constant gains for {long.settled:.1%}")


def test_where_c_has_none_those_of_xla_go_first(monkeypatch):
    long = with_constant_gains(monkeypatch, settle=False)
    assert long.value_and_gradient(np.zeros(3)) is None
    assert long.value(np.zeros(3)) is None
    assert long.choice == "XLA: its constant gains take less than C does"


def test_of_many_parameters_constant_gains_are_xla_s(monkeypatch):
    monkeypatch.setattr(route, "_MOST_SETTLED", 2)
    long = with_constant_gains(monkeypatch)
    assert long.value_and_gradient(np.zeros(3)) is None
    assert long.choice == "XLA: its constant gains take less than C does"


def test_without_a_compiler_nothing_changes(monkeypatch):
    monkeypatch.setenv("TUNER_NATIVE", "on")
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.delenv("CC", raising=False)
    assert refused(posed()) == "XLA: there is no C compiler (cc)"


@pytest.mark.parametrize(
    ("script", "reason"),
    [
        ("exit 3", "ended with status 3: no message"),
        ("echo nothing", "cannot be loaded"),
        ("exec sleep 9 &\nwait", "did not end within 1 s"),
    ],
)
def test_a_broken_compiler_changes_nothing(script, reason, monkeypatch, tmp_path):
    broken = tmp_path / "mycc"
    made = 'case "$*" in *-shared*) touch loop.so;; esac'
    broken.write_text(f"#!/bin/sh\n{script}\n{made}\n")
    broken.chmod(0o700)
    monkeypatch.setenv("TUNER_NATIVE", "on")
    monkeypatch.setenv("CC", str(broken))
    monkeypatch.setenv("TUNER_CACHE", str(tmp_path))
    monkeypatch.setattr(compiler, "SECONDS", 1)
    told = refused(posed())
    assert told.startswith("XLA: ")
    assert reason in told


def test_nowhere_to_write_changes_nothing(forced, monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("TUNER_CACHE", str(tmp_path / "file"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "file"))
    assert "Not a directory" in refused(posed())


def test_c_that_is_wrong_is_not_used(forced, monkeypatch):
    monkeypatch.setattr(route, "AGREED", -1.0)
    assert "compiled C differs from it by" in refused(posed())


def test_an_unknown_word_is_refused(monkeypatch):
    monkeypatch.setenv("TUNER_NATIVE", "yes")
    with pytest.raises(ValueError, match="TUNER_NATIVE is 'yes'; set it to auto, on or off"):
        route.use()


@pytest.mark.parametrize(
    ("name", "error", "words"),
    [
        ("covariance, continuous", NoCounterpartError, "solving a system of equations"),
        ("unscented, two rates", TooLargeError, "more than 500 operations"),
    ],
)
def test_what_has_no_c(name, error, words, tmp_path, monkeypatch):
    monkeypatch.setattr("tuner.native.iteration.MOST", 500)
    case = next(case for case in CASES if case.name == name)
    data = jax.tree.map(np.asarray, Data(case.inputs(case.measured), np.ones(len(case.measured))))
    with pytest.raises(error, match=words):
        Native(case.filter, Weighed(), case.build, len(case.point), data, tmp_path)


# What is kept.

ONE = "int one(void) { return 1; }\n"


def test_code_is_kept_for_its_owner_alone(tmp_path):
    needed("cc")
    folder = tmp_path / "code"
    assert library(ONE, folder).one() == 1
    (kept,) = folder.iterdir()
    assert stat.S_IMODE(kept.stat().st_mode) == 0o700
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    made = kept.stat().st_mtime_ns
    assert library(ONE, folder).one() == 1
    assert kept.stat().st_mtime_ns == made
    assert library(ONE.replace("1", "2"), folder).one() == 2
    assert len(list(folder.iterdir())) == 2


@pytest.mark.parametrize("damage", [b"", b"no library", None])
def test_kept_code_that_is_not_ours_is_made_anew(damage, tmp_path):
    needed("cc")
    folder = tmp_path / "code"
    library(ONE, folder)
    (kept,) = folder.iterdir()
    if damage is None:
        other = tmp_path / "other"
        kept.rename(other)
        kept.symlink_to(other)
    else:
        kept.unlink()  # it is in use: written over, it would take this process with it
        kept.write_bytes(damage)
        kept.chmod(0o700)
    assert library(ONE, folder).one() == 1
    assert kept.is_file()
    assert not kept.is_symlink()


def test_a_folder_that_others_may_write_to_is_not_used(tmp_path):
    needed("cc")
    shared, linked, missing = tmp_path / "shared", tmp_path / "linked", tmp_path / "file"
    shared.mkdir()
    shared.chmod(0o777)
    (tmp_path / "target").mkdir()
    linked.symlink_to(tmp_path / "target")
    missing.touch()
    for folder in (shared, shared / "code", linked, missing / "code"):
        assert not own(folder)
        assert library(ONE, folder).one() == 1
    assert not list((shared / "code").iterdir())
    assert not list((tmp_path / "target").iterdir())


def test_a_folder_of_another_is_not_used(tmp_path, monkeypatch):
    owner = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: owner + 1)
    (tmp_path / "code").mkdir(mode=0o700)
    assert not own(tmp_path / "code")


def test_a_compiler_with_arguments_that_does_not_know_this_processor(tmp_path, monkeypatch):
    needed("cc")
    monkeypatch.setenv("CC", "cc -DNUMBER=7")
    monkeypatch.setattr(compiler, "HERE", ("-march=of-tomorrow",))
    assert library("int one(void) { return NUMBER; }\n", tmp_path / "code").one() == 7


def test_a_compiler_that_says_no_is_quoted(tmp_path):
    needed("cc")
    with pytest.raises(NoCodeError, match=r"cc ended with status 1: .*error"):
        library("int one(void) { return", tmp_path / "code")
