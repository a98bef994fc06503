"""A Ctrl-C, or another signal that ends a run, that is not lost."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from tuner.stop import heed, is_importing, later, leave


@contextmanager
def interruptible() -> Iterator[Callable[[], None]]:
    """Yield a check that raises KeyboardInterrupt where one was asked for before and went lost.

    Python drops exceptions that are raised in callbacks of its garbage collector, and JAX has one
    there: a Ctrl-C at that moment would do nothing. Outside the main thread, which alone hears of
    signals, the check does nothing.
    """
    signals: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        if is_importing(frame):
            later(number)
            return
        signals.append(number)
        heed(leave)  # whoever asks a second time waits for nothing
        raise KeyboardInterrupt(number)

    def check() -> None:
        if signals:
            raise KeyboardInterrupt(signals[0])

    if threading.current_thread() is not threading.main_thread():
        yield check
        return
    before = heed(interrupt)
    try:
        yield check
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
