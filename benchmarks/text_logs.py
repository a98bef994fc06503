"""Time for a text log of 10^6 rows x 10 columns: python -m benchmarks.text_logs [own].

Compared with pandas and pyarrow where they are installed; they are not dependencies. ``own`` uses
our reader in NumPy for all blocks, which otherwise reads only blocks with more than plain numbers;
with ``TUNER_NATIVE=off`` those are read by SciPy in place of C. Memory is the growth of a separate
process.
"""

import importlib
import multiprocessing
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.table import Row, duration
from benchmarks.timing import Call, interleave
from tuner.data.logs import parts
from tuner.data.logs.compiled import PAYS, Form, reader
from tuner.data.logs.csv import open_csv

PART = "Long logs"
ROWS, COLUMNS, TIMES = 1_000_000, 10, 9
MOST = 2.0
"""Times as long as pandas."""
Read = Callable[[Path], object]


def written(path: Path) -> None:
    array = np.random.default_rng(0).standard_normal((ROWS, COLUMNS))
    array[:, 0] = 0.01 * np.arange(ROWS)
    header = ",".join(["t", *(f"c{k}" for k in range(1, COLUMNS))])
    np.savetxt(path, array, "%.9g", ",", header=header, comments="")


def ours(path: Path) -> object:
    table = open_csv(path)
    return table.load(table.names)


def grown(path: Path) -> float:
    """Memory growth of a process that reads the log, in arrays, including the returned one."""
    reader(PAYS)(b"1\n", Form(b",", b".", 1, [0]))  # with what it imports
    before = most_held()
    ours(path)
    return (most_held() - before) / (8 * ROWS * COLUMNS)


def most_held() -> int:
    """The most memory that this process has held, bytes; Linux tells it."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def others() -> dict[str, Read]:
    """Readers of other packages by name and version."""
    found: dict[str, Read] = {}
    for name, module in (("pandas", "pandas"), ("pyarrow", "pyarrow.csv")):
        try:
            version = importlib.import_module(name).__version__
            found[f"{name} {version}"] = importlib.import_module(module).read_csv
        except ImportError:
            continue
    return found


def timed(read: Read, path: Path) -> tuple[float, float]:
    """Wall time, s, and processor time of all cores, s."""
    start, work = time.perf_counter(), time.process_time()
    read(path)
    return time.perf_counter() - start, time.process_time() - work


def rows() -> list[Row]:
    """The log, where pandas is there to read it, too."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "log.csv")
        written(path)
        known = others()
        times = interleave({"ours": partial(ours, path), **_reading(known, path)}, TIMES)
    return [
        Row(
            part=PART,
            what=f"CSV of 10^6 rows x {COLUMNS} columns",
            ours=duration(times.median("ours")),
            against=f"{name}: {duration(times.median(name))}",
            figure=times.ratio("ours", name).median,
            best=times.ratio("ours", name).best,
            target=MOST if name.startswith("pandas") else None,
        )
        for name in known
    ] or [
        Row(part=PART, what=f"CSV of 10^6 rows x {COLUMNS} columns", note="there is no pandas here")
    ]


def _reading(readers: dict[str, Read], path: Path) -> dict[str, Call]:
    return {name: partial(read, path) for name, read in readers.items()}


def main() -> None:
    if "own" in sys.argv:
        parts.reader = lambda size: lambda text, form: None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "log.csv")
        written(path)
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            print(f"memory: {pool.apply(grown, (path,)):.1f} arrays")
        readers = {"tuner": ours, **others()}
        # In turn, so that all run under the same load.
        rounds = [{name: timed(read, path) for name, read in readers.items()} for _ in range(TIMES)]
    for name in readers:
        wall, work = ([one[name][k] for one in rounds] for k in (0, 1))
        shares = [
            statistics.median(one["tuner"][k] / one[name][k] for one in rounds) for k in (0, 1)
        ]
        print(
            f"{name}: {statistics.median(wall):.2f} s (least {min(wall):.2f}), "
            f"{statistics.median(work):.2f} s of work (least {min(work):.2f}); "
            f"tuner takes {shares[0]:.2f} of its time, {shares[1]:.2f} of its work"
        )
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
