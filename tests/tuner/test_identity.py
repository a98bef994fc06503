"""Nothing that is kept is taken for another problem's, and a refused run leaves nothing."""

import json
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import optuna
import pytest

import tuner.run.identity
from objectives import Data
from tests.tuner.helpers import SQUARE, Solved, bowl, problem, snapshot, toy_study, trench
from tuner.code_version import code_of, sources_digest
from tuner.data.source import Source
from tuner.problem.parameters import Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.run.result import read_result
from tuner.solvers import Sampler, make_solver

# Problems.


def shifted(shift, data=(0.0, 0.0), space=SQUARE):
    """The same name, the same code, another number in it."""

    def objective(outputs, truth):
        return bowl(outputs, truth) + shift

    return replace(problem(objective, name="same", space=space), data=Data(*np.array([data, data])))


def test_equal_problems_have_one_identity():
    assert shifted(0.5).identity() == shifted(0.5).identity()


def test_whatever_changes_the_numbers_changes_the_identity():
    wide = Space.of(
        a=Positive(1.0, low=np.exp(-3), high=np.exp(4)), b=Positive(1.0, low=0.1, high=9)
    )
    others = [
        shifted(0.5 + 1e-16 * 4),
        shifted(0.5, data=(0.0, np.nextafter(0, 1))),
        shifted(0.5, data=(0.0, np.nan)),
        shifted(0.5, space=wide),
        replace(shifted(0.5), objective=trench),
    ]
    assert len({shifted(0.5).identity(), *(each.identity() for each in others)}) == 6


def test_an_identity_sees_what_is_read_as_it_is_traced(monkeypatch):
    """A variable of a module is no part of a function's code."""
    seen = []
    for value in (1.0, 2.0):
        monkeypatch.setitem(globals(), "LOOSE", value)
        seen.append(problem(lambda outputs, _: LOOSE + outputs[-1].sum()).identity())  # noqa: F821
    assert seen[0] != seen[1]


def test_the_digest_of_code_knows_names_and_contents(tmp_path):
    (tmp_path / "a.py").write_text("x = 1")
    one = sources_digest(tmp_path)
    (tmp_path / "b.py").write_text("")
    two = sources_digest(tmp_path)
    (tmp_path / "a.py").write_text("x = 2")
    assert len({one, two, sources_digest(tmp_path), sources_digest(tmp_path / "a.py")}) == 4
    assert code_of("tests.tuner.helpers") == ""  # a namespace has no file
    assert code_of("numpy.linalg") == code_of("numpy")


# Trials.


def hill(c):
    space = Space.of(a=Positive(1.0, 1e-3, 1e3))
    return Problem("same", space, None, lambda p: p, lambda p, _: 1 + (jnp.log(p["a"]) - c) ** 2)


def test_problems_of_one_name_do_not_share_their_trials(tmp_path):
    url = f"sqlite:///{tmp_path / 't.db'}"
    for c in (-3.0, 3.0):
        found = Sampler("tpe", seed=0, storage=url, trials=3)(hill(c))
        assert found.value == hill(c).value(found.z)
    assert len(optuna.get_all_study_names(url)) == 2
    # Nor do versions of the code.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tuner.solvers.sampling.code_version", lambda: "f" * 64)
        Sampler("tpe", seed=0, storage=url, trials=1)(hill(3.0))
    assert len(optuna.get_all_study_names(url)) == 3


def test_a_database_that_was_changed_is_told(tmp_path):
    url = f"sqlite:///{tmp_path / 't.db'}"
    sampler = Sampler("tpe", seed=0, storage=url, trials=2)
    sampler(hill(1.0))
    storage = optuna.storages.RDBStorage(url)
    with storage.engine.begin() as connection:
        connection.exec_driver_sql("update trial_values set value = 0.5")
    storage.engine.dispose()
    with pytest.raises(ValueError, match=r"has the value 0.5 in the database, and .* scored again"):
        sampler(hill(1.0))


# Runs.


def toy_of(sha="0" * 64, *, at=None, figures=None):
    """The toy study on data of a digest, with a solver that is interrupted at a problem."""

    def solver(name, **options):
        inner = make_solver(name, **options)

        def solve(problem):
            if problem.name == at:
                raise KeyboardInterrupt
            return inner(problem)

        return Solved(name, solve)

    study = toy_study(solver=solver)

    def plan(*given):
        made = replace(study.plan(*given), source=Source("folder", sha, 2, 100.0))
        return made if figures is None else replace(made, figures=figures)

    return replace(study, plan=plan)


