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

ROWS, COLUMNS, TIMES = 1_000_000, 10, 5


def written(path: Path) -> None:
    array = np.random.default_rng(0).standard_normal((ROWS, COLUMNS))
    array[:, 0] = 0.01 * np.arange(ROWS)
    header = ",".join(["t", *(f"c{k}" for k in range(1, COLUMNS))])
    np.savetxt(path, array, "%.9g", ",", header=header, comments="")


def ours(path: Path) -> None:
    table = open_csv(path)
    table.load(table.names)


def best(read: Callable[[Path], object], path: Path) -> tuple[float, float]:
    """The shortest time, s, and the least work of all cores, s."""
    found = []
    for _ in range(TIMES):
        start, work = time.perf_counter(), time.process_time()
        read(path)
        found.append((time.perf_counter() - start, time.process_time() - work))
    return min(wall for wall, _ in found), min(work for _, work in found)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "log.csv")
        written(path)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        wall, work = best(ours, path)
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
        print(
            f"tuner: {wall:.2f} s, {work:.2f} s of work, {grown / (8 * ROWS * COLUMNS):.1f} arrays"
        )
        try:
            pandas = importlib.import_module("pandas")
        except ImportError:
            return
        its, its_work = best(lambda file: pandas.read_csv(file, engine="c"), path)
        print(f"pandas {pandas.__version__}: {its:.2f} s, {its_work:.2f} s of work")
        print(f"ratio: {wall / its:.2f}, of work {work / its_work:.2f}")


if __name__ == "__main__":
    main()
