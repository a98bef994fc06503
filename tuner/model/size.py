"""Limits of a document's size, far above any written by hand."""

from collections.abc import Mapping
from typing import Any

from tuner.model.findings import brief

LARGEST_FILE = 100_000
"""Bytes."""
MOST_ENTRIES, DEEPEST = 5_000, 6
MOST_CHARACTERS = 50_000
"""Characters of all texts in a document together."""


def check_size(document: Any, name: str) -> None:
    """Refuse a document that is not a table, or is too large.

    Raises:
        ValueError: where it has too much content, or is nested too deep.
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
                    f"{name} has more than {MOST_ENTRIES} entries, too many; give "
                    "names, matrices and expressions alone"
                )
            characters += sum(len(part) for part in inside if isinstance(part, str))
            below += [part for part in inside if isinstance(part, Mapping | list | tuple)]
        level = below
    if characters > MOST_CHARACTERS:
        raise ValueError(f"{name} has more than {MOST_CHARACTERS} characters of text; shorten it")
    if level:
        raise ValueError(f"{name} has tables or lists more than {DEEPEST} deep; flatten it")
