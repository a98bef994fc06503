"""One case in a process of its own, and the fault of its end."""

import os
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from benchmarks.bad_inputs.case import Case
from tuner.terminal_text import printable

SECONDS, PATIENCE = 20.0, 180.0
"""Limits of processor time, and of waiting on a shared machine."""
PEAK = 1 << 30
REFUSED = 2


@dataclass(frozen=True)
class Ended:
    """The end of a case.

    Attributes:
        code: the exit code; negative: the signal.
        out, err: its outputs.
        seconds: of processor time; infinite where it did not end.
        peak: bytes.
        left: new or changed files.
    """

    code: int
    out: str
    err: str
    seconds: float
    peak: int
    left: tuple[str, ...]

    @property
    def faults(self) -> list[str]:
        """The faults of this end."""
        found = []
        last = self.err.splitlines()[-1:]
        if "Traceback" in self.err:
            found.append("traceback")
        if self.code < 0:
            found.append(f"signal {-self.code}")
        if self.seconds > SECONDS:
            found.append("hang")
        if self.peak > PEAK:
            found.append("peak")
        if self.code == REFUSED and self.left:
            found.append("files left")
        if self.code == REFUSED and not (last and last[0].startswith("tuner: ")):
            found.append("no sentence")
        if "fault of the program" in self.err:
            found.append("fault of the program")
        if printable(self.out) != self.out or printable(self.err) != self.err:
            found.append("control characters")
        if self.code not in (0, 1, REFUSED) and self.code >= 0:
            found.append(f"exit code {self.code}")
        return found


def tried(case: Case, run: Callable[[list[str]], int]) -> Ended:
    """Run a case in a fork of this process, in a folder of its own."""
    home = Path(tempfile.mkdtemp(prefix="bad-"))
    try:
        folder = home / "here"
        folder.mkdir()
        case.lay(folder)
        before = _seen(folder)
        code, seconds, peak = _forked(home, folder, list(case.words), run)
        after = _seen(folder)
        left = tuple(name for name in after if after[name] != before.get(name))
        out, err = ((home / name).read_text(errors="surrogateescape") for name in ("out", "err"))
        return Ended(code, out, err, seconds, peak, left)
    finally:
        shutil.rmtree(home, ignore_errors=True)


def _seen(folder: Path) -> dict[str, tuple[int, int]]:
    """All entries of a folder, with sizes and times."""
    found = {}
    for root, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(root, name)
            told = path.lstat()
            size = 0 if name in folders else told.st_size
            found[str(path.relative_to(folder))] = (
                size,
                0 if name in folders else told.st_mtime_ns,
            )
    return found


def _forked(
    home: Path, folder: Path, words: list[str], run: Callable[[list[str]], int]
) -> tuple[int, float, int]:
    """The exit code, the processor time and the peak of a fork."""
    number = os.fork()
    if number == 0:
        _child(home, folder, words, run)
    end = time.monotonic() + PATIENCE
    hung = False
    while True:
        done, status, used = os.wait4(number, os.WNOHANG)
        if done:
            break
        if time.monotonic() > end:
            hung = True
            os.killpg(number, signal.SIGKILL)
            end = float("inf")
        time.sleep(0.003)
    code = os.waitstatus_to_exitcode(status)
    seconds = float("inf") if hung else used.ru_utime + used.ru_stime
    return (REFUSED if hung else code), seconds, used.ru_maxrss << 10


def _child(home: Path, folder: Path, words: list[str], run: Callable[[list[str]], int]) -> None:
    """The work of the fork; it never returns."""
    code = 99
    try:
        os.setpgid(0, 0)
        os.chdir(folder)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        for name, at in (("out", 1), ("err", 2)):
            os.dup2(os.open(home / name, os.O_WRONLY | os.O_CREAT), at)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        code = run(words)
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        os._exit(code)
