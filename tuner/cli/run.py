"""tuner run: read the request, solve, and show what was found."""

import json
import sys
import time
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tuner.cache import use_cache
from tuner.cli.settings import parse_settings
from tuner.environment import environment
from tuner.export import FORMATS
from tuner.folder import RunFolder, open_folder
from tuner.logs import Log, describe, parse_mapping, read_log
from tuner.result import pretty
from tuner.running import Progress, Run, recorded, trusted
from tuner.study import Plan, Study, find_study


@dataclass(frozen=True)
class Request:
    """What was asked for on the command line; None where nothing was said."""

    study: str
    log: Path | None
    maps: tuple[str, ...]
    rate: float | None
    time: str | None
    sets: tuple[str, ...]
    out: Path | None
    seed: int | None
    storage: str | None
    jobs: int
    resume: bool
    dry_run: bool
    force: bool
    json: bool


def execute(request: Request) -> int:
    """Run a study; 0 if every problem has a solution that converged, otherwise 1."""
    begun = time.perf_counter()
    use_cache()
    request, base = from_toml(request)
    study = find_study(request.study)
    settings = parse_settings(study.settings, request.sets, base)
    seed = request.seed or 0
    log = load_log(study, request)
    if log is not None:
        print("\n".join(describe(log)), file=sys.stderr)
    if request.dry_run:
        plan = study.plan(settings, log, seed, "")
        _say_plan(study, plan)
        return 0
    folder = open_folder(request.out, study.name, force=request.force, resume=request.resume)
    storage = request.storage or f"sqlite:///{folder.path / 'trials.sqlite3'}"
    plan = study.plan(settings, log, seed, storage)
    values = settings.model_dump(mode="json")
    _write_down(folder, study, request, values, plan)
    with _progress() as progress:
        run = Run(study, values, plan, seed, folder, progress)
        finished = recorded(json.loads(_partial(folder))) if request.resume else {}
        try:
            solutions = run.solve(request.jobs, finished)
            result = run.finish(solutions, FORMATS, begun)
        except KeyboardInterrupt:
            again = f"tuner run {folder.path / 'study.toml'} --out {folder.path} --resume"
            raise KeyboardInterrupt(f"finished parts are saved; go on with: {again}") from None
    if request.json:
        print(result.to_json(), end="")
    else:
        from tuner.cli.tables import show_result

        show_result(result, folder.path)
    return 0 if trusted(plan, solutions) else 1


def from_toml(request: Request) -> tuple[Request, dict[str, Any]]:
    """Fill a request from a study.toml where one was named; the command line wins.

    Raises:
        ValueError: where the file is not one, or names what a study.toml does not have.
    """
    path = Path(request.study)
    if path.suffix != ".toml":
        return request, {}
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
        log = found.get("log", {})
        strange = set(found) - {"study", "seed", "settings", "log"}
        strange |= set(log) - {"file", "sha256", "map", "rate_hz", "time"}
        if strange or "study" not in found:
            raise ValueError(
                f"unknown entries {', '.join(sorted(strange))}" if strange else "no study"
            )
    except FileNotFoundError:
        raise ValueError(f"{path} is not there; name a study or a study.toml") from None
    except (ValueError, AttributeError, TypeError) as error:
        raise ValueError(f"{path.name} is no study.toml: {error}") from None
    filled = replace(
        request,
        study=str(found["study"]),
        log=request.log or _beside(path, log),
        maps=request.maps or tuple(log.get("map", ())),
        rate=request.rate or log.get("rate_hz"),
        time=request.time or log.get("time"),
        seed=found.get("seed", 0) if request.seed is None else request.seed,
    )
    return filled, dict(found.get("settings", {}))


def _beside(path: Path, log: dict[str, Any]) -> Path | None:
    """The log that a study.toml names: in this folder, or beside it."""
    if "file" not in log:
        return None
    for folder in (Path(), path.parent):
        file = folder / str(log["file"])
        if file.is_file():
            return file
    raise ValueError(f"the log {log['file']} of {path} is not here; say where with --log FILE")


def load_log(study: Study, request: Request) -> Log | None:
    """Read the log that a request names, if it does.

    Raises:
        ValueError: where the study takes none, or the request says how to read none.
    """
    if request.log is None:
        stray = [n for n, given in (("--map", request.maps), ("--rate", request.rate)) if given]
        if stray:
            raise ValueError(f"{stray[0]} says how to read a log, but there is no --log FILE")
        return None
    if not study.channels:
        raise ValueError(f"{study.name} takes no log")
    if not request.maps:
        known = ", ".join(f"{name} ({what})" for name, what in study.channels.items())
        raise ValueError(f"--log needs --map NAME=COLUMN; {study.name} knows {known}")
    mappings = [parse_mapping(text, list(study.channels)) for text in request.maps]
    return read_log(request.log, mappings, rate_hz=request.rate, time=request.time)


def _write_down(
    folder: RunFolder, study: Study, request: Request, settings: dict[str, Any], plan: Plan
) -> None:
    """The run as a file that can be run again, and the environment it ran in; no absolute path."""
    import tomli_w

    resolved: dict[str, Any] = {"study": study.name, "seed": request.seed or 0}
    resolved["settings"] = {key: value for key, value in settings.items() if value is not None}
    if request.log is not None:
        log: dict[str, Any] = {
            "file": plan.source.name,
            "sha256": plan.source.sha256,
            "map": list(request.maps),
        }
        log |= {"rate_hz": request.rate} if request.rate else {}
        log |= {"time": request.time} if request.time else {}
        resolved["log"] = log
    folder.write("study.toml", tomli_w.dumps(resolved).encode())
    known = environment() | {"seed": request.seed or 0, "log_sha256": plan.source.sha256}
    folder.write("environment.json", pretty(known))


def _partial(folder: RunFolder) -> str:
    return (folder.path / "progress.json").read_text(encoding="utf-8")


def _say_plan(study: Study, plan: Plan) -> None:
    source = plan.source
    print(f"{study.name}: {study.title}")
    print(f"data: {source.name}, {source.samples} samples at {source.rate_hz:g} Hz")
    for task in plan.tasks:
        free = ", ".join(task.problem.space.coordinates)
        print(f"would solve {task.problem.name} over {free} by {task.solver_name}")


@contextmanager
def _progress() -> Iterator[Progress]:
    """A bar on stderr, from the first second on; nothing where stderr is no terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Bar(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        shown = bar.add_task("starting", total=1)

        def report(what: str, done: int, total: int) -> None:
            bar.update(shown, description=what, completed=done, total=total)

        yield report
