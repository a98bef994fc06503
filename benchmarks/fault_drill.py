"""``python -m benchmarks.fault_drill``: workers that are killed, and trials that are all made once.

Four processes make trials of one search on a private PostgreSQL server; every few seconds one of
them is killed by SIGKILL, and another is started in its place, until all trials are complete. Then
the same on a SQLite file with two. A trial waits for as long as an objective would compute. What
counts: all complete, none lost, none counted twice, none left running.

A worker killed at its trial is missed after half a minute (``tuner.trials.database.GRACE``), and
its trial made again by another, at the same point. ``--throughput`` tells how much faster four
workers are than one, where nobody is killed, and what the storage takes of each trial.
"""

import argparse
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import optuna
from optuna.samplers import RandomSampler

from benchmarks.postgres import NoServerError, server
from tuner.trials.numbered import Numbered
from tuner.trials.search import Trials, opened

NAME = "drill"


@dataclass(frozen=True)
class Drill:
    """The settings of a drill.

    Attributes:
        url: of the database.
        trials: number of trials to complete.
        workers: number of workers at a time.
        seconds: duration of a trial.
        every: interval in s at which one of them is killed; 0: never.
    """

    url: str
    trials: int
    workers: int
    seconds: float
    every: float

    @contextmanager
    def search(self) -> Iterator[Trials]:
        """The trials, as a worker opens them."""
        sampler, first = Numbered(RandomSampler, 0), {"x": 0.5}
        with opened(self.url, NAME, self.trials, sampler, {}, first=first) as trials:
            yield trials

    def work(self) -> None:
        """The work of a worker."""
        with self.search() as trials:
            trials.work(self.evaluate)

    def evaluate(self, trial: optuna.Trial) -> float:
        """A trial: its point, and the wait."""
        x = trial.suggest_float("x", 0.0, 1.0)
        time.sleep(self.seconds)
        return (x - 0.3) ** 2

    def command(self) -> list[str]:
        """A worker as a process of its own."""
        numbers = [f"--trials={self.trials}", f"--seconds={self.seconds}", f"--worker={self.url}"]
        return [sys.executable, "-m", "benchmarks.fault_drill", *numbers]


def drilled(drill: Drill) -> tuple[int, float]:
    """Let workers work, and kill some: how many were, and the seconds from the first trial."""
    with drill.search():
        pass  # the tables are made before anybody is killed
    running = [subprocess.Popen(drill.command()) for _ in range(drill.workers)]
    dice, killed, begun = random.Random(0), 0, 0.0
    last = time.monotonic()
    with drill.search() as trials:
        while (done := len(trials.complete())) < drill.trials:
            begun = begun or (time.monotonic() if done else 0.0)
            for i, worker in enumerate(running):
                if worker.poll() is not None and worker.returncode != 0:
                    running[i] = subprocess.Popen(drill.command())
            if drill.every and begun and time.monotonic() - last > drill.every:
                last, killed = time.monotonic(), killed + 1
                dice.choice(running).send_signal(signal.SIGKILL)
            time.sleep(0.1)
        took = time.monotonic() - begun
    for worker in running:
        worker.wait(120)
    return killed, took


def judged(drill: Drill, killed: int, took: float) -> bool:
    """Count what is in the database, say it, and whether it is as it has to be."""
    with drill.search() as trials:
        known, complete = trials.known(), trials.complete()
    states = Counter(trial.state.name for trial in known)
    points = Counter(trial.params["x"] for trial in complete)
    again = sum(t.state.name == "FAIL" and t.params.get("x") in points for t in known)
    lost, twice = drill.trials - states["COMPLETE"], sum(points.values()) - len(points)
    unfinished = states["RUNNING"] + states["WAITING"]
    print(
        f"{drill.url.partition(':')[0]}: {drill.workers} workers, {killed} killed, {took:.0f} s: "
        f"{states['COMPLETE']} complete ({again} made again), {lost} lost, {twice} counted twice, "
        f"{unfinished} left running"
    )
    return (states["COMPLETE"], lost, twice, unfinished) == (drill.trials, 0, 0, 0)


def throughput(url: str, trials: int, seconds: float) -> float:
    """Trials a second of one worker, by which that of several is measured, and the overhead."""
    drill = Drill(url, trials, 1, seconds, 0.0)
    with drill.search() as search:
        search.make_one(drill.evaluate)
        begun, busy = time.perf_counter(), time.process_time()
        made = search.work(drill.evaluate)
        took, busy = time.perf_counter() - begun, time.process_time() - busy
    each = 1e3 * (took / made - seconds)
    print(f"one worker: {each:.0f} ms of storage a trial, of which {1e3 * busy / made:.0f} ms here")
    return made / took


def main(arguments: list[str] | None = None) -> int:
    """Drill, and return 0 where nothing was lost."""
    asked = _parser().parse_args(arguments)
    if asked.worker:
        Drill(asked.worker, asked.trials, 1, asked.seconds, 0.0).work()
        return 0
    good = True
    try:
        with server() as url:
            drill = Drill(url, asked.trials, 4, asked.seconds, asked.every)
            good &= judged(drill, *drilled(drill))
        if asked.throughput:
            _compared(asked.trials, asked.seconds)
    except NoServerError as error:
        print(f"without PostgreSQL: {error}")
    with tempfile.TemporaryDirectory() as folder:
        url = f"sqlite:///{Path(folder) / 'drill.sqlite3'}"
        drill = Drill(url, asked.trials, 2, asked.seconds, asked.every)
        good &= judged(drill, *drilled(drill))
    return 0 if good else 1


def _compared(trials: int, seconds: float) -> None:
    """Four workers against one."""
    with server() as url:
        one = throughput(url, max(trials // 4, 2), seconds)
    with server() as url:
        _, took = drilled(Drill(url, trials, 4, seconds, 0.0))
    print(f"four workers make {trials / took / one:.2f} times as many trials")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=1.0, help="that a trial takes")
    parser.add_argument("--every", type=float, default=5.0, help="seconds between kills")
    parser.add_argument("--throughput", action="store_true", help="four workers against one")
    parser.add_argument("--worker", default="", help=argparse.SUPPRESS)
    return parser


if __name__ == "__main__":
    sys.exit(main())
