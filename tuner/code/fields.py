"""The fields of a filter's tuples as those of C structs: names, sizes, meanings."""

import inspect
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import jax
import numpy as np

from filters.declared import Channel, Param, bare, channel_facts, parameter_facts
from tuner.code.names import identifier
from tuner.code.operations import Kind, kind_of


@dataclass(frozen=True)
class Field:
    """A number, vector or matrix in a struct, rows first.

    Attributes:
        name: in C.
        shape: its axes; ``()`` for a number.
        kind: of its entries.
        meaning: one line; ``""`` where it is not known.
        half: whether it is a symmetric matrix stored as its upper half, rows first.
    """

    name: str
    shape: tuple[int, ...]
    kind: Kind
    meaning: str = ""
    half: bool = False

    @property
    def size(self) -> int:
        """Number of stored entries."""
        if self.half:
            return self.shape[0] * (self.shape[0] + 1) // 2
        return int(np.prod(self.shape, dtype=int))

    def place(self, index: tuple[int, ...]) -> str:
        """An entry's name in its struct."""
        if not self.shape:
            return self.name
        if not self.half:
            return f"{self.name}[{int(np.ravel_multi_index(index, self.shape))}]"
        row, column = sorted(index)
        return f"{self.name}[{row * self.shape[0] - row * (row - 1) // 2 + column - row}]"

    def entries(self) -> Iterator[tuple[int, ...]]:
        """The stored entries, in their order."""
        for index in np.ndindex(self.shape):
            if not self.half or index[0] <= index[1]:
                yield index


def fields_of(filter: Any, part: str, tree: Any) -> list[Field]:
    """The fields of one of a filter's tuples, in the order of its leaves.

    Args:
        filter: the filter, whose facts give their meanings.
        part: ``params``, ``inputs``, ``state`` or ``outputs``.
        tree: arrays, or their shapes and types.
    """
    facts = _facts(filter, part)
    leaves = list(_leaves(tree, ()))
    alone = next(iter(facts)) if len(facts) == 1 and part in ("params", "inputs", "outputs") else ""
    plain = alone or {"params": "p", "inputs": "z", "state": "x", "outputs": "y"}[part]
    last = [path[-1] if path and not path[-1].isdigit() else "" for path, *_ in leaves]
    found: list[Field] = []
    for (path, leaf, note), own in zip(leaves, last, strict=True):
        # The inputs of a filter inside another may be one plain array.
        name = plain if path[-1:] == ("inputs",) else own
        label = name if name and last.count(name) == 1 else "_".join(path) or plain
        label = f"{plain}_{label}" if label[0].isdigit() else label
        in_c = identifier(label, {field.name for field in found})
        meaning = _meaning(facts.get(name or plain), leaf.shape) or note
        found.append(Field(in_c, tuple(leaf.shape), kind_of(leaf.dtype), meaning))
    return found


def halved(fields: list[Field], which: set[str]) -> list[Field]:
    """The same fields, with those of the given names as upper halves."""
    return [replace(field, half=field.name in which) for field in fields]


def _leaves(tree: Any, path: tuple[str, ...], note: str = "") -> Iterator[Any]:
    if hasattr(tree, "_fields"):
        notes = _notes(type(tree))
        for name in tree._fields:
            yield from _leaves(getattr(tree, name), (*path, name), notes.get(name, note))
    elif isinstance(tree, Mapping):
        for name in sorted(tree):
            yield from _leaves(tree[name], (*path, str(name)), note)
    elif isinstance(tree, tuple | list):
        for k, part in enumerate(tree):
            yield from _leaves(part, (*path, str(k)), note)
    else:
        yield from ((path, leaf, note) for leaf in jax.tree.leaves(tree))


def _notes(kind: type[Any]) -> dict[str, str]:
    """Descriptions of each field, from ``Attributes:`` in a docstring."""
    _, _, part = (inspect.getdoc(kind) or "").partition("Attributes:")
    found = re.findall(r"^ {4}(\w+): ((?:.+\n?(?: {8}.*\n?)*))", part, re.MULTILINE)
    plain = {name: " ".join(text.split()).replace("``", "") for name, text in found}
    return {name: re.sub(r":\w+:`~?([\w.]+)`", r"\1", text) for name, text in plain.items()}


def _facts(filter: Any, part: str) -> Mapping[str, Channel | Param]:
    own = bare(filter)
    if part == "state" or not hasattr(own, part):
        return {}
    if part == "params":
        return parameter_facts(own)
    return channel_facts(own, "inputs" if part == "inputs" else "outputs")


def _meaning(fact: Channel | Param | None, shape: tuple[int, ...]) -> str:
    if fact is None:
        return ""
    axes = getattr(fact, "axes", ())
    named = f": {', '.join(axes)}" if axes and shape == (len(axes),) else ""
    unit = f", {fact.unit}" if fact.unit else ""
    return f"{fact.meaning}{named}{unit}"
