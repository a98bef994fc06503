"""``python -m benchmarks.soak``: one process that fits again and again, and the memory it holds.

Every round fits fresh data of the same length: by each solver, trials kept in a database of its
own, the solution drawn and exported; and tries what is refused. Every fifth writes a whole run's
folder. Memory is what the process holds (resident set) after each round. After the rounds of a
warm-up, in which all is compiled that will be, it has to stay within 5 %.
"""

import argparse
import gc
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

import tuner
from tuner.solvers import Sampler

SAMPLES = 400
WARM = 0.2
"""The warm-up is this share of the time."""
ALLOWED = 0.05
FOLDERS = 5
"""Every so many rounds a folder is written."""


def held() -> int:
    """Bytes that this process holds."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def data(number: int) -> tuner.Record:
    """A random walk in noise, another one for every number."""
    draw = np.random.default_rng(number)
    level = np.cumsum(0.2 * draw.standard_normal(SAMPLES))
    return tuner.Record.of({"z": level + draw.standard_normal(SAMPLES)}, rate_hz=1.0)


def once(number: int, folder: Path) -> None:
    """One round."""
    import matplotlib.pyplot as plt

    record = data(number)
    for solver in ("l-bfgs-b", "nelder-mead", "ipopt"):
        found = tuner.fit("local-level", record, solver=solver, starts=2, seed=number)
        found.summary()
    found.export("json")
    found.export("c")
    found.plot()
    if plt.get_fignums():
        raise SystemExit(f"{len(plt.get_fignums())} figures of pyplot are open")
    if number % FOLDERS == 0:
        found.save(folder / "run", force=True)
    url = f"sqlite:///{folder / f'{number}.sqlite3'}"
    Sampler("tpe", seed=number, storage=url, trials=8)(found.posed.problem)
    (folder / f"{number}.sqlite3").unlink()
    with suppress(ValueError):
        tuner.fit("local-level", record, start={"nothing": 1.0})


def rounds(seconds: float) -> Iterator[tuple[float, int]]:
    """When each round ended, s, and what is held then."""
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        number = 0
        while (now := time.monotonic() - begun) < seconds or number < 2:
            once(number, Path(folder))
            number += 1
            yield now, held()


def main(arguments: list[str] | None = None) -> int:
    """Fit, and return 0 where memory stays within the allowed share."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.soak", description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    asked = parser.parse_args(arguments)
    total = 60 * asked.minutes
    warm: list[int] = []
    for count, (now, size) in enumerate(rounds(total), 1):
        print(f"round {count}: {now:.0f} s, {size / 2**20:.1f} MiB", file=sys.stderr, flush=True)
        if now >= WARM * total or count == 1:
            warm = [*warm, size] if now >= WARM * total else [size]
    third = max(len(warm) // 3, 1)  # what is kept rises and falls
    first, last = max(warm[:third]), max(warm[-third:])
    grown = last / first - 1
    told = f"{len(warm)} rounds after the warm-up, from {first / 2**20:.1f} to {last / 2**20:.1f}"
    print(f"{told} MiB: {100 * grown:+.1f} %")
    return 0 if grown <= ALLOWED else 1


if __name__ == "__main__":
    sys.exit(main())
