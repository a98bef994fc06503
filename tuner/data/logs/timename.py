"""Which columns are time by their names, and in which unit."""

import re

UNITS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "usec", "usecs", "micros", "microsecond", "microseconds"), 1e-6),
    **dict.fromkeys(("\N{MICRO SIGN}s", "\N{GREEK SMALL LETTER MU}s"), 1e-6),
    **dict.fromkeys(("ns", "nsec", "nsecs", "nanos", "nanosecond", "nanoseconds"), 1e-9),
}
_UNIT = "|".join(UNITS)
_WORD = "|".join(unit for unit in UNITS if unit.startswith(("sec", "mill", "micro", "nano")))
_TIME = re.compile(
    rf"(?:ts|times?|time[ _-]?stamps?|elapsed(?:[ _-]?time)?|t|stamp)"
    rf"(?:[ _-]*[(\[]?({_UNIT})[)\]]?)?|({_WORD})(?:[ _-]elapsed)?"
)
_SUFFIX = re.compile(rf".*[ _\-(\[]({_UNIT})[)\]]?")


def is_time(name: str) -> bool:
    """Whether a column's name says that it is time; a struct's name before it does not count.

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
        return match[1] or match[2]
    match = _SUFFIX.fullmatch(bare)
    return None if match is None else match[1]


def _bare(name: str) -> str:
    return name.rsplit(".", 1)[-1].strip().lstrip("%").lower()
