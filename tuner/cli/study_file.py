"""A study.toml checked as a whole: all that is wrong with it in one sentence."""

from collections.abc import Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from tuner.cli.settings import settings_faults
from tuner.names import listed
from tuner.run.recipe import Recipe, faults_of
from tuner.run.study import find_study


def read_study_file(path: Path, document: Mapping[str, Any], more: Mapping[str, Any]) -> Recipe:
    """The recipe in a file, whose settings the command line may have more of.

    Args:
        path: the file.
        document: what it holds.
        more: settings of the command line, which win.

    Raises:
        ValueError: with everything that is wrong in the file, near names included.
    """
    try:
        recipe = Recipe.model_validate(document)
    except ValidationError as error:
        found = listed(chain(faults_of(error), _of_settings(document, more)))
        raise ValueError(f"{path.name} is not a study.toml: {found}") from None
    if found := listed(_of_settings(document, more)):
        raise ValueError(f"{path.name}: {found}")
    return recipe


def _of_settings(document: Mapping[str, Any], more: Mapping[str, Any]) -> Iterator[str]:
    """The mistakes in the study's name, its settings and the columns that are mapped."""
    name, settings = document.get("study"), document.get("settings", {})
    if not isinstance(name, str) or not isinstance(settings, dict):
        return
    try:
        study = find_study(name)
    except ValueError as error:
        yield str(error)
        return
    merged, formed = {**settings, **more}, True
    for fault in settings_faults(study.settings, merged):
        formed = False
        yield fault
    if study.faults is None or not formed:
        return
    log = document.get("log")
    entries: list[Any] = [
        log.get(part) if isinstance(log, dict) else [] for part in ("map", "truth")
    ]
    maps, truths = (part if isinstance(part, list) else [] for part in entries)
    yield from study.faults(study.settings.model_validate(merged), maps, truths)
