"""A program that was compiled once is found again, only by what it follows from, and unaltered."""

import os
from dataclasses import dataclass, replace
from time import sleep

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import Lanes, LocalLevel, LocalLevelNoise, run
from filters.local_level import LevelSample
from objectives import Data, InnovationLikelihood
from tests.tuner.model.documents import SHORT, made
from tests.tuner.stored import forget
from tuner import Positive, Problem, Space, code_version, programs_ahead, stored_programs
from tuner.cached import digest, program_folder
from tuner.problem import lines
from tuner.problem.programs import run_filter, sum_of
from tuner.programs_ahead import Programs
from tuner.stored_programs import StoredProgram, as_last_time, stored_text

NOISE = LocalLevelNoise(jnp.array(0.3), jnp.array(2.0))
SAMPLES = LevelSample(np.sin(np.arange(30.0)))


@pytest.fixture
def filter():
    """A filter that nobody has compiled, for what JAX has kept of it is not stored again."""
    return LocalLevel(dt=float(np.random.default_rng().uniform(0.1, 0.2)))


@pytest.fixture
def only_found(monkeypatch):
    """From when it is called, what is not found in the folder fails."""

    def refused(*_):
        raise AssertionError("traced anew")

    return lambda: monkeypatch.setattr(StoredProgram, "_traced_anew", refused)


def kept():
    return sorted(program_folder().glob("*.bin"))


def another(**options):
    """The program of run_filter as another process makes it."""
    return StoredProgram(run_filter.__wrapped__, 1, options)


@pytest.mark.usefixtures("stored")
def test_another_process_finds_the_program_and_the_same_numbers(filter, only_found):
    first = another()(filter, NOISE, SAMPLES)
    assert len(kept()) == 2  # the program by its text, and what it follows from
    only_found()
    again = another()(filter, NOISE, SAMPLES)
    exact = run(filter, NOISE, SAMPLES)[1]
    assert type(again) is type(first) is type(exact)
    for one, two, three in zip(first, again, exact, strict=True):
        assert np.array_equal(one, two)
        assert np.allclose(two, three, rtol=1e-13)  # without a loop that is compiled as a whole


@pytest.mark.usefixtures("stored")
def test_it_runs_on_other_numbers_than_those_it_was_made_with(filter, only_found):
    other = LocalLevelNoise(jnp.array(3.0), jnp.array(0.5)), LevelSample(np.cos(np.arange(30.0)))
    another()(filter, NOISE, SAMPLES)
    only_found()
    found, exact = another()(filter, *other), run(filter, *other)[1]
    assert np.allclose(found.level, exact.level, rtol=1e-13)


@pytest.mark.usefixtures("stored")
@pytest.mark.parametrize("kept", [True, False], ids=["kept", "traced"])
def test_of_the_first_array_alone_nothing_is_looked_up(kept, filter, monkeypatch):
    if not kept:
        monkeypatch.delenv("TUNER_PROGRAMS")
    level = StoredProgram(lambda filter, q, R, z: run(filter, LocalLevelNoise(q, R), z)[1], 1, {})
    of_q = level.of_first(filter, np.array(0.3), np.array(2.0), SAMPLES)

    def refused(*_):
        raise AssertionError("looked up")

    monkeypatch.setattr(StoredProgram, "_split", refused)
    for q in (0.3, 3.0):
        exact = run(filter, LocalLevelNoise(jnp.array(q), NOISE.R), SAMPLES)[1]
        assert np.allclose(of_q(np.array(q)).level, exact.level, rtol=1e-13)


@pytest.mark.usefixtures("stored")
def test_a_stored_program_that_fails_here_is_traced(filter, monkeypatch):
    def fails(*_):
        raise jax.errors.JaxRuntimeError("of another machine")

    monkeypatch.setattr(StoredProgram, "_program", lambda *_: fails)
    level = StoredProgram(lambda filter, q, R, z: run(filter, LocalLevelNoise(q, R), z)[1], 1, {})
    given = filter, *map(np.asarray, NOISE), SAMPLES
    exact = run(filter, NOISE, SAMPLES)[1]
    for found in (level(*given), level.of_first(*given)(given[1])):
        assert np.allclose(found.level, exact.level, rtol=1e-13)


