"""Gradients by a pass over the record and one back in C, against XLA's."""

import re
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import LinearKalman, LinearModel, Sample, Transition
from objectives import Data, InnovationLikelihood, score_and_gradient
from tests.filters.battery import CASES
from tests.tuner.code.compiled import needed
from tests.tuner.test_native import Weighed, at_end, quickly
from tuner import Positive, Problem, Space
from tuner.code.refused import NoCounterpartError
from tuner.compiler import library
from tuner.native import pass_run, passes
from tuner.native.backwards import Backwards
from tuner.native.row_function import RowFunction

N = 200


def noises(values):
    """A swinging body, whose place is measured; all that can be uncertain is."""
    kept, turned, q, r, P0 = (values[name] for name in ("kept", "turned", "q", "r", "P0"))
    move = jnp.array([[0.99, 0.1 * turned], [-0.1, 0.99 * kept**0.01]])
    noise = jnp.array([[q, 0.1 * q], [0.1 * q, values["q_across"]]])
    start = P0 * jnp.array([[1.0, 0.2], [0.2, 1.0]])
    seen = jnp.array([[1.0, values["h"]]])
    x0 = jnp.stack([values["x0"], values["v0"]])
    return LinearModel(Transition(move, jnp.eye(2), noise), seen, r[None], start, x0)


def posed(objective, length=N):
    draw = np.random.default_rng(3)
    z = np.cumsum(draw.normal(size=(length, 1)), 0)
    z[draw.random(z.shape) < 0.1] = np.nan
    names = ("q", "q_across", "r", "P0", "x0", "v0", "h", "kept", "turned")
    space = Space.of(**{name: Positive(1.0, 1e-3, 1e3) for name in names})
    data = Data(Sample(z), np.zeros(length))
    return Problem("swing", space, LinearKalman(), noises, objective, data)


@pytest.fixture(autouse=True)
def forced(monkeypatch):
    needed("cc")
    monkeypatch.setenv("TUNER_NATIVE", "on")


@pytest.mark.parametrize(
    "name", ["linear, full R, varying dt", "extended, two rates", "Mahony, field", "a gate"]
)
def test_gradients_of_the_battery(name, tmp_path):
    case = next(case for case in CASES if case.name == name)
    z, truth = np.asarray(case.point, float), 1.0 + np.arange(len(case.measured))
    case.build(case.point)
    data = jax.tree.map(np.asarray, Data(case.inputs(case.measured), truth))
    native = Backwards(case.filter, Weighed(), case.build, len(z), data, tmp_path / "code")
    value, gradient = native.value_and_gradient(z, native.rows(data), data)
    right = quickly(score_and_gradient, static_argnums=(0, 1, 2))
    wanted, slopes = right(case.filter, Weighed(), case.build, jnp.asarray(z), data)
    assert value == pytest.approx(float(wanted), rel=1e-12)
    np.testing.assert_allclose(gradient, slopes, rtol=1e-11, atol=1e-11 * np.abs(slopes).max())


@pytest.mark.parametrize("objective", [InnovationLikelihood(), at_end])
def test_a_problem_of_many_parameters_goes_back(objective):
    problem = posed(objective)
    z = problem.space.start() + 0.1
    value, gradient = problem.value_and_gradient(z)
    wanted, slopes = problem.by_xla(z)
    assert problem.gradient_by.startswith("C, compiled by"), problem.gradient_by
    assert problem.route.goes_back
    assert value == pytest.approx(wanted, rel=1e-12)
    np.testing.assert_allclose(gradient, slopes, rtol=1e-11, atol=1e-11 * np.abs(slopes).max())
    assert np.abs(slopes).min() > 0
    assert problem.value(z) == pytest.approx(problem.value_by_xla(z), rel=1e-12)


def test_values_alone_go_by_c_and_the_result_says_so():
    problem = posed(InnovationLikelihood())
    z = problem.space.start()
    assert problem.value(z) == pytest.approx(problem.value_by_xla(z), rel=1e-12)
    assert problem.gradient_by.startswith("values by C, compiled by")
    assert problem.value(np.full(9, 900.0)) == np.inf


