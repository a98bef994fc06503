"""The identity of plain data: a text that is equal only for what computes the same."""

import sys
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache, partial
from types import FunctionType
from typing import Any, NamedTuple, TypeGuard

import jax
import numpy as np

from tuner.code_version import OURS

_LITERAL = (type(None), bool, int, complex, str, bytes, type(...))
_GENERATED = frozenset(vars(NamedTuple("Bare", [])))
"""What a class of named fields has without any code of its own."""


class NotPlainError(Exception):
    """Says what has no identity but itself, such as code that is not this package's."""


def described(thing: Any) -> str:
    """Plain data as text, to the bit: two texts are equal only where all that is in them is.

    Plain are numbers, words, arrays, and tuples, lists and dicts of such; classes and functions of
    this package by their names, for its source is known (:mod:`tuner.code_version`); and frozen
    dataclasses of such a class.

    Raises:
        NotPlainError: for anything else, such as a function of the user's own.

    >>> described((1, 0.1)) == described((1, np.nextafter(0.1, 1.0)))
    False
    """
    if type(thing) in _LITERAL:
        return f"{type(thing).__name__} {thing!r}"
    if type(thing) is float:
        return f"float {thing.hex()}"
    if isinstance(thing, np.ndarray | np.generic | jax.Array):
        return _array(np.asarray(thing))
    if isinstance(thing, type):
        return _class(thing)
    return _composed(thing)


def _composed(thing: Any) -> str:
    kind: Any = type(thing)
    if isinstance(thing, FunctionType):
        found = _named(thing)
    elif isinstance(thing, partial):
        found = f"partial {described((thing.func, thing.args, thing.keywords))}"
    elif isinstance(thing, Enum):
        found = f"{_class(kind)}.{thing.name}"
    elif is_value(thing):
        pairs = [(each.name, getattr(thing, each.name)) for each in fields(thing)]
        found = f"{_class(kind)}{described(pairs)}"
    elif kind in (tuple, list) or (isinstance(thing, tuple) and hasattr(thing, "_fields")):
        found = f"{_class(kind)}({', '.join(map(described, thing))})"
    elif kind is dict:
        found = f"dict{described([*thing.items()])}"
    elif kind is frozenset:
        found = f"frozenset({', '.join(sorted(map(described, thing)))})"
    else:
        raise NotPlainError(f"{kind.__name__} is no plain data")
    return found


def is_value(thing: Any) -> TypeGuard[Any]:
    """Whether it is an instance of a dataclass."""
    return is_dataclass(thing) and not isinstance(thing, type)


def _array(array: np.ndarray) -> str:
    if array.dtype.hasobject:
        raise NotPlainError("an array of objects is no plain data")
    return f"array {array.dtype.str} {array.shape} {array.tobytes().hex()}"


@cache
def _class(cls: Any) -> str:
    """A class by its name, by the call that makes it, or by its fields where it has no code."""
    if cls in (tuple, list):
        return str(cls.__name__)
    made: tuple[Any, ...] | None = vars(cls).get("made_by")
    if made is not None and made[0](*made[1:]) is cls:
        return f"{_named(made[0])}{described(made[1:])}"
    try:
        return _named(cls)
    except NotPlainError:
        names: tuple[str, ...] | None = getattr(cls, "_fields", None)
        if cls.__bases__ != (tuple,) or names is None or not _is_ours(cls):
            raise
        if vars(cls).keys() - _GENERATED - {*names, "__orig_bases__"}:
            raise
        return f"fields {cls.__name__}{names}"


def _named(thing: Any) -> str:
    """A class or a function of this package by its place."""
    found: Any = sys.modules.get(thing.__module__)
    for part in thing.__qualname__.split("."):
        found = getattr(found, part, None)
    if found is not thing or not _is_ours(thing):
        raise NotPlainError(f"{thing.__qualname__} is not this package's")
    return f"{thing.__module__}:{thing.__qualname__}"


def _is_ours(thing: Any) -> bool:
    return str(thing.__module__).partition(".")[0] in OURS
