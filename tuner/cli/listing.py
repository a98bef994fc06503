"""tuner list: studies, filters, objectives, solvers and formats."""

import json as json_
from typing import Any

from tuner.catalogue import Group, find, names
from tuner.names import unknown


def show(what: str, name: str | None = None, *, json: bool = False, md: bool = False) -> None:
    """Print names with a line each, or the facts of one filter.

    Args:
        what: which list.
        name: of one filter; of a study, whose settings are listed.
        json: one JSON object.
        md: a Markdown page of the filter, or of all filters.

    Raises:
        ValueError: for anything that there is no list of, and for a name or a page of anything
            but filters.
    """
    if what not in _LISTS and what != "settings":
        raise unknown("list", what, [*_LISTS, "settings"])
    if what == "settings":
        from tuner.cli.listed_settings import show_settings

        show_settings(name, json=json, md=md)
        return
    if what != "filters" and (name is not None or md):
        option = "--md" if name is None else repr(name)
        raise ValueError(f"only filters have a page of facts; leave out {option}")
    if json and md:
        raise ValueError("--json and --md exclude each other; give one of them")
    if name is not None or md:
        _show_facts(names("tuner.filters") if name is None else [name], json=json, md=md)
        return
    _show_list(what, json)


def _show_list(what: str, json: bool) -> None:
    entries = _LISTS[what]()
    if json:
        _print_json({what: entries})
        return
    from tuner.cli.width import wrapped

    width = max(map(len, entries), default=0)
    for name, line in entries.items():
        print(wrapped(f"{name:{width}}  {line}", width + 2))


def _show_facts(names_: list[str], *, json: bool, md: bool) -> None:
    from tuner.cli.datasheet import as_json, datasheet_of, grids, page
    from tuner.run.filter_choice import choose_filter

    found = [choose_filter(name) for name in names_]
    sheets = [datasheet_of(each.name, each.cls, each.home) for each in found]
    if json:
        _print_json({"filters": {sheet.name: as_json(sheet) for sheet in sheets}})
        return
    if md:
        print(page(sheets), end="")
        return
    from tuner.cli.tables import show_grid

    for sheet in sheets:
        print(f"{sheet.name}: {sheet.about} ({sheet.home})\n")
        for grid in grids(sheet):
            show_grid(*grid)


def _print_json(entries: dict[str, Any]) -> None:
    print(json_.dumps({"schema": "tuner.list/1", **entries}, indent=1))


def _offered(group: Group) -> dict[str, str]:
    """The names of a group with a line each; what cannot be loaded says so in its line."""
    return {name: _line(group, name) for name in names(group)}


def _line(group: Group, name: str) -> str:
    from tuner.cli.datasheet import first_line

    try:
        thing = find(group, name)
    except ValueError as error:
        return str(error)
    return str(thing.title) if group == "tuner.studies" else first_line(thing)


def _studies() -> dict[str, str]:
    return _offered("tuner.studies")


def _filters() -> dict[str, str]:
    return _offered("tuner.filters")


def _objectives() -> dict[str, str]:
    return _offered("tuner.objectives")


def _solvers() -> dict[str, str]:
    from tuner.solvers import CONVEX, SOLVERS

    return SOLVERS | CONVEX


def _formats() -> dict[str, str]:
    from tuner.export import FORMATS
    from tuner.export.formats import about, suffix
    from tuner.firmware import TARGETS

    files = {name: f"*{suffix(name)}: {about(name)}" for name in FORMATS}
    return files | {t.name: f"{t.file}: {t.about}" for t in TARGETS.values()}


_LISTS = {
    "studies": _studies,
    "filters": _filters,
    "objectives": _objectives,
    "solvers": _solvers,
    "formats": _formats,
}