def test_values_that_differ_from_xla_s_are_xla_s(monkeypatch):
    problem = posed(InnovationLikelihood())
    monkeypatch.setattr(Backwards, "value", lambda *_: 1.0)
    z = problem.space.start()
    assert problem.value(z) == problem.value_by_xla(z)
    assert problem.gradient_by == ""


def test_a_long_record_is_stored_in_parts(monkeypatch):
    whole = posed(InnovationLikelihood()).value_and_gradient(np.full(9, 0.3))
    for samples in (1, 7, N - 1, N):
        monkeypatch.setattr(pass_run, "part_of", lambda *_, n=samples: n)
        found = posed(InnovationLikelihood()).value_and_gradient(np.full(9, 0.3))
        assert found[0] == whole[0]
        np.testing.assert_array_equal(found[1], whole[1])


def test_records_end_to_end_begin_anew(tmp_path):
    problem = posed(InnovationLikelihood())
    z, (static, data) = np.full(9, 0.2), (problem.static, problem.data)
    native = Backwards(
        static.filter, static.objective, static.built, len(z), data, tmp_path / "code"
    )
    rows = native.rows(data)
    value, gradient = native.value_and_gradient(z, rows, data, at=(80, 150))
    parts = [
        jax.tree.map(lambda x, s=s: x[s], data) for s in map(slice, (0, 80, 150), (80, 150, N))
    ]
    counts = [np.isfinite(part.inputs.z).sum() for part in parts]
    found = [
        score_and_gradient(static.filter, static.objective, static.built, jnp.asarray(z), part)
        for part in parts
    ]
    total = sum(counts)
    assert value == pytest.approx(
        sum(c * v for c, (v, _) in zip(counts, found, strict=True)) / total
    )
    slopes = sum(c * g for c, (_, g) in zip(counts, found, strict=True)) / total
    np.testing.assert_allclose(gradient, slopes, rtol=1e-11)


def test_an_operation_without_a_way_back_is_named(tmp_path):
    case = next(case for case in CASES if case.name == "heavy tails")
    z = np.asarray(case.point, float)
    data = jax.tree.map(np.asarray, Data(case.inputs(case.measured), np.ones(len(case.measured))))
    with pytest.raises(NoCounterpartError, match="dynamic_update_slice by an index"):
        Backwards(case.filter, Weighed(), case.build, len(z), data, tmp_path)


def dense(n):
    """States that all hang together, each shaken by itself."""
    move = 0.95 * np.linalg.qr(np.random.default_rng(1).normal(size=(n, n)))[0]

    def build(values):
        noise = jnp.diag(jnp.stack([values[f"q{k}"] for k in range(n)]))
        step = Transition(jnp.asarray(move), jnp.eye(n), noise)
        return LinearModel(step, jnp.eye(3, n), jnp.ones(3), jnp.eye(n), jnp.zeros(n))

    return build


@pytest.mark.parametrize(("n", "row"), [(9, 9), (11, 12), (13, 13)])
def test_dense_matrices_go_by_rows(n, row):
    """Rows of nine take one vector more, of eleven one that is not full, of thirteen numbers."""
    draw = np.random.default_rng(4)
    z = draw.normal(size=(N, 3))
    z[draw.random(z.shape) < 0.1] = np.nan
    space = Space.of(**{f"q{k}": Positive(1.0 + k, 1e-3, 1e3) for k in range(n)})
    objective, data = InnovationLikelihood(), Data(Sample(z), np.zeros(N))
    problem = Problem("dense", space, LinearKalman(), dense(n), objective, data)
    at = problem.space.start()
    value, gradient = problem.value_and_gradient(at)
    wanted, slopes = problem.by_xla(at)
    code, width = problem.route._single._code, 512 if n == 9 else 256
    assert f"-mprefer-vector-width={width}" in code.options
    assert value == pytest.approx(wanted, rel=1e-12)
    np.testing.assert_allclose(gradient, slopes, rtol=1e-11, atol=1e-11 * np.abs(slopes).max())
    copied = rf"mirror\(m\d+, {row}, {n}\);"
    assert len(re.findall(copied, code.text)) == 2  # one half of a covariance, forwards and back
    assert "+ weight[i0 + " not in code.text  # no transposed half is added


