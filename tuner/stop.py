"""Signals that end a run: Ctrl-C, and those of a system that wants a program to end."""

import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from types import FrameType

TYPE_CHECKING = False  # nothing is loaded before signals are heard
if TYPE_CHECKING:
    from typing import NoReturn

MOMENT = 0.05
"""A signal that comes at a bad moment is sent again after so long, s."""
NAMES = ("SIGINT", "SIGTERM", "SIGHUP")
NOTHING = "interrupted before anything was saved"
_UNREAD = (OSError, ValueError, RuntimeError)
"""Raised where nobody reads a stream, it is closed, or the signal came as it was written to."""
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


def interrupt(number: int, frame: FrameType | None) -> None:
    """End like Ctrl-C; a second signal ends at once.

    In the middle of an import the process ends here: what is raised there may be lost, or be told
    as an error of a package, and has ended the process by a signal of its own.
    """
    if is_importing(frame):
        end(number)
    heed(leave)
    raise KeyboardInterrupt(number)


def is_importing(frame: FrameType | None) -> bool:
    """Whether a module is being loaded."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def heed_the_lost() -> None:
    """Send a signal again whose exception was raised where Python drops all: in a finaliser."""
    dropped = sys.unraisablehook

    def hook(what: "sys.UnraisableHookArgs") -> None:
        if isinstance(what.exc_value, KeyboardInterrupt):
            heed(_again)
            later(number_of(what.exc_value))
        else:
            dropped(what)

    sys.unraisablehook = hook


def _again(number: int, frame: FrameType | None) -> None:
    """What was lost: raised once no module is being loaded."""
    if is_importing(frame):
        later(number)
        return
    heed(leave)
    raise KeyboardInterrupt(number)


def later(number: int) -> None:
    """Send a signal once more, a moment later."""
    import threading

    again = threading.Timer(MOMENT, _send, (number,))
    again.daemon = True
    again.start()


def _send(number: int) -> None:
    """To the main thread, which may be waiting for something."""
    import threading
    from _thread import interrupt_main

    main = threading.main_thread().ident
    if hasattr(signal, "pthread_kill") and main is not None:
        signal.pthread_kill(main, number)
    else:
        interrupt_main(signal.Signals(number))


def finish() -> None:
    """All is done: a signal that comes now changes nothing any more."""
    for name in NAMES:
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)


def leave(number: int, _frame: FrameType | None) -> None:
    """End at once."""
    os._exit(_code(number))


def end(number: int) -> "NoReturn":
    """Say that nothing was saved, and end at once."""
    say_interrupted()
    for stream in (sys.stdout, sys.stderr):
        with suppress(*_UNREAD, AttributeError):
            stream.flush()
    clean_up()
    os._exit(_code(number))


def clean_up() -> None:
    """Remove what was unpacked."""
    home = sys.modules.get("tuner.data.logs.home")
    if home is not None:
        home.remove_all()


def code_of(interruption: KeyboardInterrupt) -> int:
    """The exit code after an interruption: 130 after Ctrl-C, 143 after SIGTERM, 129 after SIGHUP.

    >>> code_of(KeyboardInterrupt()), code_of(KeyboardInterrupt(15))
    (130, 143)
    """
    return _code(number_of(interruption))


def is_interrupted(code: int) -> bool:
    """Whether an exit code is that of an interruption."""
    return code >= _code(0)


def say_interrupted() -> None:
    """The last line where nothing had begun."""
    with suppress(*_UNREAD):
        print(f"tuner: {NOTHING}", file=sys.stderr)


def number_of(interruption: KeyboardInterrupt) -> int:
    """Of which signal it came; of Ctrl-C where nobody says."""
    number = interruption.args[0] if interruption.args else None
    return number if isinstance(number, int) else signal.SIGINT


def _code(number: int) -> int:
    return 128 + number
