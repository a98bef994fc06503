"""Which filter is meant: a name, a class, a class in a file, or a model in a text file."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

from tuner.catalogue import entry_points, find
from tuner.run.own_file import OwnFile, own_file


@dataclass(frozen=True)
class FilterChoice:
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


Model: TypeAlias = str | PathLike[str] | type[Any] | Mapping[str, Any] | FilterChoice
"""A name of ``tuner list filters``, FILE.py:CLASS, a class that declares its facts, the path of a
model in TOML, what such a file holds, or what was chosen before."""


def choose_filter(model: Model, sha256: str | None = None) -> FilterChoice:
    """The filter that is meant; a file of Python is run, for the caller names it.

    Args:
        model: what is meant.
        sha256: what the file of a class has to have; None: anything.

    Raises:
        ValueError: for an unknown name, a file that cannot be used or has another checksum, and a
            model with faults.

    >>> choose_filter("local-level").cls.__name__
    'LocalLevel'
    """
    if isinstance(model, FilterChoice):
        return model
    if isinstance(model, type):
        return _of_class(model)
    if isinstance(model, Mapping):
        from tuner.model import model_filter

        cls: type[Any] = model_filter(model)
        return FilterChoice(cls.__name__, cls, {"model": dict(model)})
    if not isinstance(model, str | PathLike):
        raise ValueError(_no_class(model))
    name = str(model)
    if name.endswith(".toml"):
        from tuner.model import read_model

        return replace(choose_filter(read_model(Path(name))), home=Path(name).name)
    file = own_file(name)
    if file is not None:
        settings = {"filter": name, "filter_sha256": file.sha256}
        return FilterChoice(file.name, file.load(sha256), settings, file.reference)
    return FilterChoice(name, find("tuner.filters", name), {"filter": name})


def _no_class(thing: Any) -> str:
    """Why something is no filter to be tuned."""
    cls = type(thing)
    if hasattr(thing, "step") and not hasattr(thing, "params"):
        return (
            f"{cls.__name__} declares no parameters, which are its model's; make a class of it and "
            "your build with filters.parametrised, or a Problem"
        )
    return f"{thing!r} is no filter's name or class; give {cls.__name__}"


def _of_class(cls: type[Any]) -> FilterChoice:
    """A class under the name that it has on the command line, if it has one there."""
    value = f"{cls.__module__}:{cls.__qualname__}"
    for point in entry_points("tuner.filters"):
        if point.value == value:
            return FilterChoice(point.name, cls, {"filter": point.name})
    file = _file_of(cls)
    checksum = {} if file is None else {"filter_sha256": file.sha256}
    name = cls.__name__ if file is None else f"{file.path}:{file.name}"
    return FilterChoice(cls.__name__, cls, {"filter": name, **checksum})


def _file_of(cls: type[Any]) -> OwnFile | None:
    """The Python file that a class is from; None of a notebook's, or one made by a function."""
    module = sys.modules.get(cls.__module__)
    if getattr(module, cls.__qualname__, None) is not cls:
        return None
    path = Path(getattr(module, "__file__", None) or "")
    return OwnFile(path, cls.__qualname__) if path.suffix == ".py" and path.is_file() else None
