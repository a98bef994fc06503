"""What was asked for on the command line, and the recordings that it names."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tuner.cli.recipe import LogEntries, logs_beside, read_recipe

if TYPE_CHECKING:
    from tuner.data.record import Record
    from tuner.run.study import Study


@dataclass(frozen=True)
class Request:
    """What was asked for on the command line; None where nothing was said."""

    study: str
    logs: tuple[Path, ...] = ()
    maps: tuple[str, ...] = ()
    truths: tuple[str, ...] = ()
    rate: float | None = None
    time: str | None = None
    by: str | None = None
    from_s: float | None = None
    to_s: float | None = None
    sets: tuple[str, ...] = ()
    values: Mapping[str, Any] = field(default_factory=dict)
    claims: tuple[str, ...] = ()
    out: Path | None = None
    seed: int | None = None
    storage: str | None = None
    jobs: int = 1
    resume: bool = False
    dry_run: bool = False
    force: bool = False
    json: bool = False


def from_toml(request: Request) -> tuple[Request, dict[str, Any]]:
    """Fill a request from a study.toml where one was named; the command line wins.

    Raises:
        ValueError: where the file is not one, names what a study.toml does not have, or a log
            that is not here.
    """
    path = Path(request.study)
    if path.suffix != ".toml":
        return request, {}
    recipe = read_recipe(path)
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
            maps=request.maps or tuple(recipe.log.map),
            truths=request.truths or tuple(recipe.log.truth),
            rate=recipe.log.rate_hz if request.rate is None else request.rate,
            time=recipe.log.time if request.time is None else request.time,
            by=recipe.log.by if request.by is None else request.by,
            from_s=recipe.log.from_s if request.from_s is None else request.from_s,
            to_s=recipe.log.to_s if request.to_s is None else request.to_s,
        )
    return filled, recipe.settings


def load_records(study: "Study", settings: Any, request: Request) -> "tuple[Record, ...]":
    """Read the recordings that a request names; none if it names none.

    Raises:
        ValueError: where the study takes none, or the request says how to read none.
    """
    if not request.logs:
        _refuse_stray(request)
        return ()
    if study.channels is None:
        raise ValueError(f"{study.name} takes no log")
    channels = study.channels(settings)
    if not request.maps:
        known = ", ".join(f"{name} ({fact.meaning})" for name, fact in channels.items())
        knows = f"knows {known}" if channels else "takes any NAME"
        raise ValueError(f"a log needs --map NAME=COLUMN; {study.name} {knows}")
    from tuner.data.reading import read_records

    return read_records(
        request.logs,
        request.maps,
        truth=request.truths,
        inputs=channels or None,
        outputs={} if study.truths is None else study.truths(settings),
        rate_hz=request.rate,
        time=request.time,
        by=request.by,
        from_s=request.from_s,
        to_s=request.to_s,
    )


def _refuse_stray(request: Request) -> None:
    """Refuse options that say how to read a log where there is none."""
    told = {
        "--map": request.maps,
        "--truth": request.truths,
        "--rate": request.rate,
        "--time": request.time,
        "--by": request.by,
        "--from": request.from_s,
        "--to": request.to_s,
    }
    stray = [option for option, given in told.items() if given is not None and given != ()]
    if stray:
        raise ValueError(f"{stray[0]} says how to read a log, but there is no --log FILE")


def log_entries(request: Request, records: "tuple[Record, ...]") -> LogEntries | None:
    """The logs of a request as a recipe has them; None where there are none."""
    if not request.logs:
        return None
    digests = {part.name: part.sha256 for record in records for part in record.sources}
    names = [log.name for log in request.logs]
    return LogEntries(
        files=names,
        sha256=[digests[name] for name in names],
        map=list(request.maps),
        truth=list(request.truths),
        rate_hz=request.rate,
        time=request.time,
        by=request.by,
        from_s=request.from_s,
        to_s=request.to_s,
    )
