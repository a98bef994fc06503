"""Signals that end a run: Ctrl-C, and what a system sends that wants a program gone."""

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
    """Have a function called on each of the signals; what was called before is returned.

    SIGHUP that is ignored stays so: ``nohup`` asks for that.
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
    """End like Ctrl-C; whoever asks a second time waits for nothing."""
    heed(leave)
    raise KeyboardInterrupt


def leave(_signal: int, _frame: FrameType | None) -> None:
    """End at once."""
    os._exit(INTERRUPTED)


def say_interrupted() -> None:
    """The last line where nothing was begun."""
    print("tuner: interrupted before anything was saved", file=sys.stderr)