def test_other_data_of_a_folder_cannot_be_mixed_into_a_run(cli, here, offer):
    offer(toy_of(at="side"))
    assert cli("run", "toy", "--out", "out", "--jobs", 1)[0] == 130
    before = snapshot(here)
    offer(toy_of("1" * 64))
    code, out, err = cli("run", "toy", "--out", "out", "--resume")
    assert (code, out) == (2, "")
    assert err.startswith("tuner: --resume: there are other data than in the interrupted run")
    assert len(err.splitlines()) == 1
    assert snapshot(here) == before
    offer(toy_of())
    assert cli("run", "toy", "--out", "out", "--resume")[0] == 0


def test_another_version_of_the_code_does_not_go_on(cli, here, offer, monkeypatch):
    offer(toy_of(at="side"))
    assert cli("run", "toy", "--out", "out", "--jobs", 1)[0] == 130
    monkeypatch.setattr(tuner.run.identity, "code_version", lambda: "f" * 64)
    code, _, err = cli("run", "toy", "--out", "out", "--resume")
    assert code == 2
    assert "another version of the code" in err


def test_solutions_of_a_run_are_scored_again(cli, here, offer):
    offer(toy_of(at="side"))
    assert cli("run", "toy", "--out", "out", "--jobs", 1)[0] == 130
    file = here / "out" / "progress.json"
    kept = json.loads(file.read_text())
    kept["finished"][0]["solution"]["value"] *= 2
    file.write_text(json.dumps(kept))
    offer(toy_of())
    code, _, err = cli("run", "toy", "--out", "out", "--resume")
    assert code == 2
    assert err.startswith("tuner: toy is not the problem that nelder-mead solved before")


def test_force_starts_clean(cli, here, offer):
    offer(toy_of())
    words = ("run", "toy", "--out", "out", "--set", 'solvers=["l-bfgs-b"]')
    assert cli(*words)[0] == 0
    first = read_result(here / "out")
    assert set(first.identity) == {"settings", "data", "code"}
    (here / "out" / "trials.sqlite3").write_bytes(b"of another run")
    (here / "out" / "figures" / "mine.png").write_bytes(b"precious")
    offer(toy_of("1" * 64, figures=lambda *_: ()))
    assert cli(*words, "--force")[0] == 0
    assert read_result(here / "out").identity["data"] == "1" * 64 != first.identity["data"]
    kept = snapshot(here / "out")
    assert "trials.sqlite3" not in kept
    assert [name for name in kept if name.startswith("figures/")] == ["figures/mine.png"]


def test_what_refuses_a_forced_run_leaves_the_one_before(cli, here, offer):
    offer(toy_of())
    assert cli("run", "toy", "--out", "out")[0] == 0
    before = snapshot(here)
    words = ("--force", "--storage", "nonsense")
    assert cli("run", "toy", "--out", "out", *words)[0] == 2
    assert snapshot(here) == before


@pytest.mark.parametrize(
    "words",
    [
        ("--storage", "nonsense"),
        ("--storage", "sqlite:////no/such/folder/x"),
        ("--set", "starts=0"),
        ("--set", 'solvers=["cma-es", "l-bfgs-b"]', "--set", "starts=0"),
    ],
    ids=str,
)
def test_a_refused_run_leaves_nothing(cli, here, toy, words):
    code, _, err = cli("run", "toy", "--out", "out", *words)
    assert (code, len(err.splitlines())) == (2, 1)
    assert snapshot(here) == {}


def test_a_problem_that_cannot_be_scored_leaves_nothing(cli, here, toy, monkeypatch):
    def refuse(self, z):
        raise ValueError("this cannot be scored")

    monkeypatch.setattr(Problem, "value", refuse)
    assert cli("run", "toy", "--out", "out") == (2, "", "tuner: this cannot be scored\n")
    assert snapshot(here) == {}


def test_a_figure_that_cannot_be_drawn_costs_the_figure(cli, here, offer):
    def figures(case, solutions):
        yield "no figure"
        raise RuntimeError("no font\nat all")

    offer(toy_of(figures=figures))
    code, _, err = cli("run", "toy", "--out", "out")
    assert code == 0
    result = read_result(here / "out")
    assert err.splitlines() == result.not_drawn
    assert len(result.not_drawn) == 1
    assert not (here / "out" / "figures").exists()
