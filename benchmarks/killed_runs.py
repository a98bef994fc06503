"""``python -m benchmarks.killed_runs``: runs that are killed at any moment, and go on.

Two runs are left alone, of which the first compiles. Others are killed by SIGKILL at random moments
between their beginning and their end, counted in processor time, which no other program stretches;
and gone on with by ``--resume``, or begun where nothing was saved. Their descents must end where
those of the second did, to the bit; their samplers must have made as many trials.
"""

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

WORDS = ("seconds=0.2", "cutoff_hz=50", "grid=2", "starts=2", 'solvers=["l-bfgs-b", "tpe"]')
"""A small run: descents and a sampler on two sensors."""
LOOK = 0.03
"""Between looks at a process, s."""
CODE = "import sys; from tuner.cli import invoke; sys.exit(invoke(sys.argv[1:]))"


def command(out: Path, *more: str) -> list[str]:
    """The run into a folder."""
    sets = [word for each in WORDS for word in ("--set", each)]
    run = ["run", "kownacki2010", *sets, "--jobs", "1", "--out", str(out), *more]
    return [sys.executable, "-c", CODE, *run]


def found(out: Path) -> dict[str, Any]:
    """The invariant results: points of descents, and the number of samplers' trials."""
    solutions = json.loads((out / "result.json").read_text())["solutions"]
    return {
        f"{each['problem']} {each['solver']}": each["evaluations"]
        if each["solver"] == "tpe"
        else (each["z"], each["value"], each["status"], each["evaluations"])
        for each in solutions
    }


def processor_time(number: int) -> float:
    """What a process has taken so far, s; infinite where Linux has none of that number."""
    try:
        fields = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return float("inf")
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def left_alone(out: Path, *words: str) -> float:
    """A run that nobody kills, and the processor time it took, s."""
    process, last = subprocess.Popen(command(out, *words), **_QUIET), 0.0
    while process.poll() is None:
        last = max(last, processor_time(process.pid))
        time.sleep(LOOK)
    return last


def disturbed(
    folder: Path, times: int, whole: float, seed: int, words: Sequence[str]
) -> Iterator[tuple[float, Path]]:
    """Runs that were killed after so much processor time, and went on."""
    dice = random.Random(seed)
    for i in range(times):
        out, moment = folder / f"{i}", dice.uniform(0.0, whole)
        run = subprocess.Popen(command(out, *words), **_QUIET)
        while run.poll() is None and processor_time(run.pid) < moment:
            time.sleep(LOOK)
        run.kill()
        run.wait()
        if not (out / "study.toml").exists():
            subprocess.run(command(out, *words), check=False, **_QUIET)
        elif (out / "progress.json").exists() or not (out / "result.json").exists():
            subprocess.run(command(out, *words, "--resume"), check=False, **_QUIET)
        yield moment, out


def main(arguments: list[str] | None = None) -> int:
    """Kill, go on and compare; 0 where all are equal."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=40)
    parser.add_argument("--seed", type=int, default=0, help="of the moments")
    parser.add_argument("--claim", help="solve what this claim takes alone, a quarter of the time")
    asked = parser.parse_args(arguments)
    words = () if asked.claim is None else ("--claim", asked.claim)
    equal = 0
    with tempfile.TemporaryDirectory() as folder:
        left_alone(Path(folder) / "compiled", *words)
        whole, expected = left_alone(Path(folder) / "whole", *words), found(Path(folder) / "whole")
        for moment, out in disturbed(Path(folder), asked.times, whole, asked.seed, words):
            same = (out / "result.json").exists() and found(out) == expected
            equal += same
            told = "equal" if same else "DIFFERS"
            print(f"killed after {moment:.2f} s of {whole:.2f}: {told}", flush=True)
    print(f"{equal} of {asked.times} equal to the undisturbed run")
    return 0 if equal == asked.times else 1


_QUIET: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}

if __name__ == "__main__":
    sys.exit(main())
