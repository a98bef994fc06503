"""Words of messages: numbers of things, lists of faults, unknown names with the near ones."""

import difflib
from collections.abc import Iterable
from itertools import islice

MOST = 12
"""Largest number of faults that are listed."""


def counted(number: int, noun: str) -> str:
    """A number of things.

    >>> counted(1, "row"), counted(2, "row")
    ('1 row', '2 rows')
    """
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def listed(faults: Iterable[str]) -> str:
    """Faults in one sentence, each once; of very many, the first ones.

    >>> listed(["a is no number", "b is missing", "b is missing"])
    'a is no number; b is missing'
    """
    rest = iter(faults)
    first = [*dict.fromkeys(islice(rest, MOST))]
    more = [] if next(rest, None) is None else ["and more"]
    return "; ".join([*first, *more])


def unknown(kind: str, name: str, known: Iterable[str]) -> ValueError:
    """The error for a name that is not among the known ones.

    >>> str(unknown("solver", "neldermead", ["nelder-mead", "tpe"]))
    "unknown solver 'neldermead'; did you mean nelder-mead? There are: nelder-mead, tpe"
    """
    names = sorted(known)
    near = difflib.get_close_matches(name, names, n=3)
    hint = f"did you mean {' or '.join(near)}? " if near else ""
    there = f"here are: {', '.join(names)}" if names else "here are none"
    return ValueError(f"unknown {kind} {name!r}; {hint}{'T' if hint else 't'}{there}")
