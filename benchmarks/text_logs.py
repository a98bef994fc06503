"""How long a text log of 10^6 rows x 10 columns takes: python -m benchmarks.text_logs.

Beside pandas where that is installed; it is no dependency. Memory is what the process grew by.
"""

import importlib
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tuner.data.logs.csv import open_csv

ROWS, COLUMNS, TIMES = 1_000_000, 10, 12


def written(path: Path) -> None:
    array = np.random.default_rng(0).standard_normal((ROWS, COLUMNS))
    array[:, 0] = 0.01 * np.arange(ROWS)
    header = ",".join(["t", *(f"c{k}" for k in range(1, COLUMNS))])
    np.savetxt(path, array, "%.9g", ",", header=header, comments="")


def ours(path: Path) -> None:
    table = open_csv(path)
    table.load(table.names)


def timed(read: Callable[[Path], object], path: Path) -> tuple[float, float]:
    """How long it takes, s, and the work of all cores, s."""
    start, work = time.perf_counter(), time.process_time()
    read(path)
    return time.perf_counter() - start, time.process_time() - work


def shown(name: str, found: list[tuple[float, float]]) -> tuple[float, float]:
    wall, work = (min(one[k] for one in found) for k in (0, 1))
    print(f"{name}: {wall:.2f} s, {work:.2f} s of work")
    return wall, work


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "log.csv")
        written(path)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        ours(path)
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
        print(f"memory: {grown / (8 * ROWS * COLUMNS):.1f} arrays")
        try:
            pandas = importlib.import_module("pandas")
        except ImportError:
            shown("tuner", [timed(ours, path) for _ in range(TIMES)])
            return
        # In turn, so that both see the same of the machine.
        pairs = [(timed(ours, path), timed(pandas.read_csv, path)) for _ in range(TIMES)]
        own = shown("tuner", [one for one, _ in pairs])
        its = shown(f"pandas {pandas.__version__}", [other for _, other in pairs])
        print(f"ratio: {own[0] / its[0]:.2f}, of work {own[1] / its[1]:.2f}")


if __name__ == "__main__":
    main()
