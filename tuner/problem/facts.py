"""Checks of a filter's class and its declarations."""

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from math import isfinite
from typing import Any, get_type_hints

import numpy as np

from filters import Channel, Param, channel_facts, parameter_facts
from filters.declared import declaration
from tuner.export.checks import require_name
from tuner.export.tuned import LONGEST_NAME, Quantity


def check_facts(cls: type[Any]) -> None:
    """Refuse a class that cannot be tuned: not a frozen dataclass, or facts with faults.

    Raises:
        ValueError: one sentence: the class, the part, what is wrong, and the way out.
    """
    check_frozen(cls)
    for part, kind in (("inputs", Channel), ("params", Param), ("outputs", Channel)):
        _check_declared(cls, part, kind)
    if not is_dataclass(cls):
        raise ValueError(
            f"{cls.__name__} is not a dataclass; write @dataclass(frozen=True) above the class"
        )
    if "dt" in vars(cls) and "dt" not in {each.name for each in fields(cls)}:
        raise ValueError(
            f"{cls.__name__}.dt is not a field, so every recording would be taken at that step; "
            "write dt: float"
        )
    require_name("a filter's class", cls.__name__, LONGEST_NAME)
    for name, fact in parameter_facts(cls).items():
        Quantity(name, np.zeros(()), "")  # which refuses a name that no export can hold
        for words in _faults(fact):
            raise ValueError(f"the facts of {name} in {cls.__name__} have {words}")
    for part in ("inputs", "outputs"):
        for name, channel in channel_facts(cls, part).items():  # type: ignore[arg-type]
            axes: object = channel.axes
            if not isinstance(axes, tuple) or len(set(axes)) < len(axes):
                raise ValueError(
                    f"the axes of {name} in {cls.__name__} are {channel.axes!r}; give a tuple of "
                    'names that differ, such as ("x", "y")'
                )


def check_frozen(cls: type[Any]) -> None:
    """Refuse a dataclass that is not frozen.

    Raises:
        ValueError: with the way out.
    """
    kinds = getattr(cls, "__dataclass_params__", None)
    if kinds is not None and not kinds.frozen:
        raise ValueError(
            f"{cls.__name__} is a dataclass that may change, so no compilation can be kept for it; "
            "write @dataclass(frozen=True)"
        )


def _check_declared(cls: type[Any], part: str, kind: type[Any]) -> None:
    """Refuse a part without facts, or with facts for some of its fields only."""
    try:
        declared = declaration(cls, part)
        if isinstance(declared, Mapping):
            if len(declared) != 1:
                raise ValueError(
                    f"{cls.__name__} declares {', '.join(declared)} of its {part} by a mapping, "
                    "which is for one Array alone; declare a NamedTuple"
                )
            return
        hints = get_type_hints(declared, include_extras=True)
    except NameError as error:
        raise ValueError(
            f"the annotations of {part} in {cls.__name__} cannot be read: {error}; import that "
            "name where the file is run, outside of if TYPE_CHECKING"
        ) from None
    for name, hint in hints.items():
        if not hasattr(hint, "__metadata__") and part == "params" and not _inner(hint):
            raise ValueError(
                f"{declared.__name__}.{name} says nothing about itself; write {name}: "
                f"Annotated[Array, {kind.__name__}(...)]"
            )


def _inner(hint: Any) -> bool:
    """Whether a hint is a tuple with facts of its own, or may be one."""
    ways = getattr(hint, "__args__", (hint,))
    return any(hasattr(way, "_fields") for way in ways)


def _faults(fact: Param) -> Iterator[str]:
    try:
        typical = np.asarray(fact.typical, float)
    except (TypeError, ValueError):
        yield f"the typical value {fact.typical!r}; give a number, or nested tuples of them"
        return
    if not np.isfinite(typical).all():
        yield f"the typical value {fact.typical}; give a finite number"
    if (fact.low is None) != (fact.high is None):
        yield f"a range from {fact.low} to {fact.high}; give both ends, or neither"
    if fact.low is None or fact.high is None:
        return
    if not (isfinite(fact.low) and isfinite(fact.high) and fact.low < fact.high):
        yield f"a range from {fact.low:g} to {fact.high:g}; give two finite ends that rise"
    elif not ((typical >= fact.low) & (typical <= fact.high)).all():
        ends = f"{fact.low:g} to {fact.high:g}"
        yield f"the typical value {fact.typical} outside its range {ends}; move one of them"