@pytest.mark.usefixtures("stored")
def test_the_value_of_many_recordings_is_found(filter, only_found, monkeypatch):
    monkeypatch.setattr(lines, "LEAST", 0)
    side_by_side = LevelSample(np.sin(np.arange(60.0)).reshape(30, 2))
    data = Data(side_by_side, side_by_side.z)
    space = Space.of(q=Positive(0.3, 1e-3, 1e3), R=Positive(2.0, 1e-3, 1e3))

    def value():
        program = StoredProgram(sum_of.__wrapped__, 1, {})
        program.traced = None  # of arguments that it cannot be stored for
        monkeypatch.setattr(lines, "sum_of", program)
        problem = Problem("two", space, Lanes(filter, 2), None, InnovationLikelihood(), data)
        assert problem.in_lines is not None
        return problem.value_by_xla(problem.space.start())

    first = value()
    only_found()
    assert value() == first


@pytest.mark.usefixtures("stored")
def test_a_filter_of_a_model_is_found_with_its_own_tuples(only_found):
    cls = made(SHORT)
    filter = cls(dt=float(np.random.default_rng().uniform(0.1, 0.2)))
    given = cls.params(jnp.array(0.3), jnp.array(2.0)), cls.inputs(np.sin(np.arange(30.0)))
    first = another()(filter, *given)
    only_found()
    again = another()(filter, *given)
    assert type(again) is cls.outputs
    assert np.array_equal(first.level, again.level)


@pytest.mark.usefixtures("stored")
def test_what_differs_in_anything_is_another_program(filter, monkeypatch):
    def count():
        forget()
        return len(kept())

    another()(filter, NOISE, SAMPLES)
    another()(replace(filter, dt=1.5 * filter.dt), NOISE, SAMPLES)
    assert count() == 4
    another()(filter, NOISE, LevelSample(np.arange(31.0)))
    assert count() == 6
    another(xla_backend_optimization_level=0)(filter, NOISE, SAMPLES)
    assert count() == 8
    before = stored_programs.key_of(filter)
    monkeypatch.setenv("XLA_FLAGS", "--xla_cpu_enable_fast_math=true")
    forget()
    assert stored_programs.key_of(filter) != before


@pytest.mark.usefixtures("stored")
def test_other_code_traces_anew_and_compiles_only_what_has_changed(filter, monkeypatch):
    def refused(*_):
        raise AssertionError("compiled anew")

    first = another()(filter, NOISE, SAMPLES)
    monkeypatch.setattr(code_version, "code_version", lambda: "of tomorrow")
    monkeypatch.setattr(stored_programs, "_compiled", refused)
    again = another()(filter, NOISE, SAMPLES)
    assert np.array_equal(first.level, again.level)
    assert len(kept()) == 3
    with pytest.raises(AssertionError, match="compiled anew"):
        another()(replace(filter, dt=1.5 * filter.dt), NOISE, SAMPLES)


@pytest.mark.usefixtures("stored")
def test_settings_of_jax_are_part_of_a_key():
    before = stored_programs.key_of(1)
    forget()
    kept = jax.config.jax_default_matmul_precision
    try:
        jax.config.update("jax_default_matmul_precision", "float32")
        assert stored_programs.key_of(1) != before
    finally:
        jax.config.update("jax_default_matmul_precision", kept)


@dataclass(frozen=True)
class Own(LocalLevel):
    """A filter of the user's own, whose code may change from run to run."""


@pytest.mark.usefixtures("stored")
def test_a_filter_of_the_users_own_is_traced_in_every_run(filter):
    found = another()(Own(filter.dt), NOISE, SAMPLES)
    assert np.allclose(found.level, run(filter, NOISE, SAMPLES)[1].level, rtol=1e-13)
    assert not kept()


@pytest.mark.usefixtures("stored")
def test_what_is_part_of_another_program_is_traced(filter):
    program = another()
    slope = jax.grad(lambda q: program(filter, NOISE._replace(q=q), SAMPLES).level.sum())(1.0)
    assert np.isfinite(slope)
    assert not kept()


@pytest.mark.usefixtures("stored")
def test_an_altered_file_is_not_loaded(filter):
    program = another()(filter, NOISE, SAMPLES)
    for file in kept():
        file.write_bytes(file.read_bytes()[:-1] + b"x")
    again = another()(filter, NOISE, SAMPLES)
    assert np.array_equal(program.level, again.level)


def move(file):
    file.rename(file.with_suffix(".moved"))
    file.symlink_to(file.with_suffix(".moved"))


@pytest.mark.usefixtures("stored")
@pytest.mark.parametrize("alter", [lambda f: f.chmod(0o666), move])
def test_a_file_that_others_may_write_or_a_link_is_not_loaded(filter, only_found, alter):
    another()(filter, NOISE, SAMPLES)
    for file in kept():
        alter(file)
    only_found()
    with pytest.raises(AssertionError, match="traced anew"):
        another()(filter, NOISE, SAMPLES)


