"""ROS 1 and ROS 2 bags and MCAP, by rosbags: topics with clocks of their own, in nanoseconds."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from tuner.data.logs.contents import Contents, Group
from tuner.data.logs.error import LogError
from tuner.data.logs.rosbag_types import STAMP, columns_of, getter, types_of, units_of
from tuner.data.logs.table import Raw

ROS1 = "ROS 1 bag"
_RECEIVED = "receive_time"
_LOOKED_AT = 100
_MCAP = b"\x89MCAP0\r\n"


def contents(path: Path) -> Contents:
    """The topics of a bag; those without numbers are left out.

    Raises:
        LogError: where no topic holds numbers, or the bag is of another system than ROS.
    """
    with _opened(path) as bag:
        groups = [_group(bag, topic, info) for topic, info in sorted(bag.reader.topics.items())]
    groups = [group for group in groups if group.rows and len(group.columns) > 1]
    if not groups:
        raise LogError(f"the {bag.kind} holds no messages with numbers; record it again")
    return Contents(bag.kind, groups)


def load(path: Path, names: Sequence[str]) -> dict[str, Raw]:
    """Columns of a bag by their names, ``/imu/data.angular_velocity.x``."""
    fields: dict[str, dict[str, list[Any]]] = {}
    for name in names:
        topic, _, field = name.partition(".")
        fields.setdefault(topic, {})[field] = []
    with _opened(path) as bag:
        chosen = [c for c in bag.reader.connections if c.topic in fields]
        for connection, received, raw in bag.reader.messages(chosen) if chosen else ():
            wanted = fields[connection.topic]
            message = bag.read(raw, connection.msgtype)
            for field, values in wanted.items():
                values.append(received if field == _RECEIVED else getter(field)(message))
    return {name: _column(name, fields) for name in names}


class _Bag:
    """An open bag: its kind, its reader, and the decoder of a message by its type's name."""

    def __init__(self, kind: str, reader: Any) -> None:
        self.kind = kind
        self.reader = reader
        self.store: Any = types_of(reader.connections)
        self.read: Callable[[bytes, str], Any] = (
            self.store.deserialize_ros1 if kind == ROS1 else self.store.deserialize_cdr
        )


@contextmanager
def _opened(path: Path) -> Iterator[_Bag]:
    kind, reader = _reader(path)
    reader.open()
    try:
        yield _Bag(kind, reader)
    finally:
        reader.close()


def _reader(path: Path) -> tuple[str, Any]:
    """The kind of a bag by its first bytes, and its reader."""
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2
    from rosbags.rosbag2.storage_mcap import McapReader
    from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

    if path.is_dir():
        return "ROS 2 bag", Reader2(path)
    with path.open("rb") as stream:
        head = stream.read(64)
    if not head.startswith((_MCAP, b"SQLite")):
        return ROS1, Reader1(path)
    reader = Reader2.__new__(Reader2)  # it distinguishes them by their names, and we by their bytes
    mcap = head.startswith(_MCAP)
    reader.path, reader.is_open = path, False
    reader.storage = McapReader(path) if mcap else Sqlite3Reader(path)
    if mcap:
        _check_profile(head)
    return "ROS 2 bag (MCAP)" if mcap else "ROS 2 bag", reader


def _check_profile(head: bytes) -> None:
    """MCAP holds messages of many systems; the header's first text says which."""
    start = len(_MCAP) + 1 + 8 + 4
    length = int.from_bytes(head[start - 4 : start], "little")
    profile = head[start : start + min(length, 32)].decode("latin-1")
    if profile != "ros2":
        raise LogError(
            f"the MCAP file has the profile {profile!r}, and messages of 'ros2' alone are read; "
            "export its topics as CSV"
        )


def _group(bag: _Bag, topic: str, info: Any) -> Group:
    kind = info.connections[0].msgtype
    columns = columns_of(bag.store, kind)
    notes: tuple[str, ...] = ()
    stamped, time = STAMP in columns, _RECEIVED
    if stamped and _rises(bag, info):
        time = STAMP
    elif stamped:
        notes = (f"{topic}: its header stamps do not rise, so that the time is its {_RECEIVED}",)
    if time == STAMP:
        notes = (f"{topic}: the time is its {STAMP}; --time {_RECEIVED} takes the recorder's",)
    columns = {_RECEIVED: 0, **columns}
    rows = int(info.msgcount)
    return Group(f"{topic}.", columns, rows, time, "ns", units_of(kind, columns), notes)


def _rises(bag: _Bag, info: Any) -> bool:
    """Whether the first header stamps are set, and in order."""
    found = islice(bag.reader.messages(info.connections), _LOOKED_AT)
    stamps = [getter(STAMP)(bag.read(raw, connection.msgtype)) for connection, _, raw in found]
    return bool(stamps) and stamps[0] > 0 and bool((np.diff(stamps) >= 0).all())


def _column(name: str, fields: dict[str, dict[str, list[Any]]]) -> Raw:
    topic, _, field = name.partition(".")
    values = fields[topic][field]
    if len({np.shape(value) for value in values}) > 1:
        raise LogError(f"{name!r} has arrays of several lengths; map a column of one number a row")
    return np.array(values)
