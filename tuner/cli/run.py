"""tuner run: read the request, solve, and show what was found."""

import shlex
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import typer

from tuner.cli.filter_option import file_changes
from tuner.cli.interrupt import interruptible
from tuner.cli.listed_settings import facts
from tuner.cli.progress_display import show_planning, show_progress
from tuner.cli.request import Request, from_toml, load_records, log_entries, threads
from tuner.cli.settings import parse_settings
from tuner.data.record import Record
from tuner.export import FORMATS
from tuner.names import counted
from tuner.problem.problem import Problem
from tuner.report.report_json import kept_facts
from tuner.run.cache import use_cache
from tuner.run.folder import RunFolder, open_folder
from tuner.run.identity import identity_of_run
from tuner.run.pipeline import Run, trusted, write_down
from tuner.run.progress_file import read_progress, resumed_solutions
from tuner.run.recipe import Recipe
from tuner.run.result import Result
from tuner.run.shared_run import Together, workers
from tuner.run.sharing import shared_plan
from tuner.run.study import Plan, Solutions, Study, find_study
from tuner.stop import NOTHING, code_of
from tuner.stored_programs import as_last_time
from tuner.trials.database import DatabaseError, use_database, without_password

SHOWN = 3
"""How many of several recordings are described."""


def execute(request: Request) -> int:
    """Run a study; 0 if every problem has a solution that converged, otherwise 1."""
    begun = time.perf_counter()
    use_cache()
    request, base = from_toml(request)
    with as_last_time("run", *_known_at_once(request)):
        return _executed(request, base, begun)


def _known_at_once(request: Request) -> list[str]:
    """What a run's programs may follow from, as far as it is known before anything is read."""
    sizes = [file.stat().st_size if file.is_file() else 0 for file in request.logs]
    option = request.filter_option
    said = option.filter, option.model, sorted(request.values.items()), request.sets, sizes
    return [request.study, repr(said)]


def _executed(request: Request, base: dict[str, Any], begun: float) -> int:
    study = find_study(request.study)
    values = base | dict(request.values) | request.filter_option.settings()
    settings = parse_settings(study.settings, request.sets, values)
    seed = request.seed or 0
    records = load_records(study, settings, request)
    describe(records)
    for note in file_changes(base, request.filter_option):
        print(note, file=sys.stderr)
    if request.dry_run:
        plan = _chosen(study.plan(settings, records, seed, ""), request)
        _say_notes(plan)
        _say_plan(study, plan)
        return 0
    folder = open_folder(request.out, study.name, force=request.force, resume=request.resume)
    storage = request.storage or _own_database(folder)
    with show_planning():
        plan = _chosen(study.plan(settings, records, seed, storage), request)
        plan = shared_plan(plan, storage) if _is_shared(request) else plan
    _say_notes(plan)
    values = settings.model_dump(mode="json")
    recipe = Recipe.of(
        study.name,
        settings,
        seed=seed,
        log=log_entries(request, records),
        claims=request.claims,
    )
    identity = identity_of_run(study, recipe, plan)
    kept = kept_facts(study.title, study.paper, plan.notes, records)
    with interruptible() as check, show_progress(check) as progress:
        run = Run(study.name, values, plan, seed, folder, progress, request.claims, identity, kept)
        try:
            solutions, result = _solve_and_write(run, request, recipe, begun, study.takes)
        except KeyboardInterrupt as stopped:
            # On a line of its own the command can be copied as a whole.
            how = [f"{_GO_ON}:\n{again}" for again in _again(request, folder)] or [NOTHING]
            print(f"tuner: {how[0]}", file=sys.stderr)
            return code_of(stopped)
        except DatabaseError as error:
            how = [f"{_GO_ON}: {again}" for again in _again(request, folder)]
            raise ValueError("; ".join([str(error), *how])) from None
    with _all_is_saved(folder):
        _show(result, folder, request)
    return 0 if trusted(plan, solutions) else 1


def _solve_and_write(
    run: Run, request: Request, recipe: Recipe, begun: float, takes: str
) -> tuple[Solutions, Result]:
    """Check, solve and write a run, or go on with it."""
    finished = _finished(run.folder, recipe, run) if request.resume else {}
    run.check(threads(request))
    if takes and not request.claims:
        print(f"{run.study} takes about {takes} on two processors", file=sys.stderr)
    if request.storage:
        use_database(request.storage)
    if request.force and not request.resume:
        run.folder.clear()
    with _found_or_removed(run.folder, request):
        write_down(run.folder, recipe, run.plan)
        solutions = _solve(run, request, recipe, finished)
        return solutions, run.finish(solutions, FORMATS, begun)


