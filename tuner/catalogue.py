"""Studies, filters and objectives by name, from whichever installed packages offer them.

A package offers one by an entry point of one of the groups below; this package's own are found in
the same way.
"""

import sys
from collections.abc import Sequence
from functools import lru_cache
from importlib import metadata
from importlib.metadata import EntryPoint
from typing import Any, Literal, TypeAlias

from tuner.names import unknown

Group: TypeAlias = Literal["tuner.studies", "tuner.filters", "tuner.objectives"]
_KINDS = {"tuner.studies": "study", "tuner.filters": "filter", "tuner.objectives": "objective"}


def entry_points(group: Group) -> Sequence[EntryPoint]:
    """What packages offer in a group; their files are read once for a search path."""
    return _installed(group, tuple(sys.path))


@lru_cache
def _installed(group: Group, path: tuple[str, ...]) -> tuple[EntryPoint, ...]:
    return tuple(metadata.entry_points(group=group))


def names(group: Group) -> list[str]:
    """The names in a group, sorted; nothing of it is imported.

    >>> "local-level" in names("tuner.filters")
    True
    """
    return sorted({point.name for point in entry_points(group)})


def find(group: Group, name: str) -> Any:
    """The object of a name in a group, imported now.

    Raises:
        ValueError: for an unknown name, with the near ones; for one that packages offer for
            different things; and for one that cannot be imported.

    >>> find("tuner.filters", "madgwick").__name__
    'Madgwick'
    """
    offers = {point.value: point for point in entry_points(group) if point.name == name}
    if not offers:
        raise unknown(_KINDS[group], name, names(group))
    if len(offers) > 1:
        who = " and ".join(f"{point.value} of {_package(point)}" for point in offers.values())
        raise ValueError(f"the {_KINDS[group]} {name!r} is both {who}; uninstall one")
    (point,) = offers.values()
    try:
        return point.load()
    except Exception as error:  # another package's module can raise anything
        why = " ".join(f"{type(error).__name__}: {error}".split())
        raise ValueError(
            f"the {_KINDS[group]} {name!r} of {_package(point)} cannot be loaded from "
            f"{point.value} ({why}); mend that package or uninstall it"
        ) from error


def _package(point: EntryPoint) -> str:
    return point.dist.name if point.dist is not None else "an unknown package"
