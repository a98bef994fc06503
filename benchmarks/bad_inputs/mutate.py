"""Bytes and documents that are almost valid."""

import copy
from collections.abc import Iterator
from typing import Any

import numpy as np

Random = np.random.Generator
_EDGES = (b"\0", b"\xff", b"\x7f", b"\x80", b"\r", b"\n", b'"', b",", b"=", b"\x1b[2J", b"nan",
          b"1e999", b"-0", b"[" * 50, b"\xff" * 8, b"\0" * 8, b"\x00\x00\x00\x80")  # fmt: skip
HOSTILE: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2**31, 2**63, -(2**63), 10**400, 1e308, -1e308, 1e-320,
    float("inf"), float("nan"), "", "x", "nan", "-1", "\x1b[2J\x07", "=cmd()", "a\nb", "\0",
    "\ud800", "../../x", "/dev/zero", "é" * 300, "[" * 300, [], [[]], {}, {"": ""}, [None],
    [[1, 2], [3]], [1e308] * 3, {"a": {"b": {"c": {}}}}, [[0.0] * 3] * 3, "1..2", "2020-01-01",
    "a=b", "%s%n", "{0}",
)  # fmt: skip


def bytes_of(random: Random, data: bytes) -> bytes:
    """Cut, changed, doubled or spliced: one to four times."""
    changed = bytearray(data)
    for _ in range(int(random.integers(1, 5))):
        kind, at = int(random.integers(6)), int(random.integers(0, len(changed) + 1))
        length = int(random.integers(1, 64))
        if kind == 0 and random.random() < 0.3:
            del changed[at:]
        elif kind == 1:
            del changed[at : at + length]
        elif kind == 2:
            changed[at:at] = changed[max(0, at - length) : at]
        elif kind == 3:
            changed[at:at] = _EDGES[int(random.integers(len(_EDGES)))]
        else:
            for place in random.integers(0, max(len(changed), 1), length % 7 + 1):
                if place < len(changed):
                    changed[int(place)] = int(random.choice([0, 1, 127, 128, 255, length]))
    return bytes(changed)


def document_of(random: Random, document: Any) -> Any:
    """A document with one to three of its parts missing, renamed or replaced."""
    changed = copy.deepcopy(document)
    for _ in range(int(random.integers(1, 4))):
        places = list(_places(changed))
        if not places:
            break
        holder, key = places[int(random.integers(len(places)))]
        kind = int(random.integers(5))
        if kind == 0:
            del holder[key]
        elif kind == 1 and isinstance(holder, dict):
            holder[f"{key}x"] = holder.pop(key)
        elif kind == 2:
            other, there = places[int(random.integers(len(places)))]
            holder[key] = copy.deepcopy(other[there]) if _has(other, there) else None
        else:
            holder[key] = HOSTILE[int(random.integers(len(HOSTILE)))]
    return changed


def _has(holder: Any, key: Any) -> bool:
    return key in holder if isinstance(holder, dict) else key < len(holder)


def _places(document: Any) -> Iterator[tuple[Any, Any]]:
    """A place in a document: its container and its key."""
    inside = (
        document.items() if isinstance(document, dict)
        else enumerate(document) if isinstance(document, list) else ()
    )  # fmt: skip
    for key, value in inside:
        yield document, key
        yield from _places(value)
