"""A tuned filter as plain mappings and lists, which every format writes and reads."""

import reprlib
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any, TypeAlias

from tuner.export.tuned import Provenance, Quantity, Tuned

SCHEMA = "tuner.tuned/1"

Document: TypeAlias = dict[str, Any]

_SOURCE = [field.name for field in fields(Provenance) if field.name != "versions"]
_HEAD = ["schema", "name", "filter", "convention", "dt", "states", "versions", "provenance"]
_INNER = "provenance."


def head(tuned: Tuned) -> Document:
    """The document's head: everything but the quantities."""
    return {
        "schema": SCHEMA,
        "name": tuned.name,
        "filter": tuned.filter,
        "convention": tuned.convention,
        "dt": tuned.dt,
        "states": list(tuned.states),
        "versions": dict(tuned.provenance.versions),
        "provenance": {name: getattr(tuned.provenance, name) for name in _SOURCE},
    }


def label(quantity: Quantity) -> Document:
    """The label of a quantity: everything but its numbers."""
    return {
        "name": quantity.name,
        "unit": quantity.unit,
        "meaning": quantity.meaning,
        "shape": list(quantity.value.shape),
    }


def tuned_from(head: object, quantities: Iterable[Quantity]) -> Tuned:
    """The fields from which :func:`head` was made.

    Raises:
        ValueError: one sentence, where the head is invalid.
    """
    given = mapping("the head", head, _HEAD)
    if given["schema"] != SCHEMA:
        raise ValueError(f"its schema is {reprlib.repr(given['schema'])} and not {SCHEMA!r}")
    source = mapping("the provenance", given["provenance"], _SOURCE)
    versions = mapping("the list of versions", given["versions"])
    return Tuned(
        name=given["name"],
        filter=given["filter"],
        quantities=tuple(quantities),
        convention=given["convention"],
        dt=given["dt"],
        states=tuple(sequence("the list of states", given["states"])),
        provenance=Provenance(**source, versions=tuple(versions.items())),
    )


def flat(head: Document) -> Document:
    """The head on one level, for formats of lines: ``provenance.seed`` and so on."""
    inner = {_INNER + key: value for key, value in head["provenance"].items()}
    return {key: value for key, value in head.items() if key != "provenance"} | inner


def nested(lines: Mapping[str, Any]) -> Document:
    """The inverse of :func:`flat`.

    >>> nested({"name": "gyro", "provenance.seed": 7})
    {'name': 'gyro', 'provenance': {'seed': 7}}
    """
    inner = {key: value for key, value in lines.items() if key.startswith(_INNER)}
    outer = {key: value for key, value in lines.items() if key not in inner}
    return outer | {"provenance": {key.removeprefix(_INNER): inner[key] for key in inner}}


def mapping(what: str, given: object, keys: Iterable[str] | None = None) -> Document:
    """The value, if it is a mapping with exactly these keys."""
    if not isinstance(given, dict):
        raise ValueError(f"{what} is missing or not a mapping")
    known = set(given if keys is None else keys)
    for verb, odd in (("lacks", known - given.keys()), ("should not have", given.keys() - known)):
        if odd:
            raise ValueError(f"{what} {verb} {', '.join(sorted(map(repr, odd)))}")
    return given


def sequence(what: str, given: object) -> list[Any]:
    """The value, if it is a list."""
    if not isinstance(given, list):
        raise ValueError(f"{what} is missing or not a list")
    return given
