"""The engine: solving, saving, going on, exporting what is trusted, drawing, writing down."""

import json
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.tuner.helpers import (
    Solved,
    ToySettings,
    bowl,
    logarithms,
    problem,
    snapshot,
    toy_plan,
)
from tuner import export
from tuner.certificate.solution import Status
from tuner.data.source import Source
from tuner.export import FORMATS
from tuner.problem.parameters import Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.run.exports import score_export
from tuner.run.folder import RunFolder
from tuner.run.pipeline import Run, trusted
from tuner.run.progress_file import read_progress, resumed_solutions
from tuner.run.result import read_result
from tuner.run.study import best
from tuner.solvers import make_solver


def begin(folder, *, solver=make_solver, progress=lambda *_: None, **settings):
    """A run of the toy study with settings of its own."""
    chosen = ToySettings(**settings)
    plan = toy_plan(chosen, (), 0, "", solver=solver)
    return Run("toy", chosen.model_dump(mode="json"), plan, 0, RunFolder(folder, False), progress)


def gone_on(folder):
    """What a run of the toy study would go on from."""
    progress = read_progress((folder / "progress.json").read_bytes())
    return resumed_solutions(progress, {}, begin(folder).plan.tasks)


def finish(run, solutions):
    return run.finish(solutions, FORMATS, 0.0)


@dataclass(frozen=True)
class Interrupting:
    """A solver that is interrupted at a problem."""

    inner: object
    at: str

    @property
    def name(self):
        return self.inner.name

    def __call__(self, problem):
        if problem.name == self.at:
            raise KeyboardInterrupt
        return self.inner(problem)


def interrupting(at):
    return lambda name, **options: Interrupting(make_solver(name, **options), at)


def refusing(name, **options):
    return Solved(name, lambda problem: pytest.fail(f"{problem.name} is solved again"))


def test_solutions_in_the_order_of_the_tasks(tmp_path):
    run = begin(tmp_path)
    solutions = run.solve(2, {})
    expected = [(p, s) for p in ("toy", "side") for s in ("nelder-mead", "l-bfgs-b")]
    assert list(solutions) == expected
    for (name, solver), solution in solutions.items():
        assert (solution.problem, solution.solver) == (name, solver)


def test_figures_are_drawn_while_exports_are_made(tmp_path):
    run, said = begin(tmp_path), []
    solutions = run.solve(1, {})
    finish(replace(run, progress=lambda *what: said.append(what)), solutions)
    first = [words.split()[0] for words, *_ in said]
    assert first.index("drawing") < first.index("exporting")
    done = [done for _, done, _ in said]
    assert done[:-1] == sorted(done[:-1])


def test_every_solution_is_saved_at_once(tmp_path):
    saved = []

    def look(words, done, total):
        file = tmp_path / "progress.json"
        there = len(json.loads(file.read_text())["finished"]) if done else None
        saved.append((words, done, total, there))

    begin(tmp_path, progress=look).solve(1, {})
    assert saved[0] == ("solving", 0, 4, None)
    assert [(done, total, there) for _, done, total, there in saved[1:]] == [
        (k, 4, k) for k in (1, 2, 3, 4)
    ]
    assert {words for words, *_ in saved[1:]} == {
        "toy: nelder-mead",
        "toy: l-bfgs-b",
        "side: nelder-mead",
        "side: l-bfgs-b",
    }


def test_jobs_do_not_change_the_numbers(tmp_path):
    one = begin(tmp_path / "a").solve(1, {})
    many = begin(tmp_path / "b").solve(4, {})
    for key, solution in one.items():
        assert many[key].z.tobytes() == solution.z.tobytes()
        assert many[key].certificate == solution.certificate


def test_methods_are_held_against_each_other(tmp_path):
    solutions = begin(tmp_path, solvers=("nelder-mead", "l-bfgs-b", "tpe")).solve(1, {})
    own = solutions["toy", "tpe"]
    assert set(own.certificate.methods) == {"nelder-mead", "l-bfgs-b"}
    for name, value in own.certificate.methods.items():
        assert value == solutions["toy", name].value
        assert value < own.value


# Interruption.


