"""tuner worker: work on a run of another process, here or on another machine."""

import _thread
import sys
import threading
import tomllib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from tuner.cli.filter_option import FilterOption, refuse_code
from tuner.cli.interrupt import interruptible
from tuner.cli.request import Request, load_records
from tuner.cli.settings import parse_settings
from tuner.run.cache import use_cache
from tuner.run.identity import WHAT, identity_of_run
from tuner.run.recipe import LogEntries, Recipe, logs_beside
from tuner.run.shared_run import Together, facts_of, workers
from tuner.run.sharing import shared_plan
from tuner.run.study import find_study
from tuner.stop import code_of


@dataclass(frozen=True)
class Worker:
    """The request to a worker.

    Attributes:
        storage: URL of the database.
        study: name of the run in it.
        logs: the recordings, where they are not in this folder.
        filter_option: the filter's file, where the run is of one.
        jobs: processes on this machine.
        leashed: whether it ends with the process that started it.
    """

    storage: str
    study: str
    logs: tuple[Path, ...] = ()
    filter_option: FilterOption = field(default_factory=FilterOption)
    jobs: int = 1
    leashed: bool = False


def execute(worker: Worker) -> int:
    """Work until the run is solved; 0 then, 130 after Ctrl-C."""
    use_cache()
    run = joined(worker)
    words = [word for log in worker.logs for word in ("--log", str(log))]
    if worker.filter_option.filter is not None:
        words += ["--filter", worker.filter_option.filter]
    try:
        with ExitStack() as stack:
            check = stack.enter_context(interruptible())
            if worker.leashed:
                stack.enter_context(_leash())
            else:
                print(f"working on {run.name}, {len(run.tasks)} problems", file=sys.stderr)
            stack.enter_context(workers(worker.jobs - 1, run.url, run.name, words))
            run.work(lambda _: check())
    except KeyboardInterrupt as stopped:
        if not worker.leashed:
            print("tuner: interrupted; other processes continue this work", file=sys.stderr)
        return code_of(stopped)
    except ValueError:
        if not worker.leashed:
            raise
        return 2  # who holds the leash was refused as well, and says so
    return 0


def joined(worker: Worker) -> Together:
    """The run of a name, planned on this machine's data.

    Raises:
        ValueError: where there is no such run, it names code that nobody allowed, and where data
            or code of this machine differ from those of the run.
    """
    text, identity = facts_of(worker.storage, worker.study)
    document = tomllib.loads(text)
    command = f"tuner worker --study {worker.study}"
    refuse_code(document, worker.filter_option, Path(worker.study), command)
    recipe = Recipe.model_validate(document)
    study = find_study(recipe.study)
    settings = parse_settings(study.settings, (), recipe.settings | _allowed(worker.filter_option))
    logs = worker.logs
    if recipe.log is not None and not logs:
        logs = logs_beside(Path("study.toml"), recipe.log)
    request = Request(recipe.study, logs=logs, reading=recipe.log or LogEntries())
    records = load_records(study, settings, request)
    plan = study.plan(settings, records, recipe.seed, worker.storage)
    plan = plan.only(recipe.claims) if recipe.claims else plan
    own = identity_of_run(study, recipe, plan)
    # Settings are the run's own, by definition.
    if differing := [words for part, words in WHAT.items() if own[part] != identity.get(part)]:
        raise ValueError(
            f"this machine has {', '.join(differing)} than the run {worker.study}, and cannot "
            "work on it; use the same here"
        )
    plan = shared_plan(plan, worker.storage)
    return Together.of(worker.storage, study.name, text.encode(), identity, plan)


def _allowed(option: FilterOption) -> dict[str, object]:
    """The filter's file that a person named."""
    return {name: value for name, value in option.settings().items() if name == "filter"}


@contextmanager
def _leash() -> Iterator[None]:
    """End with the process that started this one: it holds the other end of stdin."""
    over = threading.Event()

    def wait() -> None:
        sys.stdin.buffer.read()
        if not over.is_set():
            _thread.interrupt_main()

    threading.Thread(target=wait, daemon=True).start()
    try:
        yield
    finally:
        over.set()
