"""How large a document may be: nothing that a person writes comes near."""

from collections.abc import Mapping
from typing import Any

from tuner.model.findings import brief

LARGEST_FILE = 100_000
"""Bytes."""
MOST_ENTRIES, DEEPEST = 5_000, 6
MOST_CHARACTERS = 50_000
"""Of all texts in a document together."""


def check_size(document: Any, name: str) -> None:
    """Refuse a document that is none, or is no size for one.

    Raises:
        ValueError: where it holds too much, or tables in tables in tables.
    """
    if not isinstance(document, Mapping):
        raise ValueError(f"{name} is {brief(document)}, and a model is a table")
    level: list[Any] = [document]
    entries = characters = 0
    for _ in range(DEEPEST):
        below: list[Any] = []
        for each in level:
            inside = [*each.keys(), *each.values()] if isinstance(each, Mapping) else each
            entries += len(inside)
            if entries > MOST_ENTRIES:
                raise ValueError(
                    f"{name} has more than {MOST_ENTRIES} entries, which is no model; give names, "
                    "matrices and expressions alone"
                )
            characters += sum(len(part) for part in inside if isinstance(part, str))
            below += [part for part in inside if isinstance(part, Mapping | list | tuple)]
        level = below
    if characters > MOST_CHARACTERS:
        raise ValueError(f"{name} has more than {MOST_CHARACTERS} characters of text; shorten it")
    if level:
        raise ValueError(f"{name} has tables or lists more than {DEEPEST} deep, which is no model")
