"""Which filter is meant: a name, a class, a class in a file, or a model in a text file."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

from tuner.catalogue import find
from tuner.run.own_file import own_file


@dataclass(frozen=True)
class Chosen:
    """A filter that was chosen.

    Attributes:
        name: what it is called, in problems and messages.
        cls: its class, which declares its facts.
        settings: the settings of a fit that choose it: ``filter``, or ``model``.
        home: the file that it is from; "" for a name, or a class that was given.
    """

    name: str
    cls: type[Any]
    settings: Mapping[str, Any]
    home: str = ""


Model: TypeAlias = str | PathLike[str] | type[Any] | Mapping[str, Any] | Chosen
"""A name of ``tuner list filters``, FILE.py:CLASS, a class that declares its facts, the path of a
model in TOML, what such a file holds, or what was chosen before."""


def chosen(model: Model, sha256: str | None = None) -> Chosen:
    """The filter that is meant; a file of Python is run, for the caller names it.

    Args:
        model: what is meant.
        sha256: what the file of a class has to have; None: anything.

    Raises:
        ValueError: for an unknown name, a file that cannot be used or has another checksum, and a
            model with faults.

    >>> chosen("local-level").cls.__name__
    'LocalLevel'
    """
    if isinstance(model, Chosen):
        return model
    if isinstance(model, type):
        return Chosen(model.__name__, model, {"filter": model.__name__})
    if isinstance(model, Mapping):
        cls: type[Any] = models().model_filter(model)
        return Chosen(cls.__name__, cls, {"model": dict(model)})
    if not isinstance(model, str | PathLike):
        raise ValueError(f"{model!r} is no filter's name or class; give {type(model).__name__}")
    told = str(model)
    if told.endswith(".toml"):
        return replace(chosen(models().read_model(Path(told))), home=Path(told).name)
    file = own_file(told)
    if file is not None:
        settings = {"filter": told, "filter_sha256": file.sha256}
        return Chosen(file.name, file.load(sha256), settings, file.told)
    return Chosen(told, find("tuner.filters", told), {"filter": told})


def models() -> Any:
    """What makes filters of models, loaded when the first one is met."""
    return import_module("tuner.model")
