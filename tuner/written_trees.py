"""The structure of a result as text, with the classes of its tuples by their places."""

import sys
from collections.abc import Iterator
from dataclasses import fields
from typing import Any

import jax

from tuner.plain import NotPlainError, described, is_value

_FACTS = ("params", "inputs", "outputs")
"""Where a filter's class names those of its tuples."""


def written(tree: Any, static: Any) -> Any:
    """A structure of tuples, lists, dicts and None as JSON-able data.

    Args:
        tree: the structure, of ``jax.tree.structure``.
        static: the static arguments of the program, whose filters name classes of tuples.

    Raises:
        NotPlainError: for a structure with another kind of node.
    """
    return _written(jax.tree.unflatten(tree, range(tree.num_leaves)), static)


def read(data: Any, static: Any) -> Any:
    """The structure that :func:`written` has written.

    >>> tree = jax.tree.structure({"a": (1.0, None), "b": [2.0]})
    >>> read(written(tree, ()), ()) == tree
    True
    """
    return jax.tree.structure(_read(data, static))


def _written(node: Any, static: Any) -> Any:
    if node is None or type(node) is int:
        return node
    if type(node) is dict:
        return {"dict": [[key, _written(each, static)] for key, each in node.items()]}
    if type(node) in (tuple, list):
        return {type(node).__name__: [_written(each, static) for each in node]}
    if isinstance(node, tuple) and hasattr(node, "_fields"):
        return {"of": _place(type(node), static), "in": [_written(each, static) for each in node]}
    raise NotPlainError(f"a result with a {type(node).__name__} is not stored")


def _read(data: Any, static: Any) -> Any:
    if data is None or isinstance(data, int):
        return data
    if "of" in data:
        return _at(data["of"], static)(*(_read(each, static) for each in data["in"]))
    ((kind, inside),) = data.items()
    if kind == "dict":
        return {key: _read(each, static) for key, each in inside}
    found = [_read(each, static) for each in inside]
    return tuple(found) if kind == "tuple" else found


def _place(cls: type[Any], static: Any) -> list[Any]:
    """Where a class is found: in a module, or as a fact of a filter among the static arguments."""
    for number, home in enumerate(_classes(static)):
        for name in _FACTS:
            if getattr(home, name, None) is cls:
                return [number, name]
    described(cls)
    if getattr(sys.modules.get(cls.__module__), cls.__qualname__, None) is not cls:
        raise NotPlainError(f"{cls.__qualname__} has no place")
    return [cls.__module__, cls.__qualname__]


def _at(place: list[Any], static: Any) -> Any:
    home, name = place
    return getattr([*_classes(static)][home] if isinstance(home, int) else sys.modules[home], name)


def _classes(thing: Any) -> Iterator[type[Any]]:
    """The classes of all dataclasses in plain data, in order."""
    if is_value(thing):
        yield type(thing)
        for each in fields(thing):
            yield from _classes(getattr(thing, each.name))
    elif isinstance(thing, tuple | list):
        for one in thing:
            yield from _classes(one)