def test_interruption_leaves_what_is_finished(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        begin(tmp_path, solver=interrupting("side")).solve(1, {})
    assert set(snapshot(tmp_path)) == {"progress.json"}
    finished = gone_on(tmp_path)
    assert set(finished) == {("toy", "nelder-mead"), ("toy", "l-bfgs-b")}
    expected = begin(tmp_path / "other").solve(1, {})
    for key, solution in finished.items():
        assert solution.z.tobytes() == expected[key].z.tobytes()
        assert solution.value == expected[key].value


def test_interruption_before_anything_is_finished(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        begin(tmp_path, solver=interrupting("toy")).solve(1, {})
    assert gone_on(tmp_path) == {}


def test_going_on_skips_what_is_finished(tmp_path):
    whole = begin(tmp_path / "whole").solve(1, {})
    finished = {key: solution for key, solution in whole.items() if key[0] == "toy"}
    solved = []

    def noting(name, **options):
        solver = make_solver(name, **options)

        def solve(problem):
            solved.append((problem.name, name))
            return solver(problem)

        return Solved(name, solve)

    rest = begin(tmp_path / "rest", solver=noting).solve(1, finished)
    assert sorted(solved) == [("side", "l-bfgs-b"), ("side", "nelder-mead")]
    assert list(rest) == list(whole)
    for key, solution in whole.items():
        assert rest[key].z.tobytes() == solution.z.tobytes()
        assert rest[key].certificate == solution.certificate
    again = begin(tmp_path / "again", solver=refusing).solve(1, rest)
    assert list(again) == list(whole)


def test_a_foreign_progress_file_is_refused():
    for data in (b"", b"{}", b"[1]", b'[{"problem": "toy"}]', b'{"schema": "tuner.progress/2"}'):
        with pytest.raises(ValueError, match=r"^progress.json is not that of a run"):
            read_progress(data)


def test_an_error_in_a_solver_comes_through(tmp_path):
    def failing(name, **options):
        def solve(problem):
            raise ValueError(f"{name} cannot")

        return Solved(name, solve)

    with pytest.raises(ValueError, match="cannot$"):
        begin(tmp_path, solver=failing).solve(2, {})


# Finishing.


def test_a_finished_run(tmp_path):
    run = begin(tmp_path)
    result = finish(run, run.solve(1, {}))
    files = {name for name, data in snapshot(tmp_path).items() if data is not None}
    exports = {f"exports/toy{export.suffix(f)}" for f in FORMATS}
    code = {f"toy{end}" for end in (".h", ".c", "_selftest.c")}
    places = ("exports", "exports/float", "exports/tunable", "exports/float-tunable")
    exports |= {f"{place}/{name}" for place in places for name in code}
    figures = {"figures/curve.csv", "figures/curve.png"}
    assert files == {"result.json", "report.json", "report.html"} | figures | exports
    # study.toml and environment.json are written before a run begins, by the command line.
    assert set(result.artifacts) == files | {"study.toml", "environment.json"}
    assert read_result(tmp_path).to_json() == result.to_json()
    assert (result.study, result.seed) == ("toy", 0)
    assert result.settings["starts"] == 2
    assert [(s.problem, s.solver) for s in result.solutions] == list(run.solve(1, {}))
    assert [c.quantity for c in result.comparisons] == ["toy.b_over_a", "toy.lowest", "toy.known"]
    assert result.single_precision[0].problem == "toy"
    (check,) = result.single_precision
    assert (check.form, check.warning) == ("full", "")
    # The search ends on (1, -1) to the last digit, which single precision holds exactly.
    assert 0 <= check.share < 1e-6


def test_exports_are_read_back_and_score_as_the_solution_did(tmp_path):
    run = begin(tmp_path)
    solutions = run.solve(1, {})
    result = finish(run, solutions)
    value = best("toy", solutions).value
    assert [record.format for record in result.exports] == list(FORMATS)
    for record in result.exports:
        assert record.problem == "toy"
        # exp(z) rounds once where the parameters are written down, ln once more on scoring.
        assert record.score == pytest.approx(value, rel=1e-14)
        assert record.relative_change == pytest.approx(0.0, abs=1e-14)
        loaded = export.load((tmp_path / record.file).read_bytes(), record.format)
        assert loaded == run.tuned(run.plan.tasks[0].problem, best("toy", solutions))
        named = {quantity.name: quantity for quantity in loaded.quantities}
        assert named["a"].value == best("toy", solutions).parameters["a"].value
        assert named["a"].unit == "m"
        assert named["a"].meaning == "the first"
        ours = best("toy", solutions).derived["b_over_a"]
        # From logarithms and from the numbers themselves: a rounding or two.
        assert named["gain"].value == pytest.approx(ours, rel=1e-14)
        assert (loaded.name, loaded.filter, loaded.dt) == ("toy", "Echo", 0.01)
        assert loaded.provenance.status == "converged"


def test_a_file_that_was_changed_scores_differently():
    posed = problem(bowl, name="toy")
    parameters = {"a": np.e, "b": np.exp(-1.0)}
    tuned = export.Tuned(
        "toy",
        "Echo",
        (
            *(export.Quantity(n, np.array(v), "") for n, v in parameters.items()),
            export.Quantity("gain", np.array(3.0), ""),
        ),
        "discrete",
        0.01,
        (),
        export.Provenance("toy", "toy", "tpe", "converged", 0, "", "", ()),
    )
    record = score_export(posed, 1.0, tuned, "csv", "toy.csv")
    assert (record.problem, record.format, record.file) == ("toy", "csv", "toy.csv")
    assert record.score == pytest.approx(1.0, rel=1e-14)
    changed = replace(
        tuned, quantities=(export.Quantity("a", np.array(1.0), ""), *tuned.quantities[1:])
    )
    record = score_export(posed, 1.0, changed, "csv", "toy.csv")
    assert record.score == pytest.approx(2.0, rel=1e-14)
    assert record.relative_change == pytest.approx(1.0, rel=1e-14)
    missing = replace(tuned, quantities=tuned.quantities[1:])
    with pytest.raises(ValueError, match=r"^toy has no value for a: give them all$"):
        score_export(posed, 1.0, missing, "csv", "toy.csv")


def shifted(outputs, truth):
    return bowl(outputs, truth) - 1.0


def test_a_value_of_zero_can_be_scored():
    space = Space.of(a=Positive(np.e, 0.1, 10.0), b=Positive(np.exp(-1.0), 0.1, 10.0))
    posed = Problem("toy", space, problem(bowl).filter, logarithms, shifted, problem(bowl).data)
    tuned = export.Tuned(
        "toy",
        "Echo",
        tuple(export.Quantity(n, np.array(v), "") for n, v in (("a", 1.0), ("b", np.exp(-1.0)))),
        "discrete",
        0.01,
        (),
        export.Provenance("toy", "toy", "tpe", "converged", 0, "", "", ()),
    )
    record = score_export(posed, 0.0, tuned, "csv", "toy.csv")
    assert record.relative_change == record.score == pytest.approx(1.0, rel=1e-14)


def test_a_file_that_was_written_wrong_ends_the_run(tmp_path, monkeypatch):
    """The score alone would not notice a gain, for it scores the parameters."""
    run = begin(tmp_path)
    solutions = run.solve(1, {})
    dump = export.dump
    monkeypatch.setattr(
        export, "dump", lambda *given: dump(*given).replace(b"b over a", b"a over b")
    )
    with pytest.raises(ValueError, match=r"toy.json does not hold what was written; the disk may"):
        finish(run, solutions)


@dataclass(frozen=True)
class Doubling:
    """Echo in double precision, whatever comes in."""

    def init(self, params):
        return ()

    def step(self, params, state, inputs):
        return state, params.astype(float)


def test_a_filter_that_cannot_be_checked_in_single_precision_ends_no_run(tmp_path):
    run = begin(tmp_path)
    posed = replace(run.plan.tasks[0].problem, filter=Doubling())
    tasks = tuple(replace(task, problem=posed) for task in run.plan.tasks[:2])
    run = replace(run, plan=replace(run.plan, tasks=tasks))
    result = finish(run, run.solve(1, {}))
    (check,) = result.single_precision
    assert check.warning == (
        "single precision was not checked: the output '' is float64 for float32 inputs"
    )
    assert read_result(tmp_path).single_precision[0].share is None
    assert len(result.exports) == len(FORMATS)


def test_an_export_names_the_data_of_its_problem(tmp_path):
    run = begin(tmp_path)
    posed, solutions = run.plan.tasks[0].problem, run.solve(1, {})
    assert run.tuned(posed, best("toy", solutions)).provenance.log_name == "nothing"
    own = Source.simulated("its own", [np.ones(3)], 10.0)
    provenance = run.tuned(replace(posed, source=own), best("toy", solutions)).provenance
    assert (provenance.log_name, provenance.log_sha256) == ("its own", own.sha256)


def test_a_run_of_claims(tmp_path):
    run = begin(tmp_path)
    run = replace(run, plan=run.plan.only(["toy.lowest"]), claims=("toy.lowest",))
    solutions = run.solve(1, {})
    assert {name for name, _ in solutions} == {"toy"}
    result = finish(run, solutions)
    assert [row.quantity for row in result.comparisons] == ["toy.lowest"]
    own = ["study.toml", "environment.json", "report.json", "report.html", "result.json"]
    assert result.artifacts == own
    assert trusted(run.plan, solutions)


@pytest.mark.parametrize("objective", ["slope", "hollow"])
def test_what_did_not_converge_is_not_exported(tmp_path, objective):
    run = begin(tmp_path, objective=objective)
    solutions = run.solve(1, {})
    assert not best("toy", solutions).status.trusted
    assert not trusted(run.plan, solutions)
    result = finish(run, solutions)
    assert result.exports == []
    assert not (tmp_path / "exports").exists()
    # What would have been exported is in the result, for those who insist.
    assert result.tuned[0]["name"] == "toy"
    assert read_result(tmp_path).to_json() == result.to_json()


def test_trust_asks_for_what_is_exported_only(tmp_path):
    run = begin(tmp_path)
    solutions = dict(run.solve(1, {}))
    assert trusted(run.plan, solutions)
    for key in [key for key in solutions if key[0] == "side"]:
        solutions[key] = replace(solutions[key], status=Status.STALLED)
    assert trusted(run.plan, solutions)
    for key in [key for key in solutions if key[0] == "toy"]:
        solutions[key] = replace(solutions[key], status=Status.STALLED)
    assert not trusted(run.plan, solutions)


def test_the_best_solution_is_a_converged_one_among_equals(tmp_path):
    one, other = list(begin(tmp_path).solve(1, {}).values())[:2]
    value = one.value
    low = replace(one, solver="low", value=value, status=Status.STALLED)
    near = replace(one, solver="near", value=value * (1 + 5e-7), status=Status.CONVERGED)
    far = replace(one, solver="far", value=value * (1 + 5e-6), status=Status.CONVERGED)
    lowest = {("toy", s.solver): s for s in (low, near, far)}
    assert best("toy", lowest).solver == "near"
    assert best("toy", {("toy", s.solver): s for s in (low, far)}).solver == "low"
    assert best("side", {**lowest, ("side", "x"): other}) is other


def test_a_finished_run_leaves_no_progress_file(tmp_path):
    run = begin(tmp_path)
    solutions = run.solve(1, {})
    assert (tmp_path / "progress.json").is_file()
    finish(run, solutions)
    assert not (tmp_path / "progress.json").exists()


def test_files_that_are_there_are_not_replaced(tmp_path):
    run = begin(tmp_path)
    solutions = run.solve(1, {})
    finish(run, solutions)
    before = snapshot(tmp_path)
    with pytest.raises(ValueError, match="exists; give another name"):
        finish(run, solutions)
    assert snapshot(tmp_path) == before


def test_equal_runs_give_equal_files(tmp_path):
    for name in "ab":
        run = begin(tmp_path / name)
        finish(run, run.solve(2, {}))
    one, other = snapshot(tmp_path / "a"), snapshot(tmp_path / "b")
    for name in one.keys() - {"result.json", "report.html"}:  # they tell how long it took
        assert one[name] == other[name]
    results = [read_result(tmp_path / name) for name in "ab"]
    plain = [result.model_copy(update={"seconds": 0.0, "solutions": []}) for result in results]
    assert plain[0].to_json() == plain[1].to_json()
    for pair in zip(*(result.solutions for result in results), strict=True):
        assert len({s.model_copy(update={"seconds": 0.0}).model_dump_json() for s in pair}) == 1
