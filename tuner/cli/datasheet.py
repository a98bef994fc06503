"""The declarations of a filter, as tables for people, as JSON and as a page."""

import inspect
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from typing import Any, Literal, NamedTuple, get_args, get_origin, get_type_hints

from filters import Channel, Param, channel_facts, optional, parameter_facts


class Option(NamedTuple):
    """A choice that is made as the filter is: one of some words, and its default."""

    words: tuple[Any, ...]
    default: Any


class Grid(NamedTuple):
    """A table: its title, and lines of cells, the first of which are the heads."""

    title: str
    lines: list[list[str]]


@dataclass(frozen=True)
class Datasheet:
    """The facts of one filter.

    Attributes:
        name: on the command line.
        home: where the class is, module and name.
        about: the first line of its docstring.
        inputs: by name, as are all below.
        optional: the inputs that it can do without.
        parameters: what may be tuned.
        states: what it keeps.
        outputs: what it returns.
        derived: numbers that follow from the parameters.
        options: fields of the class that are one of some words.
    """

    name: str
    home: str
    about: str
    inputs: Mapping[str, Channel]
    optional: frozenset[str]
    parameters: Mapping[str, Param]
    states: Mapping[str, Channel]
    outputs: Mapping[str, Channel]
    derived: Mapping[str, Param]
    options: Mapping[str, Option]


def datasheet_of(name: str, filter: type[Any], home: str = "") -> Datasheet:
    """The facts of a filter's class.

    Args:
        name: what it is called.
        filter: the class.
        home: the file that it is from; "" for one of a package.

    Raises:
        ValueError: where it declares none.
    """
    return Datasheet(
        name=name,
        home=home or f"{filter.__module__}.{filter.__name__}",
        about=first_line(filter),
        inputs=channel_facts(filter, "inputs"),
        optional=optional(filter),
        parameters=parameter_facts(filter),
        states=channel_facts(filter, "states"),
        outputs=channel_facts(filter, "outputs"),
        derived=dict(getattr(filter, "derived", {})),
        options=_options(filter),
    )


def first_line(thing: Any) -> str:
    """The first line of a docstring, "" without one."""
    return (inspect.getdoc(thing) or "").partition("\n")[0]


def grids(sheet: Datasheet) -> list[Grid]:
    """The tables of a sheet; those that would be empty are left out."""
    inputs = [[*line, _may(name, sheet)] for name, line in _channels(sheet.inputs).items()]
    all_ = [
        Grid("Inputs", [[*_CHANNEL, "needed"], *inputs]),
        Grid("Parameters", [_PARAM, *map(_param, sheet.parameters.items())]),
        Grid("States", [_CHANNEL, *_channels(sheet.states).values()]),
        Grid("Outputs", [_CHANNEL, *_channels(sheet.outputs).values()]),
        Grid("Derived", [_DERIVED, *([n, f.unit, f.meaning] for n, f in sheet.derived.items())]),
        Grid("Options", [_OPTION, *map(_option, sheet.options.items())]),
    ]
    return [grid for grid in all_ if len(grid.lines) > 1]


def as_json(sheet: Datasheet) -> dict[str, Any]:
    """A sheet as JSON holds it."""
    parts = {
        part: {name: fact._asdict() for name, fact in getattr(sheet, part).items()}
        for part in ("inputs", "parameters", "states", "outputs", "derived", "options")
    }
    for name, fact in parts["inputs"].items():
        fact["optional"] = name in sheet.optional
    return {"class": sheet.home, "about": sheet.about, **parts}


def page(sheets: Iterable[Datasheet]) -> str:
    """The page of several filters, in Markdown."""
    begun = (
        "# Filters\n\nMade by `tuner list filters --md` from what the filters declare about "
        "themselves.\nIn units, `unit` stands for that of the measurement.\n"
    )
    return "".join([begun, *map(_section, sheets)])


_CHANNEL = ["name", "unit", "axes", "kind", "meaning"]
_PARAM = ["name", "unit", "typical", "range", "meaning", "smaller", "larger"]
_DERIVED = ["name", "unit", "meaning"]
_OPTION = ["name", "words", "default"]


def _channels(facts: Mapping[str, Channel]) -> dict[str, list[str]]:
    return {
        name: [name, fact.unit, " ".join(fact.axes), fact.kind, fact.meaning]
        for name, fact in facts.items()
    }


def _may(name: str, sheet: Datasheet) -> str:
    return "no" if name in sheet.optional else "yes"


def _param(item: tuple[str, Param]) -> list[str]:
    name, fact = item
    tuned = fact.low is not None and fact.high is not None
    limits = f"{fact.low:g} to {fact.high:g}" if tuned else "not tuned"
    return [name, fact.unit, _number(fact.typical), limits, fact.meaning, fact.smaller, fact.larger]


def _number(value: Any) -> str:
    """A number, or nested tuples of them."""
    if isinstance(value, tuple):
        return f"({', '.join(map(_number, value))})"
    return f"{value:g}"


def _options(filter: type[Any]) -> dict[str, Option]:
    if not is_dataclass(filter):
        return {}
    hints = get_type_hints(filter)
    return {
        field.name: Option(get_args(hints[field.name]), _default(field))
        for field in fields(filter)
        if get_origin(hints[field.name]) is Literal
    }


def _default(field: Any) -> Any:
    return None if field.default is MISSING else field.default


def _option(item: tuple[str, Option]) -> list[str]:
    name, option = item
    default = "" if option.default is None else str(option.default)
    return [name, ", ".join(map(str, option.words)), default]


def _section(sheet: Datasheet) -> str:
    head = f"\n## {sheet.name}\n\n`{sheet.home}`: {sheet.about}\n"
    return head + "".join(map(_table, grids(sheet)))


def _table(grid: Grid) -> str:
    head, *lines = [[cell.replace("|", r"\|") for cell in line] for line in grid.lines]
    rows = [[grid.title.lower(), *head[1:]], ["---"] * len(head), *lines]
    return "\n" + "".join(f"| {' | '.join(row)} |\n" for row in rows)
