"""``python -m benchmarks.studies``: published studies from an empty cache, in seconds.

A study's time is compilation for the most part, so their number is printed as well.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

STUDIES = {"chauhan2009": 40.0, "ha1981": 15.0, "suh2004": 30.0}
"""Seconds that each should take at most on two idle processors."""
RUN = "import sys; from tuner.cli import main; sys.exit(main() or 0)"
COMPILED = "Finished XLA compilation of"


@dataclass(frozen=True)
class Taken:
    """What a study took: seconds, those of all processors together, and compilations."""

    seconds: float
    busy: float
    compilations: int


def taken(study: str) -> Taken:
    """Run a study in a process of its own, with nothing compiled before.

    Raises:
        RuntimeError: with its last words, where it fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        where = {"TUNER_CACHE": str(Path(folder) / "cache"), "JAX_LOG_COMPILES": "1"}
        command = [sys.executable, "-c", RUN, "run", study, "--out", str(Path(folder) / "run")]
        begun, before = time.perf_counter(), _busy()
        run = subprocess.run(
            command, env=os.environ | where, capture_output=True, text=True, check=False
        )
        seconds, busy = time.perf_counter() - begun, _busy() - before
    if run.returncode not in (0, 1):  # 1: a problem that is not expected to converge
        raise RuntimeError(f"{study} ended with {run.returncode}: {run.stderr[-500:]}")
    return Taken(seconds, busy, run.stderr.count(COMPILED))


def _busy() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main(arguments: list[str] | None = None) -> int:
    """Run the named studies, or all, one after another; 1 where one takes longer than it should."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.studies", description=__doc__)
    parser.add_argument("study", nargs="*", help=f"{', '.join(STUDIES)}; all where none is named")
    named = parser.parse_args(arguments).study or list(STUDIES)
    if unknown := [study for study in named if study not in STUDIES]:
        parser.error(f"no study {', '.join(unknown)} here; there are {', '.join(STUDIES)}")
    late = False
    for study in named:
        found, limit = taken(study), STUDIES[study]
        late |= found.seconds > limit
        print(
            f"{study}: {found.seconds:.1f} s (at most {limit:g} s), {found.busy:.1f} s of all "
            f"processors, {found.compilations} compilations",
            flush=True,
        )
    return int(late)


if __name__ == "__main__":
    sys.exit(main())
