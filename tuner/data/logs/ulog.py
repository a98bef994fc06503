"""PX4 ULog, by pyulog: topics with clocks of their own, in microseconds since the boot."""

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tuner.data.logs.contents import Contents, Group
from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw
from tuner.names import counted

_ELEMENT = re.compile(r"(.+)\[(\d+)\]")
_FORMAT = "PX4 ULog"


def contents(path: Path) -> Contents:
    """The topics of a ULog.

    Raises:
        LogError: where it holds no samples.
    """
    log = _read(path, None)
    if not log.data_list:
        raise LogError("the PX4 ULog holds no samples; record it again")
    groups = tuple(_group(prefix, parts) for prefix, parts in _topics(log).items())
    return Contents(_FORMAT, groups, tuple(_notes(log)))


def load(path: Path, names: Sequence[str]) -> dict[str, Raw]:
    """Columns of a ULog by their names, ``sensor_combined.gyro_rad``; arrays are ``(N, k)``."""
    topics = {re.sub(r"_\d+$", "", name.split(".")[0]) for name in names}
    topics |= {name.split(".")[0] for name in names}
    log = _read(path, sorted(topics))
    return {
        name: np.concatenate([_column(part, name.removeprefix(prefix)) for part in parts])
        for prefix, parts in _topics(log).items()
        for name in names
        if name.startswith(prefix)
    }


def _read(path: Path, topics: list[str] | None) -> Any:
    from pyulog import ULog

    return ULog(str(path), topics)


def _topics(log: Any) -> dict[str, list[dict[str, Raw]]]:
    """The parts of each topic: one, and one more where data were appended after a crash.

    The first instance is ``name.``, the second ``name_1.``.
    """
    found: dict[str, list[dict[str, Raw]]] = {}
    for topic in log.data_list:
        instance = f"_{topic.multi_id}" if topic.multi_id else ""
        found.setdefault(f"{topic.name}{instance}.", []).append(topic.data)
    return found


def _group(prefix: str, parts: list[dict[str, Raw]]) -> Group:
    widths = Counter(_whole(name) for name in parts[0])
    plain = {name for name in parts[0] if _ELEMENT.fullmatch(name) is None}
    columns = {name: 0 if name in plain else width for name, width in widths.items()}
    rows = sum(len(next(iter(part.values()))) for part in parts)
    time = "timestamp" if "timestamp" in plain else None
    return Group(prefix, columns, rows, time, "us")


def _whole(name: str) -> str:
    """The array that an element belongs to: ``gyro_rad`` of ``gyro_rad[2]``."""
    match = _ELEMENT.fullmatch(name)
    return name if match is None else match[1]


def _column(data: dict[str, Raw], name: str) -> Raw:
    if name in data:
        return data[name]
    parts = [part for key, part in data.items() if _whole(key) == name]
    return np.stack(parts, axis=1)


def _notes(log: Any) -> list[str]:
    """The note on lost samples, by the logger's own count."""
    notes = []
    if log.dropouts:
        lost = sum(dropout.duration for dropout in log.dropouts)
        times = counted(len(log.dropouts), "dropout")
        notes.append(f"{times} of the logger, {lost} ms in all: samples are missing there")
    if log.file_corruption:
        notes.append("parts of the file are damaged and were passed over")
    return notes
