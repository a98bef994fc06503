"""The settings of a study as a list: tuner list settings STUDY, and tuner run STUDY --help."""

import json as json_
from collections.abc import Iterator
from typing import Any, get_args, get_origin

from pydantic.fields import FieldInfo

from tuner.run.study import Study, find_study, study_names

_PLAIN = {float: "number", int: "integer", str: "text", bool: "true or false"}
_SIGNS = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}


def show_settings(name: str | None, *, json: bool = False, md: bool = False) -> None:
    """Print the settings of a study: its values, its default and its meaning.

    Raises:
        ValueError: without a study, and for one that there is none of.
    """
    if name is None:
        raise ValueError(f"settings belong to a study; name one: {', '.join(study_names())}")
    study = find_study(name)
    head, *rows = lines = [["setting", "values", "default", "meaning"], *_rows(study)]
    if json:
        entries = {row[0]: dict(zip(head[1:], row[1:], strict=True)) for row in rows}
        print(json_.dumps({"schema": "tuner.list/1", "settings": {study.name: entries}}, indent=1))
    elif md:
        body = [[cell.replace("|", "\\|") for cell in row] for row in lines]
        body.insert(1, ["---"] * len(head))
        print("\n".join(f"| {' | '.join(row)} |" for row in body))
    else:
        from tuner.cli.tables import show_grid

        show_grid(f"Settings of {study.name}, as --set NAME=VALUE", lines)
        for words in facts(study):
            print(words)


def facts(study: Study) -> Iterator[str]:
    """The data and the time that a study needs."""
    yield f"needs {study.needs}" if study.needs else "needs no data: it simulates them"
    if study.takes:
        yield f"takes about {study.takes} on two processors"


def _rows(study: Study) -> Iterator[list[str]]:
    for name, field in study.settings.model_fields.items():
        may = ", ".join([_kind(field.annotation), *_limits(field)])
        yield [name, may, _default(field), field.description or ""]


def _kind(annotation: Any) -> str:
    """A type in words.

    >>> from typing import Literal
    >>> _kind(float | None), _kind(tuple[int, ...]), _kind(bool)
    ('number', 'list of integers', 'true or false')
    >>> _kind(Literal["a", "b", "c"]), _kind(list[Literal["a", "b"]])
    ('a, b or c', 'list of any of a or b')
    >>> _kind(list[tuple[float, float]])
    'list of lists of numbers'
    """
    if annotation in _PLAIN:
        return _PLAIN[annotation]
    name, parts = getattr(get_origin(annotation), "__name__", ""), get_args(annotation)
    words = "table"
    if name == "Literal":
        *others, last = map(str, parts)
        words = f"{', '.join(others)} or {last}" if others else last
    elif name == "Annotated":
        words = _kind(parts[0])
    elif name in ("Union", "UnionType"):
        words = " or ".join(dict.fromkeys(_kind(p) for p in parts if p is not type(None)))
    elif name in ("tuple", "list"):
        inner = _kind(parts[0])
        if inner.startswith("list of "):
            words = f"list of {inner.replace('list', 'lists', 1)}"
        else:
            plain = inner in ("number", "integer", "text")
            words = f"list of {inner}s" if plain else f"list of any of {inner}"
    return words


def _limits(field: FieldInfo) -> Iterator[str]:
    for limit in field.metadata:
        for sign, words in _SIGNS.items():
            if hasattr(limit, sign):
                yield f"{words} {getattr(limit, sign):g}"


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    default = field.get_default(call_default_factory=True)
    if default is None or default == "":
        return "-"
    if isinstance(default, bool):
        return str(default).lower()
    return _value(default)


def _value(value: Any) -> str:
    """A value as ``--set`` takes it.

    >>> _value(((1.0, 0.5), (2.0, 3.0))), _value("phi")
    ('[[1, 0.5], [2, 3]]', 'phi')
    """
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_value, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)