@pytest.mark.parametrize("name", ["extended, two rates", "Madgwick, field", "several records"])
def test_arrays_have_the_same_gradients_as_scalars(name, monkeypatch, tmp_path):
    case = next(case for case in CASES if case.name == name)
    z, truth = np.asarray(case.point, float), 1.0 + np.arange(len(case.measured))
    case.build(case.point)
    data = jax.tree.map(np.asarray, Data(case.inputs(case.measured), truth))

    def found():
        native = Backwards(case.filter, Weighed(), case.build, len(z), data, tmp_path / "code")
        value, gradient = native.value_and_gradient(z, native.rows(data), data)
        return native, np.array([value, *gradient])

    _, scalars = found()
    monkeypatch.setattr(passes, "MOST", 0)
    by_rows, arrays = found()
    assert by_rows._code.options
    np.testing.assert_allclose(arrays, scalars, rtol=1e-11, atol=1e-11 * np.abs(scalars).max())


def test_options_that_a_compiler_does_not_know_are_left_out(tmp_path):
    text = "int run(int x) { return 2 * x; }"
    found = library(text, tmp_path / "code", ("-O3", "-fno-such-option", "-ftree-vectorize"))
    assert found.run(4) == 8


def test_records_take_turns_in_the_same_memory(tmp_path):
    """Of equal length and not, in any order, also for values alone in between."""
    problems = [posed(InnovationLikelihood(), length) for length in (N, N, N + 7)]
    for k, problem in enumerate(problems):
        walk = np.arange(len(problem.data.truth))[:, None] ** 0.5
        moved = Sample(problem.data.inputs.z + 0.3 * k * walk)
        problems[k] = replace(problem, data=Data(moved, problem.data.truth))
    static, z = problems[0].static, np.full(9, 0.2)
    given = static.filter, static.objective, static.built, len(z), problems[0].data
    native = Backwards(*given, tmp_path / "code")
    rows = [native.rows(problem.data) for problem in problems]
    right = [problem.by_xla(z) for problem in problems]
    for k in (0, 1, 0, 2, 1, 2, 2, 0):
        data, (value, gradient) = problems[k].data, right[k]
        assert native.value(z, rows[k], data) == pytest.approx(value, rel=1e-12)
        found = native.value_and_gradient(z, rows[k], data)
        assert found[0] == pytest.approx(value, rel=1e-12)
        np.testing.assert_allclose(found[1], gradient, rtol=1e-10, atol=1e-10)


def test_one_call_finds_what_its_steps_find(tmp_path, monkeypatch):
    problem = posed(InnovationLikelihood())
    static, data, z = problem.static, problem.data, np.full(9, 0.2)
    given = static.filter, static.objective, static.built, len(z), data, tmp_path / "code"
    whole, steps = Backwards(*given), Backwards(*given)
    assert whole._whole is not None
    monkeypatch.setattr(RowFunction, "address", 0)
    assert steps._whole is None
    assert steps._valued is None
    rows = whole.rows(data)
    for point in (z, z + 0.1, z):
        found, right = (way.value_and_gradient(point, rows, data) for way in (whole, steps))
        assert found[0] == right[0] == whole.value(point, rows, data)
        np.testing.assert_array_equal(found[1], right[1])


def test_results_outlive_the_memory_they_were_found_in():
    problem = posed(InnovationLikelihood())
    _, first = problem.value_and_gradient(np.full(9, 0.2))
    kept = first.copy()
    problem.value_and_gradient(np.full(9, 0.4))
    np.testing.assert_array_equal(first, kept)


def test_what_is_kept_of_each_sample_goes_step_by_step():
    problem = posed(at_end)
    problem.value_and_gradient(problem.space.start())
    assert problem.route._single._whole is None
