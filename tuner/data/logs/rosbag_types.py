"""The message types of a bag, and the columns that their fields make.

rosbags compiles Python from the type definitions in the file, so that all names in them are checked
first: letters, digits and underscores can be nothing but names.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from operator import attrgetter
from typing import Any

from tuner.data.logs.error import LogError

STAMP = "header.stamp"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*")
_TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
_TEXTS = ("string", "wstring")
_MOST = 4096  # columns of a topic, and numbers of an array
_DEEPEST = 16
# What REP 103 and the comments of these messages say.
_UNITS = {
    "sensor_msgs/msg/Imu": {"angular_velocity.": "rad/s", "linear_acceleration.": "m/s^2"},
    "sensor_msgs/msg/MagneticField": {"magnetic_field.": "T"},
    "sensor_msgs/msg/FluidPressure": {"fluid_pressure": "Pa"},
    "sensor_msgs/msg/Temperature": {"temperature": "degC"},
    "sensor_msgs/msg/Range": {"range": "m"},
    "sensor_msgs/msg/NavSatFix": {"latitude": "deg", "longitude": "deg", "altitude": "m"},
    "nav_msgs/msg/Odometry": {
        "pose.pose.position.": "m", "twist.twist.linear.": "m/s", "twist.twist.angular.": "rad/s",
    },
    "geometry_msgs/msg/PoseStamped": {"pose.position.": "m"},
    "geometry_msgs/msg/TwistStamped": {"twist.linear.": "m/s", "twist.angular.": "rad/s"},
}  # fmt: skip


def types_of(connections: Iterable[Any]) -> Any:
    """The store of a bag's message types; the usual ones of ROS 2 where the bag has none.

    Raises:
        LogError: where a name in a definition is none.
    """
    from rosbags.typesys import Stores, get_typestore

    found: dict[str, Any] = {}
    for connection in connections:
        check_names([connection.msgtype])
        found |= _defined(connection)
    if not found:
        return get_typestore(Stores.LATEST)
    for kind, (constants, fields) in found.items():
        check_names([kind, *(c[0] for c in constants), *(f[0] for f in fields)])
        check_names(name for _, description in fields for name in _named(description))
    store = get_typestore(Stores.EMPTY)
    store.register(found)
    return store


def _defined(connection: Any) -> dict[str, Any]:
    """The types that come with a topic."""
    from rosbags.interfaces import MessageDefinitionFormat as Format
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    definition = connection.msgdef
    if definition.format == Format.MSG:
        return dict(get_types_from_msg(definition.data, connection.msgtype))
    if definition.format == Format.NONE:
        return {}
    found: dict[str, Any] = {}
    line = "=" * 80 + "\nIDL: "
    parts = definition.data.split(line)[1:] or ["\n" + definition.data]
    for part in parts:
        found |= get_types_from_idl(part.partition("\n")[2])
    return found


def check_names(names: Iterable[str]) -> None:
    """Refuse anything but a name.

    Raises:
        LogError: with the first that is none.
    """
    for name in names:
        if _NAME.fullmatch(name) is None:
            raise LogError(f"a message type has the name {name[:60]!r}, which is none; record anew")


def _named(description: Any) -> Iterator[str]:
    """The types that a field's type names."""
    _, inner = description
    if isinstance(inner, str):
        yield inner
    elif isinstance(inner[0], tuple):
        yield from _named(inner[0])


def columns_of(store: Any, kind: str) -> dict[str, int]:
    """The columns of a message type: its numbers, nested ones by dots, arrays by their length.

    Arrays without a fixed length have -1; texts and arrays of messages are left out.

    Raises:
        LogError: where there are more than 4096.
    """
    found: dict[str, int] = {}
    for name, width in _columns(store, kind, "", _DEEPEST):
        found[name] = width
        if len(found) > _MOST:
            raise LogError(f"messages of type {kind!r} have more than {_MOST} numbers; record less")
    return found


def _columns(store: Any, kind: str, prefix: str, deep: int) -> Iterator[tuple[str, int]]:
    from rosbags.interfaces import Nodetype

    if deep == 0:
        raise LogError(f"messages of type {kind!r} are nested more than {_DEEPEST} deep")
    for field, (node, inner) in store.fielddefs[kind][1]:
        name = prefix + field
        if node == Nodetype.NAME and inner not in _TIMES:
            yield from _columns(store, inner, f"{name}.", deep - 1)
        elif node == Nodetype.NAME or (node == Nodetype.BASE and inner[0] not in _TEXTS):
            yield name, 0
        elif node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            of_what, length = inner
            if of_what[0] == Nodetype.BASE and of_what[1][0] not in _TEXTS and length <= _MOST:
                yield name, length if node == Nodetype.ARRAY else -1


@cache
def getter(field: str) -> Callable[[Any], Any]:
    """A getter of a message's field, ``angular_velocity.x``; times come in nanoseconds."""
    from rosbags.typesys.base import normalize_fieldname

    get = attrgetter(".".join(map(normalize_fieldname, field.split("."))))

    def plain(message: Any) -> Any:
        value = get(message)
        return value.sec * 10**9 + value.nanosec if hasattr(value, "nanosec") else value

    return plain


def units_of(kind: str, columns: Iterable[str]) -> Mapping[str, str]:
    """The units that a message type prescribes."""
    units = _UNITS.get(kind, {})
    return {
        column: unit
        for column in columns
        for field, unit in units.items()
        if column == field or (field.endswith(".") and column.startswith(field))
    }
