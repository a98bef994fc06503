"""Progress on stderr: a bar in a terminal, elsewhere a line every ten seconds."""

import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tuner.run.progress import Progress
from tuner.terminal_text import plain, printable

EVERY = 10.0
"""Seconds between two lines, where TUNER_PROGRESS says nothing else."""
_PLANNING = "reading and planning"


@contextmanager
def show_progress(check: Callable[[], None]) -> Iterator[Progress]:
    """Show how far a run is, from the first second on.

    Args:
        check: called at every step.
    """
    with _bar(check) if sys.stderr.isatty() else _lines(check) as report:
        yield report


@contextmanager
def show_planning() -> Iterator[None]:
    """Show that a run is read and planned."""
    if sys.stderr.isatty():
        print("reading and planning ...", file=sys.stderr)
        yield
        return
    with _every([_PLANNING]):
        yield


@contextmanager
def _lines(check: Callable[[], None]) -> Iterator[Progress]:
    """A line every ten seconds, also while one part takes long."""
    now = ["solving"]

    def report(what: str, part: int, parts: int) -> None:
        check()
        now[0] = f"{what}, {part} of {parts}"

    with _every(now):
        yield report


@contextmanager
def _every(now: list[str]) -> Iterator[None]:
    """Print what is being done now, every ten seconds, by a thread of its own."""
    begun, done, every = time.monotonic(), threading.Event(), _seconds()
    if every == 0:
        yield
        return

    def tell() -> None:
        while not done.wait(every):
            line = f"{time.monotonic() - begun:.0f} s: {printable(now[0])}"
            print(line, file=sys.stderr, flush=True)

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield
    finally:
        done.set()
        teller.join()


def _seconds() -> float:
    """Between two lines; 0 for none.

    Raises:
        ValueError: where TUNER_PROGRESS is no number of seconds.
    """
    setting = os.environ.get("TUNER_PROGRESS", "")
    try:
        seconds = float(setting) if setting else EVERY
    except ValueError:
        seconds = -1.0
    if not 0 <= seconds < float("inf"):
        raise ValueError(
            f"TUNER_PROGRESS is {setting!r}; give seconds between two lines, 0 for none"
        )
    return seconds


@contextmanager
def _bar(check: Callable[[], None]) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    # A bar is drawn by what others may not write.
    console = Console(file=plain(sys.stderr))
    with Bar(
        *columns, console=console, transient=True, redirect_stdout=False, redirect_stderr=False
    ) as bar:
        task = bar.add_task("starting", total=1)

        def report(what: str, part: int, parts: int) -> None:
            check()
            bar.update(task, description=printable(what), completed=part, total=parts)

        yield report
