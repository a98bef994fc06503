"""Columns that are time by their names, and their units."""

import re
from collections.abc import Iterable

UNITS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "usec", "usecs", "micros", "microsecond", "microseconds"), 1e-6),
    **dict.fromkeys(("\N{MICRO SIGN}s", "\N{GREEK SMALL LETTER MU}s"), 1e-6),
    **dict.fromkeys(("ns", "nsec", "nsecs", "nanos", "nanosecond", "nanoseconds"), 1e-9),
}
_UNIT = "|".join(UNITS)
_WORD = "|".join(unit for unit in UNITS if unit.startswith(("sec", "mill", "micro", "nano")))
_WHOSE = (
    "abs|absolute|boot|device|epoch|global|gps|host|local|log|logger|mcu|measurement|record"
    "|recording|rel|relative|ros|run|sample|sampling|sensor|step|sys|system|test|total|unix|utc"
)
_TIME = re.compile(
    rf"(?:(?:(?:{_WHOSE})[ _-]?)?(?:times?|time[ _-]?stamps?|stamp)(?:[ _-](?:boot|since .*))?"
    rf"|ts|t|epoch|elapsed(?:[ _-]?time)?|clock|datum|date|date ?[/_-]?time|utc|(?:uhr|lauf)?zeit"
    rf"|zeitstempel)(?:[ _-]*,? *[/(\[]?(?:in )?({_UNIT})[)\]]?)?"
    rf"|({_WORD})(?:[ _-]elapsed)?|elapsed[ _-]({_WORD})"
)
_SUFFIX = re.compile(rf".*[ _\-(\[/]({_UNIT})[)\]]?")
_SECONDS = re.compile(r"(.*?)(secs?|seconds)", re.IGNORECASE)
_FRACTIONS = ("nsecs", "nsec", "nanosec", "nanosecs", "nanoseconds", "usecs", "usec")


def is_time(name: str) -> bool:
    """Whether a column's name denotes time; a struct's name before it does not count.

    Example:
        >>> [is_time(name) for name in ("t", "Time (s)", "imu.t_us", "seconds", "omega")]
        [True, True, True, True, False]
    """
    return _TIME.fullmatch(_bare(name)) is not None


def unit_of(name: str) -> str | None:
    """The unit of time at the end of a column's name, a key of ``UNITS``; None without one.

    Example:
        >>> unit_of("t [ms]"), unit_of("timestamp"), unit_of("TimeUS")
        ('ms', None, 'us')
    """
    bare = _bare(name)
    match = _TIME.fullmatch(bare)
    if match is not None:
        return match[1] or match[2] or match[3]
    match = _SUFFIX.fullmatch(bare)
    return None if match is None else match[1]


def fraction_of(name: str, names: Iterable[str]) -> str | None:
    """The column that counts the parts of the seconds in another one; None where there is none.

    >>> fraction_of("stamp.secs", ["stamp.secs", "stamp.nsecs", "x"])
    'stamp.nsecs'
    """
    match = _SECONDS.fullmatch(name)
    wanted = {f"{match[1]}{word}".lower() for word in _FRACTIONS} if match else set()
    return next((other for other in names if other.lower() in wanted), None)


def _bare(name: str) -> str:
    return name.rsplit(".", 1)[-1].strip().lstrip("%").lower()