@contextmanager
def _found_or_removed(folder: RunFolder, request: Request) -> Iterator[None]:
    """Remove what is written meanwhile of a run that fails before anything was found."""
    try:
        yield
    except DatabaseError:  # which may come back, with all its trials
        raise
    except Exception:
        if not (request.resume or (folder.path / "trials.sqlite3").exists() or _found(folder)):
            folder.clear()
            if request.out is None:
                with suppress(OSError):  # others ran as well
                    folder.path.parent.rmdir()
        raise


def _found(folder: RunFolder) -> bool:
    """Whether anything is kept that a run may go on with."""
    try:
        return bool(read_progress((folder.path / "progress.json").read_bytes()).finished)
    except (OSError, ValueError):
        return False


@contextmanager
def _all_is_saved(folder: RunFolder) -> Iterator[None]:
    """Say so where someone interrupts what is only shown."""
    try:
        yield
    except KeyboardInterrupt as stopped:
        print(f"tuner: interrupted; all is saved in {folder.path}", file=sys.stderr)
        raise typer.Exit(code_of(stopped)) from None


def _show(result: Result, folder: RunFolder, request: Request) -> None:
    for missing in result.not_drawn:
        print(missing, file=sys.stderr)
    if request.json:
        print(result.to_json(), end="")
    else:
        from tuner.cli.tables import show_result

        show_result(result, folder.path, whole=False)


def describe(records: tuple[Record, ...]) -> None:
    """Say on stderr what was found in recordings."""
    for record in records[:SHOWN]:
        print("\n".join(record.describe()), file=sys.stderr)
    if len(records) > SHOWN:
        print(f"... and {counted(len(records) - SHOWN, 'more recording')}", file=sys.stderr)


def _chosen(plan: Plan, request: Request) -> Plan:
    """The whole plan, or what the claims that are asked for take."""
    return plan.only(request.claims) if request.claims else plan


def _finished(folder: RunFolder, recipe: Recipe, run: Run) -> Solutions:
    """The finished parts of an interrupted run of this very recipe.

    Raises:
        ValueError: where the folder holds another run, or data or code have changed.
    """
    if (folder.path / "study.toml").read_bytes() != recipe.to_toml():
        raise ValueError(
            f"--resume: {folder.path / 'study.toml'} has other settings or claims, another seed or "
            "log; run that file, or start again in another folder"
        )
    progress = folder.path / "progress.json"
    # A run that was interrupted as it began has written none.
    if not progress.exists():
        return {}
    return resumed_solutions(read_progress(progress.read_bytes()), run.identity, run.plan.tasks)


def _solve(run: Run, request: Request, recipe: Recipe, finished: Solutions) -> Solutions:
    """In threads of this process, or together with others by a database."""
    if not _is_shared(request) or not run.plan.tasks:
        return run.solve(threads(request), finished)
    url = request.storage or _own_database(run.folder)
    together = Together.of(url, run.study, recipe.to_toml(), run.identity, run.plan)
    if request.storage is not None:
        where = shlex.quote(without_password(url))
        print(
            f"other machines join with: tuner worker --storage {where} --study {together.name}",
            file=sys.stderr,
        )
    words = [word for log in request.logs for word in ("--log", str(log))]
    if request.filter_option.file is not None:
        words += ["--filter", str(request.filter_option.filter)]
    with workers((request.jobs or 1) - 1, url, together.name, words):
        return run.solve_together(together, finished)


def _is_shared(request: Request) -> bool:
    """Whether other processes may work on the run."""
    return request.storage is not None or (request.jobs or 1) > 1


def _own_database(folder: RunFolder) -> str:
    return f"sqlite:///{folder.path / 'trials.sqlite3'}"


_GO_ON = "finished parts are saved; go on with"


def _again(request: Request, folder: RunFolder) -> Iterator[str]:
    """The command that goes on with what is saved, where anything is."""
    if not (folder.path / "study.toml").exists():
        return
    words = ["tuner", "run", str(folder.path / "study.toml"), "--out", str(folder.path)]
    words += [word for log in request.logs for word in ("--log", str(log))]
    if request.filter_option.file is not None:
        words += ["--filter", str(request.filter_option.filter)]
    # The database's address may hold a password: it is not repeated.
    yield shlex.join([*words, "--resume"]) + (" --storage ..." if request.storage else "")


def _say_notes(plan: Plan) -> None:
    for note in plan.notes:
        print(note, file=sys.stderr)


def _say_plan(study: Study, plan: Plan) -> None:
    source = plan.source
    print(f"{study.name}: {study.title}")
    for words in facts(study):
        print(words)
    amount = f", {source.samples} samples at {source.rate_hz:g} Hz" if source.samples else ""
    print(f"data: {source.name}{amount}")
    for task in plan.tasks:
        free = ""
        if isinstance(task.problem, Problem):
            free = f" over {', '.join(task.problem.space.coordinates)}"
        print(f"would solve {task.problem.name}{free} by {task.solver.name}")
    if plan.claims:
        print(f"would try {', '.join(claim.name for claim in plan.claims)}")
