"""A fit from the command line in a fresh process: nothing compiled before, and everything.

``python -m benchmarks.first_fit`` prints these rows alone.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.table import Row

PART = "A first fit"
SAMPLES, DT = 10_000, 0.1
WARM_RUNS, EMPTY_RUNS = 5, 3
WARM, EMPTY, SOLVE = 4.0, 8.0, 0.5
"""Seconds at most: of a whole run, and of its search."""
MODEL = """
title = "Positions along two axes, each with its own noise"
[parameters]
q_x = { unit = "m^2/s^3", meaning = "spectral density of the acceleration along x" }
q_y = { unit = "m^2/s^3", meaning = "spectral density of the acceleration along y" }
R_x = { unit = "m^2", meaning = "variance of a position along x" }
R_y = { unit = "m^2", meaning = "variance of a position along y" }
[states]
x = { unit = "m" }
vx = { unit = "m/s" }
y = { unit = "m" }
vy = { unit = "m/s" }
[measurements]
zx = { unit = "m", meaning = "measured position along x" }
zy = { unit = "m", meaning = "measured position along y" }
[model]
A = [[0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0]]
G = [[0, 0], [1, 0], [0, 0], [0, 1]]
Q = [["q_x", 0], [0, "q_y"]]
C = [[1, 0, 0, 0], [0, 0, 1, 0]]
R = [["R_x", 0], [0, "R_y"]]
P0 = inf
"""
TUNER = "from tuner.cli import main; main()"
COUNTED = """
import json, sys
from tuner.cli import invoke
import jax.monitoring
found = {}
def listen(event, seconds, **_):
    if event.startswith("/jax/core/compile/"):
        number, total = found.get(event, (0, 0.0))
        found[event] = number + 1, total + seconds
jax.monitoring.register_event_duration_secs_listener(listen)
invoke(sys.argv[2:])
open(sys.argv[1], "w").write(json.dumps(found))
"""
COMPILED = "/jax/core/compile/backend_compile_duration"
TRACED = (
    "/jax/core/compile/jaxpr_trace_duration",
    "/jax/core/compile/jaxpr_to_mlir_module_duration",
)


@dataclass(frozen=True)
class Tracker:
    """A tracker along two axes, and the words that fit it.

    Attributes:
        name: of the row.
        words: of the command line, besides the recording and the folder.
    """

    name: str
    words: Sequence[str]


def trackers(folder: Path) -> tuple[Tracker, ...]:
    """One of the catalogue, of 2 parameters, and a model in a text file, of 4."""
    (folder / "tracker.toml").write_text(MODEL)
    own = "--map", "x=x:m", "--map", "y=y:m", "--filter", "constant-velocity"
    model = "--map", "zx=x:m", "--map", "zy=y:m", "--model", str(folder / "tracker.toml")
    return Tracker("constant-velocity, 2 parameters", own), Tracker("model, 4 parameters", model)


def rows() -> list[Row]:
    """Both trackers, with an empty cache and with a warm one."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _record(folder / "track.csv")
        return [row for tracker in trackers(folder) for row in _rows(folder, tracker)]


def _record(path: Path) -> None:
    draw = np.random.default_rng(5)
    speed = np.cumsum(draw.standard_normal((SAMPLES, 2)) * np.sqrt(0.5 * DT), axis=0)
    measured = np.cumsum(speed * DT, axis=0) + 2.0 * draw.standard_normal((SAMPLES, 2))
    table = np.column_stack([np.arange(SAMPLES) * DT, measured])
    np.savetxt(path, table, delimiter=",", header="t,x,y", comments="", fmt="%.9g")


def _rows(folder: Path, tracker: Tracker) -> Iterator[Row]:
    _run(folder, tracker, "bytecode")
    empty = [_run(folder, tracker, f"empty{k}") for k in range(EMPTY_RUNS)]
    warm = [_run(folder, tracker, "empty0") for _ in range(WARM_RUNS)]
    counts = [_counted(folder, tracker, cache) for cache in ("counted", "counted")]
    for what, times, target, count in (
        ("empty cache", empty, EMPTY, counts[0]),
        ("warm cache", warm, WARM, counts[1]),
    ):
        yield _row(tracker, what, [whole for whole, _ in times], target, count)
    note = "warm cache, beside the search on a part of the data"
    yield _row(tracker, "search and certificate", [solve for _, solve in warm], SOLVE, note)


def _row(tracker: Tracker, what: str, seconds: list[float], target: float, note: str) -> Row:
    return Row(
        part=PART,
        what=f"{tracker.name}: {what}",
        figure=float(np.median(seconds)),
        best=min(seconds),
        unit="s",
        target=target,
        note=note,
    )


def _run(folder: Path, tracker: Tracker, cache: str) -> tuple[float, float]:
    """Seconds of a whole run, and of its search."""
    begun = time.perf_counter()
    _python(folder, cache, [TUNER, *_words(folder, tracker)])
    whole = time.perf_counter() - begun
    result = json.loads((folder / "run" / "result.json").read_text())
    return whole, float(result["solutions"][0]["seconds"])


def _counted(folder: Path, tracker: Tracker, cache: str) -> str:
    """How many programs are compiled or read from the cache, and how long JAX takes for that."""
    told = folder / "counted.json"
    _python(folder, cache, [COUNTED, str(told), *_words(folder, tracker)])
    found = json.loads(told.read_text())
    number, seconds = found.get(COMPILED, (0, 0.0))
    traced = sum(found.get(name, (0, 0.0))[1] for name in TRACED)
    return f"{number} programs, {seconds:.2g} s in XLA and {traced:.2g} s before it"


def _words(folder: Path, tracker: Tracker) -> list[str]:
    run = ["--time", "t:s", "--out", str(folder / "run"), "--force"]
    return ["fit", str(folder / "track.csv"), *tracker.words, *run]


def _python(folder: Path, cache: str, words: Sequence[str]) -> None:
    own = {
        "TUNER_CACHE": str(folder / cache),
        "TUNER_PROGRAMS": "stored",
        "TUNER_NATIVE": "auto",  # as users have it, whatever is measured beside
        "PYTHONPYCACHEPREFIX": str(folder / "bytecode"),
        "PYTHONDONTWRITEBYTECODE": "",
    }
    command = [sys.executable, "-c", *words]
    done = subprocess.run(
        command, env=os.environ | own, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"the fit failed: {done.stderr.strip()[-500:]}")


def main() -> None:
    """Print the table."""
    from rich.console import Console

    from benchmarks.table import show

    show(rows(), Console(width=150))


if __name__ == "__main__":
    main()
