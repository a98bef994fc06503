"""Where the command line ends: one line and an exit code, whatever was raised within."""

import os
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from typing import Any, cast

from tuner.cli.fault import fault_of
from tuner.stop import code_of, say_interrupted
from tuner.terminal_text import PrintableStream, on_one_line


def exit_code_of(run: Callable[[], int], *, with_traceback: bool) -> int:
    """The exit code of a command.

    Args:
        run: the command; it returns its own exit code.
        with_traceback: whether the traceback of an error is shown.
    """
    with _shown():
        try:
            code = run()
            sys.stdout.flush()
        except KeyboardInterrupt as stopped:
            say_interrupted()
            return code_of(stopped)
        except SystemExit as ended:
            return 0 if _nobody_reads(ended.__context__) else _code_of(ended)
        except Exception as error:
            if _nobody_reads(error):
                return 0
            if with_traceback:
                traceback.print_exception(error, file=sys.stderr)
            return report_error(error)
        return code


def report_error(error: BaseException) -> int:
    """Say in one line what was wrong, and return the exit code."""
    fault = fault_of(error)
    with suppress(OSError):  # nobody may read it
        print(f"tuner: {on_one_line(fault.sentence)}", file=sys.stderr)
    return fault.code


@contextmanager
def _shown() -> Iterator[None]:
    """Nothing that a terminal would obey is written while this lasts."""
    out, err = (cast("Any", PrintableStream(stream)) for stream in (sys.stdout, sys.stderr))
    with redirect_stdout(out), redirect_stderr(err):
        yield


def _nobody_reads(error: BaseException | None) -> bool:
    """Whether it failed because who read the output has gone, as ``| head`` does."""
    if not isinstance(error, BrokenPipeError):
        return False
    gone = [stream for stream in (sys.stdout, sys.stderr) if _is_gone(stream)]
    for stream in gone:  # so that what is left in it does not fail once more at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    return bool(gone)


def _is_gone(stream: Any) -> bool:
    """Whether the other end of a pipe is closed."""
    import select

    try:
        number = stream.fileno()
    except (AttributeError, OSError, ValueError):  # it is no file
        return False
    if not hasattr(select, "poll"):  # on Windows nobody can tell
        return True
    ends = select.poll()
    ends.register(number, 0)
    return bool(ends.poll(0))


def _code_of(ended: SystemExit) -> int:
    return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
