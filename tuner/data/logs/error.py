"""The error of this package, and the words its sentences share."""

import difflib
from collections.abc import Iterable, Sequence

FEW = 12


class LogError(ValueError):
    """Bad input, told in one sentence: what is wrong, where, and the way out.

    Example:
        >>> raise LogError("flight.csv: the file is empty; record the log again")
        Traceback (most recent call last):
        tuner.data.logs.error.LogError: flight.csv: the file is empty; record the log again
    """


def quoted(names: Iterable[str]) -> str:
    """The names in quotes, always on one line.

    Example:
        >>> quoted(["t", "omega"])
        "'t', 'omega'"
    """
    return ", ".join(map(repr, names))


def suggest(name: str, known: Sequence[str]) -> str:
    """The names that could have been meant: all where they are few, else the near ones.

    Example:
        >>> suggest("omga", ["omega", "theta"])
        "there are 'omega', 'theta'"
    """
    if not known:
        return "there are none"
    if len(known) <= FEW:
        return f"there are {quoted(known)}"
    folded = {other.lower(): other for other in known}
    near = difflib.get_close_matches(name.lower(), folded, n=5)
    if near:
        return f"near names are {quoted(folded[other] for other in near)}"
    return f"there are {quoted(known[:FEW])} and {len(known) - FEW} more"
