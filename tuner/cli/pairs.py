"""NAME=VALUE options, in one sentence where they are wrong."""

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite
from typing import Any

from tuner.cli.settings import value_of

OF_FIT = ("held_out", "against")
"""Settings of the fit that ``--set`` takes beside the filter's options."""


def words(option: str, pairs: Iterable[str]) -> dict[str, Any]:
    """Values by name: numbers, true, [lists] as in TOML, or text.

    Raises:
        ValueError: for a pair without "=", and a name that is given twice.

    >>> words("--set", ["law=two-step", "every=4"])
    {'law': 'two-step', 'every': 4}
    """
    found: dict[str, Any] = {}
    for pair in pairs:
        name, equals, text = (part.strip() for part in pair.partition("="))
        if not (name and equals and text):
            raise ValueError(f"{option} {pair} has no value; write {option} NAME=VALUE")
        if name in found:
            raise ValueError(f"{option} names {name} twice; name it once")
        found[name] = value_of(text)
    return found


def wishes(options: Mapping[str, Any]) -> dict[str, Any]:
    """The settings of a fit that its options on the command line say.

    Raises:
        ValueError: as the functions below, for what is no NAME=VALUE.
    """
    own, settings = apart(words("--set", options["options"] or ()))
    first, settings = two_at_most(options["objective"] or (), settings)
    return {
        "start": numbers("--start", options["start"] or ()),
        "fix": numbers("--fix", options["fix"] or ()),
        "bound": bounds("--bound", options["bound"] or ()),
        "options": own,
        "objective": first,
        **{name: options[name] for name in ("solver", "starts", "hold_out")},
        **settings,
    }


def apart(options: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The filter's own options, and settings of the fit that have no option of their own.

    >>> apart({"law": "two-step", "held_out": "time"})
    ({'law': 'two-step'}, {'held_out': 'time'})
    """
    settings = {name: value for name, value in options.items() if name in OF_FIT}
    return {name: value for name, value in options.items() if name not in OF_FIT}, settings


def two_at_most(
    objectives: Sequence[str], settings: Mapping[str, Any]
) -> tuple[str | None, dict[str, Any]]:
    """The objective, and the settings with a second one as what it is held against.

    Raises:
        ValueError: for more than two.

    >>> two_at_most(["rmse", "prediction"], {})
    ('rmse', {'against': 'prediction'})
    """
    if len(objectives) + ("against" in settings) > 2:
        raise ValueError(
            f"--objective is given {len(objectives)} times, and a front has two objectives; "
            "give two at most"
        )
    second = {"against": objectives[1]} if len(objectives) == 2 else {}
    return (objectives[0] if objectives else None), {**settings, **second}


def numbers(option: str, pairs: Iterable[str]) -> dict[str, float]:
    """Finite numbers by name.

    Raises:
        ValueError: as :func:`words`, and for a value that is no finite number.

    >>> numbers("--start", ["q=4", "R=25"])
    {'q': 4.0, 'R': 25.0}
    """
    return {name: _number(option, name, value) for name, value in words(option, pairs).items()}


def bounds(option: str, pairs: Iterable[str]) -> dict[str, tuple[float, float]]:
    """Ranges LOW..HIGH by name.

    Raises:
        ValueError: for a name that is given twice, and what is no range of two rising numbers.

    >>> bounds("--bound", ["tau=0.1..10"])
    {'tau': (0.1, 10.0)}
    """
    found = {}
    for pair in pairs:
        name, _, text = (part.strip() for part in pair.partition("="))
        low, dots, high = (part.strip() for part in text.partition(".."))
        if not (name and dots and low and high):
            raise ValueError(f"{option} {pair} is no range; write {option} NAME=LOW..HIGH")
        if name in found:
            raise ValueError(f"{option} names {name} twice; name it once")
        ends = _number(option, name, value_of(low)), _number(option, name, value_of(high))
        if not ends[0] < ends[1]:
            raise ValueError(f"{option} {pair} does not rise; write the lower end first")
        found[name] = ends
    return found


def _number(option: str, name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise ValueError(f"{option} {name} is {value!r}; give a finite number")
    return float(value)
