"""A fit that was made in Python as a folder: the files that the command line writes."""

import hashlib
import io
import shutil
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic_core import PydanticSerializationError

from tuner.data.record import Record
from tuner.data.signal import Signal
from tuner.export import FORMATS
from tuner.report.report_json import kept_facts
from tuner.run.fit_study import STUDY, FitSettings
from tuner.run.folder import RunFolder
from tuner.run.identity import identity_of_run
from tuner.run.pipeline import Run, write_down
from tuner.run.recipe import LogEntries, Recipe
from tuner.run.study import Plan, Solutions


@dataclass(frozen=True, eq=False)
class Made:
    """How a fit came about, so that it can be written down.

    Attributes:
        settings: of the fit.
        seed: of its random numbers.
        plan: what was solved.
        solutions: of all of it.
        records: the recordings.
        seconds: how long it took.
    """

    settings: Mapping[str, Any]
    seed: int
    plan: Plan
    solutions: Solutions
    records: tuple[Record, ...]
    seconds: float


def save(made: Made, path: Path, *, force: bool) -> Path:
    """Write a fit's folder, whole or not at all, and return it.

    Recordings of arrays are written beside the recipe, which so can be run again.

    Args:
        made: the fit.
        path: the folder.
        force: whether files that are there may be replaced.

    Raises:
        ValueError: where the folder holds files and may not be touched, or settings cannot be
            written down.
    """
    if path.exists() and not (force and path.is_dir()):
        if not path.is_dir() or any(path.iterdir()):
            raise ValueError(
                f"{path} already exists; name another folder, or give force=True to replace "
                "its files"
            )
        path.rmdir()
    if path.is_dir():
        _write(made, RunFolder(path, overwrite=True))
        return path
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as kept:
        whole = Path(kept) / path.name
        _write(made, RunFolder(whole, overwrite=False))
        shutil.move(whole, path)
    return path


def _write(made: Made, folder: RunFolder) -> None:
    begun = time.perf_counter() - made.seconds
    log, files = log_of(made.records)
    settings = FitSettings.model_validate(dict(made.settings))
    try:
        recipe = Recipe.of(STUDY.name, settings, seed=made.seed, log=log)
        text = recipe.to_toml()
    except (PydanticSerializationError, TypeError) as error:
        raise ValueError(
            f"the settings of this fit cannot be written ({error}); give options of numbers, "
            "words and lists"
        ) from None
    assert text
    write_down(folder, recipe, made.plan)
    for name, data in files.items():
        folder.write(name, data)
    values = settings.model_dump(mode="json")
    identity = identity_of_run(STUDY, recipe, made.plan)
    kept = kept_facts(STUDY.title, STUDY.paper, made.plan.notes, made.records)
    run = Run(STUDY.name, values, made.plan, made.seed, folder, _quiet, (), identity, kept)
    run.finish(made.solutions, FORMATS, begun)


def log_of(records: tuple[Record, ...]) -> tuple[LogEntries | None, dict[str, bytes]]:
    """The recordings as a recipe has them, and files that hold those that were arrays.

    Nothing where recordings cannot be told so: several, each with channels on clocks of their own.
    """
    options = records[0].read_as
    if options is not None and all(record.read_as == options for record in records):
        files = {part.name: part.sha256 for record in records for part in record.sources}
        given = {name: value for name, value in options.items() if value is not None}
        known = {"files": [*files], "sha256": [*files.values()], **given}
        return LogEntries.model_validate(known), {}
    parts = [_by_clock(record) for record in records]
    if len(records) > 1 and any(len(each) > 1 for each in parts):
        return None, {}
    held = [signals for each in parts for signals in each]
    names = [f"recording{i + 1 if len(held) > 1 else ''}.npz" for i in range(len(held))]
    first = records[0]
    alone = all(len(each) == 1 for each in parts)
    data = {name: _archive(each, rated=alone) for name, each in zip(names, held, strict=True)}
    entries = {
        "files": names,
        "sha256": [hashlib.sha256(content).hexdigest() for content in data.values()],
        "map": [_mapping(name, signal) for name, signal in first.channels.items()],
        "truth": [_mapping(name, signal) for name, signal in first.truth.items()],
    }
    return LogEntries.model_validate(entries), data


def _mapping(name: str, signal: Signal) -> str:
    return f"{name}={name}:{signal.unit}" if signal.written else f"{name}={name}"


def _by_clock(record: Record) -> list[dict[str, Signal]]:
    """The channels and truths of a record, those of one clock together."""
    found: list[dict[str, Signal]] = []
    for name, signal in (*record.channels.items(), *record.truth.items()):
        for group in found:
            if np.array_equal(next(iter(group.values())).times, signal.times):
                group[name] = signal
                break
        else:
            found.append({name: signal})
    return found


def _archive(signals: Mapping[str, Signal], *, rated: bool) -> bytes:
    """Signals on one clock as a NPZ file: their times, or their rate where one tells them all.

    Args:
        signals: by name.
        rated: whether a rate may stand for times: files of one recording tell when each began.
    """
    first = next(iter(signals.values()))
    clock, samples = first.running, len(first.times)
    even = clock.even and np.array_equal(first.times, np.arange(samples) / clock.rate_hz)
    when = {"fs": np.asarray(clock.rate_hz)} if even and rated else {"t": first.times}
    stream = io.BytesIO()
    arrays = {name: signal.values for name, signal in signals.items()}
    np.savez_compressed(stream, allow_pickle=False, **when, **arrays)
    return stream.getvalue()


def _quiet(what: str, part: int, parts: int) -> None:
    """From Python nothing is told of progress."""
