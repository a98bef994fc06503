"""``python -m benchmarks.stopped_runs``: runs that are stopped at any moment, the first ones too.

A run is stopped by SIGINT, SIGTERM and SIGHUP at many moments, from the start of the process on.
Each has to end in time, with one last line that says what is saved, without a traceback, and with
128 and the signal's number as its exit code; where Python itself has not yet begun to load the
program, the signal ends it.
"""

import argparse
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.killed_runs import WORDS, processor_time

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PATIENCE = 60.0
"""So long a run may take to end, s."""
EARLY = 0.05
"""So many seconds of processor time Python takes to begin; nobody hears a signal before."""


@dataclass(frozen=True)
class Stopped:
    """A run that was stopped.

    Attributes:
        number: of the signal.
        moment: when it was sent, s from the start of the process.
        begun: processor time that the process had taken until then, s.
        code: exit code; negative: ended by the signal.
        err: what it wrote on stderr.
    """

    number: int
    moment: float
    begun: float
    code: int
    err: str

    @property
    def fault(self) -> str:
        """What is wrong with this end; "" for nothing."""
        if self.code in (0, 1):  # it was over before
            return ""
        early = self.begun < EARLY
        if early and (self.code == -self.number or "KeyboardInterrupt" in self.err):
            return ""
        if "Traceback" in self.err or "Exception ignored" in self.err:
            return "traceback"
        if self.code != 128 + self.number:
            return f"exit code {self.code}"
        last = self.err.splitlines()[-1:]
        return "" if last and last[0].startswith("tuner: ") else "no line"


def stopped(number: int, moment: float, folder: Path) -> Stopped:
    """Start a run, and stop it."""
    sets = [word for each in WORDS for word in ("--set", each)]
    command = [sys.executable, "-m", "tuner", "run", "kownacki2010", *sets, "--jobs", "1"]
    with subprocess.Popen(
        [*command, "--out", str(folder)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        time.sleep(moment)
        begun = processor_time(process.pid)
        process.send_signal(number)
        try:
            _, err = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            return Stopped(number, moment, begun, 124, "")
    return Stopped(number, moment, begun, process.returncode, err)


def moments(first: float, last: float, count: int) -> Iterator[float]:
    """Moments that lie closer together at the beginning."""
    for i in range(count):
        yield first * (last / first) ** (i / max(count - 1, 1))


def main(arguments: list[str] | None = None) -> int:
    """Stop runs at many moments; 0 where each of them ended as it has to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=30, help="moments for each signal")
    parser.add_argument("--first", type=float, default=0.01)
    parser.add_argument("--last", type=float, default=2.0)
    asked = parser.parse_args(arguments)
    for each in SIGNALS:  # as a terminal has them, whoever has them ignored here
        signal.signal(each, signal.SIG_DFL)
    ends, wrong = Counter[str](), 0
    for moment in moments(asked.first, asked.last, asked.count):
        for number in SIGNALS:
            with tempfile.TemporaryDirectory() as folder:
                end = stopped(number, moment, Path(folder) / "run")
            words = (end.err.splitlines() or [""])[-1][:60]
            ends[f"{signal.Signals(number).name}: exit {end.code}, {words!r}"] += 1
            if end.fault:
                wrong += 1
                print(
                    f"{end.fault}: {signal.Signals(number).name} after {moment:.3f} s "
                    f"({end.begun:.2f} s of processor time): exit {end.code}\n{end.err[-600:]}"
                )
    for words, number in sorted(ends.items()):
        print(f"{number:4} {words}")
    print(f"{wrong} of {sum(ends.values())} ended otherwise than they have to")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
