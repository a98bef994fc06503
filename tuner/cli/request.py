"""The request on the command line, and the recordings that it names."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from tuner.cli.filter_option import FilterOption, refuse_code
from tuner.cli.settings import settings_of
from tuner.cli.study_file import read_study_file
from tuner.run.recipe import LogEntries, logs_beside, read_document

if TYPE_CHECKING:
    from tuner.data.record import Record
    from tuner.run.study import Study


@dataclass(frozen=True)
class Request:
    """The request on the command line; None where nothing was said.

    Attributes:
        study: a study's name, or a study.toml.
        logs: the recordings.
        reading: how they are read.
        filter_option: the filter, where one is named.
        sets: settings as ``--set KEY=VALUE``.
        values: settings that have options of their own.
        claims: rows that are tried alone.
        out, seed, storage, jobs, resume, dry_run, force, json: as the options of these names.
    """

    study: str
    logs: tuple[Path, ...] = ()
    reading: LogEntries = field(default_factory=LogEntries)
    filter_option: FilterOption = field(default_factory=FilterOption)
    sets: tuple[str, ...] = ()
    values: Mapping[str, Any] = field(default_factory=dict)
    claims: tuple[str, ...] = ()
    out: Path | None = None
    seed: int | None = None
    storage: str | None = None
    jobs: int | None = None
    resume: bool = False
    dry_run: bool = False
    force: bool = False
    json: bool = False


def request_from(
    study: str, options: Mapping[str, Any], values: Mapping[str, Any] = MappingProxyType({})
) -> Request:
    """The request that a command's options make.

    Args:
        study: a study's name, or a study.toml.
        options: the command's options, by the names of its parameters.
        values: settings that are made of some of them.
    """
    how = ("out", "seed", "storage", "resume", "dry_run", "force", "json")
    return Request(
        study=study,
        logs=tuple(options.get("logs") or ()),
        reading=LogEntries.of_options(options),
        filter_option=FilterOption(options.get("filter"), options.get("model")),
        sets=tuple(options.get("sets") or ()),
        values=values,
        claims=tuple(options.get("claims") or ()),
        jobs=options.get("jobs"),
        **{name: options[name] for name in how if name in options},
    )


def from_toml(request: Request) -> tuple[Request, dict[str, Any]]:
    """Fill a request from a study.toml where one was named; the command line wins.

    Raises:
        ValueError: where the file is not one, names what a study.toml does not have, a log that is
            not here, or code to run.
    """
    path = Path(request.study)
    if path.suffix != ".toml":
        return request, {}
    document = read_document(path)
    refuse_code(document, request.filter_option, path, f"tuner run {path}")
    more = {**request.values, **request.filter_option.settings(), **settings_of(request.sets)}
    recipe = read_study_file(path, document, more)
    filled = replace(
        request,
        study=recipe.study,
        seed=recipe.seed if request.seed is None else request.seed,
        claims=request.claims or tuple(recipe.claims),
    )
    if recipe.log is not None:
        filled = replace(
            filled,
            logs=request.logs or logs_beside(path, recipe.log),
            reading=request.reading.over(recipe.log),
        )
    return filled, recipe.settings


def threads(request: Request) -> int:
    """How many problems one process solves at once."""
    return request.jobs or os.cpu_count() or 1


def load_records(study: "Study", settings: Any, request: Request) -> "tuple[Record, ...]":
    """Read the recordings that a request names; none if it names none.

    Raises:
        ValueError: where the study takes none, or the request says how to read none.
    """
    reading = request.reading
    if not request.logs:
        if reading.options:
            raise ValueError(
                f"{reading.options[0]} says how to read a log, but there is no --log FILE"
            )
        return ()
    if study.channels is None:
        raise ValueError(f"{study.name} takes no log")
    channels = study.channels(settings)
    if not reading.map:
        known = ", ".join(f"{name} ({fact.meaning})" for name, fact in channels.items())
        knows = f"knows {known}" if channels else "takes any NAME"
        raise ValueError(f"a log needs --map NAME=COLUMN; {study.name} {knows}")
    from tuner.data.reading import read_records

    return read_records(
        request.logs,
        reading.map,
        truth=reading.truth,
        inputs=channels or None,
        outputs={} if study.truths is None else study.truths(settings),
        rate_hz=reading.rate_hz,
        time=reading.time,
        by=reading.by,
        drop_repeats=bool(reading.drop_repeats),
        from_s=reading.from_s,
        to_s=reading.to_s,
    )


def log_entries(request: Request, records: "tuple[Record, ...]") -> LogEntries | None:
    """The logs of a request as a recipe has them; None where there are none."""
    if not request.logs:
        return None
    digests = {part.name: part.sha256 for record in records for part in record.sources}
    names = [log.name for log in request.logs]
    files = {"files": names, "sha256": [digests[name] for name in names]}
    return request.reading.model_copy(update=files)
