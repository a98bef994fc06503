"""Signals that end a run: Ctrl-C, and those of a system that wants a program to end."""

import os
import signal
import sys
from collections.abc import Callable
from types import FrameType

INTERRUPTED = 130
"""The exit code after any of them."""
NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
Heard = Callable[[int, FrameType | None], None]
Before = dict[int, Callable[[int, FrameType | None], object] | int | None]


def heed(heard: Heard) -> Before:
    """Call a function on each of the signals; the previous handlers are returned.

    An ignored SIGHUP stays ignored, as ``nohup`` requires.
    """
    before: Before = {}
    for name in NAMES:
        number = getattr(signal, name, None)  # no SIGHUP on Windows
        if number is not None and not (name == "SIGHUP" and _is_ignored(number)):
            before[number] = signal.signal(number, heard)
    return before


def _is_ignored(number: int) -> bool:
    return signal.getsignal(number) is signal.SIG_IGN


def interrupt(_signal: int, _frame: FrameType | None) -> None:
    """End like Ctrl-C; a second signal ends at once."""
    heed(leave)
    raise KeyboardInterrupt


def leave(_signal: int, _frame: FrameType | None) -> None:
    """End at once."""
    os._exit(INTERRUPTED)


def say_interrupted() -> None:
    """The last line where nothing had begun."""
    print("tuner: interrupted before anything was saved", file=sys.stderr)
