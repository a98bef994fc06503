"""ArduPilot DataFlash, binary: messages that describe themselves by FMT, FMTU, UNIT and MULT.

Read here and not by pymavlink, which makes an object of each message (19 s where this takes 1.5 s)
and brings 100 MB of dialects.
"""

from array import array
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tuner.data.logs.contents import Contents, Group, table_of
from tuner.data.logs.dataflash_formats import (
    DESCRIPTIONS,
    FORMAT,
    MOST_INSTANCES,
    Message,
    Scales,
    group_of,
    plain_text,
)
from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw, Table
from tuner.names import counted

_MAGIC = b"\xa3\x95"
_HEAD = 3
_FMT = 0x80

Starts = NDArray[np.int64]


@dataclass(frozen=True)
class _Walked:
    """The kinds of messages by number, the start of each message, and the count of lost bytes."""

    kinds: dict[int, Message]
    starts: dict[int, Starts]
    lost: int


def open_dataflash(path: Path) -> Table:
    """Open a binary DataFlash log: columns ``BARO.Alt`` and ``IMU[0].GyrX``, on ``TimeUS``.

    Raises:
        LogError: where no message of it is described.
    """
    data = _bytes(path)
    walked = _walked(data)
    scales = Scales.of(_rows(data, walked, "UNIT"), _rows(data, walked, "MULT"))
    parts: dict[str, tuple[Message, Starts]] = {}
    groups: list[Group] = []
    for number, message in _lettered(data, walked).items():
        for prefix, chosen in _instances(data, message, walked.starts[number]):
            parts[prefix] = (message, chosen)
            groups.append(group_of(prefix, message, len(chosen), scales))
    if not groups:
        raise LogError(f"{path.name}: the {FORMAT} describes none of its messages; copy it again")
    size, lost = len(data), f"{counted(walked.lost, 'byte')} between the messages passed over"

    def load(names: Sequence[str]) -> dict[str, Raw]:
        data = _bytes(path)
        if len(data) != size:
            raise LogError(f"{path.name}: the file has changed since it was opened; read it again")
        return {name: _column(data, *parts[_prefix(name)], name) for name in names}

    return table_of(path, Contents(FORMAT, groups, [lost] if walked.lost else []), load)


def _bytes(path: Path) -> NDArray[np.uint8]:
    return np.memmap(path, np.uint8, "r")


def _prefix(name: str) -> str:
    return name[: name.index(".") + 1]


def _walked(data: NDArray[np.uint8]) -> _Walked:
    """Go from message to message, and skip other bytes up to the next."""
    content = data.tobytes()
    fmt = Message("FMT", *DESCRIPTIONS["FMT"])
    kinds, sizes, starts = {_FMT: fmt}, {_FMT: _size(fmt)}, {_FMT: array("q")}
    at = lost = 0
    while at + _HEAD <= len(content):
        number = content[at + 2]
        size = sizes.get(number, 0) if content[at : at + 2] == _MAGIC else 0
        if not size:
            found = content.find(_MAGIC, at + 1)
            found = len(content) if found < 0 else found
            lost, at = lost + found - at, found
            continue
        if at + size > len(content):
            break
        starts[number].append(at)
        if number == _FMT:
            new, length, message = _described(data[at : at + size], fmt)
            if new not in kinds and length >= _HEAD:  # the first description of a kind counts
                kinds[new], sizes[new], starts[new] = message, length, array("q")
        at += size
    return _Walked(kinds, {n: np.array(found, np.int64) for n, found in starts.items()}, lost)


def _size(message: Message) -> int:
    return _HEAD + (0 if message.dtype is None else message.dtype.itemsize)


def _described(record: NDArray[np.uint8], fmt: Message) -> tuple[int, int, Message]:
    """The contents of an FMT: a kind's number, its size and its columns."""
    assert fmt.dtype is not None
    number, length, *texts = record[_HEAD:].view(fmt.dtype)[0].tolist()
    name, codes, columns = map(plain_text, texts)
    message = Message(name, codes, tuple(columns.split(",")))
    if _size(message) != length:
        message = Message(name, "", ())  # its bytes can be skipped, but not read
    return number, length, message


def _column(data: NDArray[np.uint8], message: Message, starts: Starts, name: str) -> Raw:
    """A column of some messages: ``(N,)``, or ``(N, 32)`` of an array."""
    column, dtype = name[name.index(".") + 1 :], message.dtype
    assert dtype is not None
    assert dtype.fields is not None
    kind, offset = dtype.fields[column][:2]
    places = starts[:, None] + (_HEAD + offset) + np.arange(kind.itemsize)
    values = data[places].view(kind.base)
    return message.scaled(column, values if kind.shape else values[:, 0])


def _instances(
    data: NDArray[np.uint8], message: Message, starts: Starts
) -> list[tuple[str, Starts]]:
    """The messages of a kind, for each of its sensors."""
    unread = not message.columns or message.dtype is None or message.name in DESCRIPTIONS
    if unread or not len(starts):
        return []
    if message.instance is None:
        return [(f"{message.name}.", starts)]
    values = _column(data, message, starts, f".{message.instance}")
    found = np.unique(values).tolist()
    if len(found) > MOST_INSTANCES:
        return [(f"{message.name}.", starts)]
    return [(f"{message.name}[{value}].", starts[values == value]) for value in found]


def _rows(data: NDArray[np.uint8], walked: _Walked, name: str) -> list[tuple[Any, ...]]:
    """All well-formed messages of a name that describe others."""
    wanted = Message(name, *DESCRIPTIONS[name])
    rows = []
    for number, message in walked.kinds.items():
        if message == wanted:
            starts = walked.starts[number]
            columns = [_column(data, message, starts, f".{c}").tolist() for c in message.columns]
            rows += list(zip(*columns, strict=True))
    return rows


def _lettered(data: NDArray[np.uint8], walked: _Walked) -> dict[int, Message]:
    """The kinds with their letters for units and multipliers."""
    letters = {row[1]: row[2:] for row in _rows(data, walked, "FMTU")}
    none = ("", "")
    return {
        n: replace(m, unit_ids=letters.get(n, none)[0], mult_ids=letters.get(n, none)[1])
        for n, m in walked.kinds.items()
    }
