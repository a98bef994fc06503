"""Opening of files: regular files only, and no more of them than is meant."""

import os
import stat
from io import BufferedReader
from pathlib import Path

_KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def opened(path: Path) -> BufferedReader:
    """Open a file for reading; a link that the user names is followed.

    Raises:
        OSError: where it is not there, or may not be read.
        ValueError: for a pipe or a device, which may have no end, a socket and a folder.

    >>> opened(Path("/dev/null"))
    Traceback (most recent call last):
    ValueError: /dev/null is a device, not a file; write its data to a file, and name that
    """
    # Opening a pipe would wait for a writer.
    number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    if kind := _kind(number):
        os.close(number)
        raise ValueError(f"{path} is {kind}, not a file; write its data to a file, and name that")
    return os.fdopen(number, "rb")


def whole(path: Path, most: int, what: str) -> bytes:
    """The contents of a small file.

    Args:
        path: the file.
        most: largest size in bytes.
        what: what it should be, for the sentence.

    Raises:
        OSError: where it is not there, or may not be read.
        ValueError: where it is not a file, or larger.
    """
    with opened(path) as stream:
        data = stream.read(most + 1)
    if len(data) > most:
        raise ValueError(
            f"{path} has more than {most} bytes, which is no {what}; name another file"
        )
    return data


def leads_out(path: Path, folder: Path) -> bool:
    """Whether a file in a folder is a link that leads out of it."""
    return folder.resolve() not in path.resolve().parents


def _kind(number: int) -> str:
    mode = os.fstat(number).st_mode
    return next((kind for holds, kind in _KINDS if holds(mode)), "")
