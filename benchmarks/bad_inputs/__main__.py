"""``python -m benchmarks.bad_inputs``: thousands of bad inputs and their effects.

Every case runs in a fork of one process that has everything loaded. The goal is 0 tracebacks, 0
signals, 0 hangs above 20 s, 0 peaks above 1 GB, and 0 files written by refused input.
"""

import argparse
import os
import shlex
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Container, Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from benchmarks.bad_inputs import documents, hostile, lines, logs, runs
from benchmarks.bad_inputs.case import Case
from benchmarks.bad_inputs.judge import Ended, tried
from benchmarks.bad_inputs.mutate import Random

SHARES = {"logs": 0.4, "hostile": 0.1, "lines": 0.2, "documents": 0.15, "runs": 0.15}
EVERY = 250
TUNED = ("fit", "good.csv", "--filter", "local-level", "--map", "z=gx", "--starts", "1",
         "--no-hold-out")  # fmt: skip
DESIGNED = ("run", "design.toml")


def cases(
    count: int, seed: int, folders: list[dict[str, bytes]], generators: Container[str] = SHARES
) -> Iterator[Case]:
    """A number of cases of all kinds.

    Args:
        count: their number.
        seed: seed of their random numbers.
        folders: the files of finished runs; without any there are no such cases.
        generators: whose cases are wanted; they are the same with and without the others.
    """
    made = {
        "logs": logs.cases, "hostile": hostile.cases, "lines": lines.cases,
        "documents": documents.cases, "runs": lambda random: runs.cases(random, folders),
    }  # fmt: skip
    for number, (kind, share) in enumerate(SHARES.items()):
        if kind in generators and (kind != "runs" or folders):
            random: Random = np.random.default_rng([seed, number])
            yield from islice(made[kind](random), round(share * count))


def main(arguments: list[str] | None = None) -> int:
    """Try all cases and print the faults; 1 if there is any."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.bad_inputs", description=__doc__)
    parser.add_argument("--cases", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--generators", nargs="+", choices=SHARES, default=[*SHARES])
    parser.add_argument("--only", default="", help="kinds that begin like this")
    parser.add_argument("--write", type=Path, help="a folder for the cases that went wrong")
    asked = parser.parse_args(arguments)
    loaded()
    from tuner.cli import invoke

    begun, wrong, kinds, worst = time.monotonic(), Counter[str](), Counter[str](), Worst()
    folders = finished_runs() if "runs" in asked.generators else []
    for case in cases(asked.cases, asked.seed, folders, asked.generators):
        if not case.kind.startswith(asked.only):
            continue
        ended = tried(case, invoke)
        kinds[f"{case.kind}: exit {ended.code}"] += 1
        worst.see(case, ended)
        for fault in ended.faults:
            wrong[fault] += 1
            _tell(case, ended, fault)
            if asked.write is not None:
                case.lay(asked.write / f"{sum(wrong.values()):04d}")
        if kinds.total() % EVERY == 0:
            told = f"{kinds.total()} cases, {wrong.total()} wrong, {time.monotonic() - begun:.0f} s"
            print(told, file=sys.stderr, flush=True)
    for kind, number in sorted(kinds.items()):
        print(f"{number:6} {kind}")
    print(f"{kinds.total()} cases in {time.monotonic() - begun:.0f} s; {worst.told()}")
    print("wrong: " + (", ".join(f"{n} {what}" for what, n in wrong.items()) or "nothing"))
    return 1 if wrong else 0


class Worst:
    """The longest and the largest of all cases."""

    def __init__(self) -> None:
        self.seconds = self.peak = 0.0
        self.slow = self.large = ""

    def see(self, case: Case, ended: Ended) -> None:
        """Add one case."""
        if ended.seconds > self.seconds:
            self.seconds, self.slow = ended.seconds, case.kind
        if ended.peak > self.peak:
            self.peak, self.large = ended.peak, case.kind

    def told(self) -> str:
        """In words."""
        return (
            f"longest {self.seconds:.1f} s of processor time ({self.slow}), largest "
            f"{self.peak / 2**20:.0f} MiB ({self.large})"
        )


def loaded() -> None:
    """Load everything that cases need, so that forks have it; JAX starts in each of them."""
    import h5py  # noqa: F401  # where it is missing nothing is measured
    import optuna  # noqa: F401
    import scipy.io
    import scipy.optimize  # noqa: F401

    import tuner.cli.check
    import tuner.cli.columns
    import tuner.cli.common_options
    import tuner.cli.compare
    import tuner.cli.exit_code
    import tuner.cli.export
    import tuner.cli.run
    import tuner.data.reading
    import tuner.model.reading  # noqa: F401
    from tuner.run.study import find_study, study_names

    for name in study_names():
        find_study(name)


def finished_runs() -> list[dict[str, bytes]]:
    """The files of two runs, made here by the program itself."""
    import subprocess

    import tomli_w

    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        (here / "good.csv").write_bytes(logs.text())
        (here / "design.toml").write_text(tomli_w.dumps(documents.STUDIES[1]))
        for name, words in (("fit", TUNED), ("design", DESIGNED)):
            command = [sys.executable, "-m", "tuner", *words, "--out", name]
            search = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
            environment = os.environ | {"PYTHONPATH": search}
            subprocess.run(command, cwd=here, env=environment, capture_output=True, check=False)
        found = [runs.finished(here / name) for name in ("fit", "design")]
    return [files for files in found if "result.json" in files]


def _tell(case: Case, ended: Ended, fault: str) -> None:
    last = "\n    ".join(ended.err.splitlines()[-3:])
    words = shlex.join(case.words)[:300]
    told = f"{fault}: {case.kind}: tuner {words}\n    {ended.left[:5]} {last[:700]}"
    print(told.encode(errors="backslashreplace").decode(), flush=True)


if __name__ == "__main__":
    sys.exit(main())