@pytest.mark.usefixtures("stored")
def test_a_file_of_another_kind_is_compiled_anew(filter):
    first = another()(filter, NOISE, SAMPLES)
    for file in kept():
        file.unlink()
        key = file.name.partition("-")[0]
        (program_folder() / f"{key}-{digest(b'no program')}.bin").write_bytes(b"no program")
    again = another()(filter, NOISE, SAMPLES)
    assert np.array_equal(first.level, again.level)


@pytest.mark.usefixtures("stored")
def test_a_folder_that_others_may_write_is_not_used(filter):
    program_folder().mkdir(parents=True)
    program_folder().chmod(0o777)
    assert not stored_programs.in_use()
    another()(filter, NOISE, SAMPLES)
    assert not kept()


@pytest.mark.usefixtures("stored")
def test_nothing_is_stored_while_the_source_changes(filter, monkeypatch):
    monkeypatch.setattr(code_version, "changed_since", lambda _: True)
    another()(filter, NOISE, SAMPLES)
    assert not kept()


def test_source_that_changed_is_noticed(tmp_path, monkeypatch):
    (tmp_path / "tuner").mkdir()
    monkeypatch.setattr(code_version, "__file__", str(tmp_path / "tuner" / "code_version.py"))
    file = tmp_path / "tuner" / "new.py"
    file.write_text("")
    began = os.stat(file).st_ctime
    os.utime(file, (began - 1e6, began - 1e6))  # as a package is unpacked, with its old date
    assert code_version.changed_since(began - 1.0)
    assert not code_version.changed_since(began + 60.0)


def test_without_the_word_nothing_is_stored(filter, tmp_path, monkeypatch):
    monkeypatch.setenv("TUNER_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("TUNER_PROGRAMS", raising=False)
    another()(filter, NOISE, SAMPLES)
    assert not (tmp_path / "cache").exists()


@pytest.mark.usefixtures("stored")
def test_a_text_is_made_once_for_plain_data():
    made = []

    def make():
        made.append("text")
        return "text"

    for _ in range(2):
        assert stored_text(make, "a name", 0.1) == "text"
    assert len(made) == 1
    assert stored_text(make, "a name", 0.2) == "text"
    assert stored_text(make, "a name", object()) == "text"
    assert stored_text(make, "a name", object()) == "text"
    assert len(made) == 4


# What the last run took is loaded ahead.


@pytest.fixture
def process(monkeypatch):
    """Another process: nothing is loaded yet. Returns the programs that it loads, by their keys."""

    def begun():
        loaded, own = [], Programs()
        monkeypatch.setattr(stored_programs, "_programs", own)
        load = programs_ahead.load
        monkeypatch.setattr(programs_ahead, "load", lambda one: loaded.append(one.key) or load(one))
        return loaded

    yield begun
    monkeypatch.undo()


@pytest.mark.usefixtures("stored")
def test_what_the_last_run_took_is_loaded_once_and_ahead(filter, process, only_found):
    process()
    with as_last_time("a run"):
        first = another()(filter, NOISE, SAMPLES)
    only_found()
    loaded = process()
    with as_last_time("a run"):
        again = another()(filter, NOISE, SAMPLES)
    assert len(loaded) == 1
    assert np.array_equal(first.level, again.level)
    loaded = process()
    with as_last_time("a run"):
        ahead(1, loaded)
    assert len(loaded) == 1
    loaded = process()
    with as_last_time("another run"):
        assert not loaded


@pytest.mark.usefixtures("stored")
def test_only_what_the_last_run_took_is_loaded_and_a_run_that_took_nothing_is_none(filter, process):
    other = replace(filter, dt=1.5 * filter.dt)
    for one in (filter, other):
        process()
        with as_last_time("a run"):
            another()(one, NOISE, SAMPLES)
    process()
    with as_last_time("a run"):
        pass
    loaded = process()
    with as_last_time("a run"):
        ahead(1, loaded)
    assert len(loaded) == 1


@pytest.mark.usefixtures("stored")
def test_what_was_to_be_loaded_and_is_gone_is_compiled_anew(filter, process):
    process()
    with as_last_time("a run"):
        first = another()(filter, NOISE, SAMPLES)
    for file in kept():
        if b"program" not in file.read_bytes() and not file.read_bytes().startswith(b"["):
            file.unlink()
    process()
    with as_last_time("a run"):
        again = another()(filter, NOISE, SAMPLES)
    assert np.array_equal(first.level, again.level)


def ahead(count, loaded):
    """Wait until so many programs are loaded."""
    for _ in range(500):
        if len(loaded) >= count:
            return
        sleep(0.01)
