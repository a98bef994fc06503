"""tuner list: studies, filters, objectives, solvers and formats."""

import inspect
import json as json_
from types import ModuleType

from tuner.names import unknown
from tuner.run.study import find_study, study_names


def show(what: str, json: bool) -> None:
    """Print names with a line each.

    Raises:
        ValueError: for anything that there is no list of.
    """
    if what not in _LISTS:
        raise unknown("list", what, _LISTS)
    entries = _LISTS[what]()
    if json:
        print(json_.dumps({"schema": "tuner.list/1", what: entries}, indent=1))
        return
    width = max(map(len, entries), default=0)
    for name, line in entries.items():
        print(f"{name:{width}}  {line}")


def _studies() -> dict[str, str]:
    return {name: find_study(name).title for name in study_names()}


def _filters() -> dict[str, str]:
    import filters

    return _classes(filters, "step")


def _objectives() -> dict[str, str]:
    import objectives

    return {n: line for n, line in _classes(objectives, "update").items() if n != "Fold"}


def _solvers() -> dict[str, str]:
    from tuner.solvers import CONVEX, SOLVERS

    return SOLVERS | CONVEX


def _formats() -> dict[str, str]:
    from tuner.export import FORMATS, suffix

    return {name: f"*{suffix(name)}" for name in FORMATS}


def _classes(module: ModuleType, method: str) -> dict[str, str]:
    """The concrete classes of a package that have a method, with their first line."""
    public = ((name, getattr(module, name)) for name in module.__all__)
    return {
        name: (inspect.getdoc(thing) or "").partition("\n")[0]
        for name, thing in public
        if inspect.isclass(thing)
        and hasattr(thing, method)
        and hasattr(thing, "__dataclass_fields__")
    }


_LISTS = {
    "studies": _studies,
    "filters": _filters,
    "objectives": _objectives,
    "solvers": _solvers,
    "formats": _formats,
}
