"""How the process ends: its streams flushed, and without waiting for what nobody wants any more."""

import os
import sys
import threading
from contextlib import suppress
from typing import NoReturn

from tuner.stop import clean_up, finish, is_interrupted


def exit_process(code: int) -> NoReturn:
    """End the process.

    After an interruption or an error threads may still be in compiled code, which nobody waits for,
    and JAX takes a quarter second to take itself apart: all that is kept was written before.
    """
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:  # who read it has gone
            with suppress(OSError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    finish()
    if is_interrupted(code) or threading.active_count() > 1 or "jax" in sys.modules:
        clean_up()
        os._exit(code)
    sys.exit(code)
