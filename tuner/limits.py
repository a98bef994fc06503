"""Limits of memory: one cap for all formats, checked before anything is read or made."""

import os
import re
from contextlib import suppress
from pathlib import Path

VARIABLE = "TUNER_MEMORY"
"""The environment's bound on memory, in bytes or as ``4GB``; ``--memory`` sets it."""
LEAST = 1 << 30
"""Twice the memory of the program and its compiler."""
UNPACKED, RATIO = 1 << 28, 100
"""A file that unpacks to more than this, and by more than this ratio, is not a log."""
COPIES = 3
"""Largest number of copies of an array while it is read and prepared."""

_SIZE = re.compile(r"(\d+(?:\.\d+)?)\s*([kmgt]?)(i?b)?", re.IGNORECASE)
_POWERS = {"": 0, "k": 1, "m": 2, "g": 3, "t": 4}


def parse_size(what: str, text: str) -> int:
    """Bytes of a text such as ``4GB``.

    Raises:
        ValueError: for a text that is not a size, and for one too small to run in.

    >>> parse_size("--memory", "1.5 GB")
    1610612736
    """
    found = _SIZE.fullmatch(text.strip())
    if found is None or len(text) > 40:
        raise ValueError(f"{what} {text[:40]!r} is not a size; write for example 4GB or 800MB")
    size = int(float(found[1]) * 1024 ** _POWERS[found[2].lower()])
    if size < LEAST:
        raise ValueError(f"{what} {text} is less than the program itself takes; give 1GB or more")
    return size


def bound_process(size: int) -> None:
    """Limit the memory of this process and those that it starts, where the system can."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    with suppress(ValueError, OSError):  # a stricter bound is there already
        resource.setrlimit(
            resource.RLIMIT_DATA, (size, resource.getrlimit(resource.RLIMIT_DATA)[1])
        )


def memory() -> int:
    """Bytes that may be held: by the environment, else half of the machine's memory.

    Raises:
        ValueError: where the environment's text is not a size.
    """
    text = os.environ.get(VARIABLE)
    return parse_size(VARIABLE, text) if text else _of_machine() // 2


def _of_machine() -> int:
    """The memory of the machine, or of the container where that has less."""
    found = [1 << 34]
    with suppress(ValueError, OSError, AttributeError):  # not on Windows
        found = [os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")]
    for place in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        with suppress(ValueError, OSError):
            found.append(int(Path(place).read_text()))
    return min(found)


def largest(copies: int = COPIES) -> int:
    """Largest size in bytes of an array that is read or made, of which there are so many copies."""
    return max(memory() - LEAST // 2, LEAST // 2) // copies


def check_amount(what: str, size: int | float, way_out: str, copies: int = COPIES) -> None:
    """Refuse what would not fit, before it is made.

    Args:
        what: the object, such as "1e13 samples".
        size: bytes of all of it.
        way_out: what to do.
        copies: how many of it there are at the same time.

    Raises:
        ValueError: one sentence, with the limit and the way out.
    """
    if size > (most := largest(copies)):
        raise ValueError(
            f"{what} would take {size_text(size)}, where {size_text(most)} is the most that "
            f"{size_text(memory())} of memory allow; {way_out}, or set another limit by --memory"
        )


def unpacked(held: int) -> int:
    """Largest unpacked size of a compressed file of so many bytes.

    >>> unpacked(1000) == UNPACKED, unpacked(1 << 30) == RATIO << 30
    (True, True)
    """
    return max(UNPACKED, RATIO * held)


def size_text(size: int | float) -> str:
    """A size in words.

    >>> size_text(3 << 30), size_text(5000)
    ('3 GB', '0.00477 MB')
    """
    return f"{size / 2**30:.3g} GB" if size >= 1 << 29 else f"{size / 2**20:.3g} MB"
