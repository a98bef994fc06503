"""Time for an NPZ log of 10^7 times and numbers, beside numpy: python -m benchmarks.array_logs."""

import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rich.console import Console

from benchmarks.table import Row, duration, show
from benchmarks.timing import interleave
from tuner.data.reading import read_record
from tuner.data.source import file_digest

PART = "Long logs"
SAMPLES, ROUNDS, WORKS = 10_000_000, 25, 3
MOST = 1.5
"""Times as long as ``numpy.load``, which reads the arrays and compares their checksums."""


def clocks() -> Iterator[tuple[str, np.ndarray]]:
    """Times as loggers write them."""
    draw, rows = np.random.default_rng(0), np.arange(SAMPLES)
    whole = 1_700_000_000 * 10**6 + rows * 10**4
    even = 0.01 * rows
    yield "even", even
    yield "even, from 100 s, in microseconds", np.round(100 + rows / 300, 6)
    yield "uneven", even + 1e-3 * draw.random(SAMPLES)
    yield "uneven, with gaps", even + 1e-3 * draw.random(SAMPLES) + 0.05 * (rows // 100_000)
    yield "even, us since 1970", whole
    yield "uneven, us since 1970", whole + draw.integers(1000, size=SAMPLES)
    yield (
        "uneven, ns since 1970",
        1_700_000_000 * 10**9 + rows * 10**7 + draw.integers(10**6, size=SAMPLES),
    )


def by_numpy(path: Path) -> list[np.ndarray]:
    with np.load(path) as held:
        return [held[name] for name in held.files]


def rows() -> list[Row]:
    """Each clock, by wall time; what runs beside it takes one of the processors."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "log.npz")
        return [_row(path, name, times) for name, times in clocks()]


def _row(path: Path, name: str, times: np.ndarray) -> Row:
    np.savez(path, t=times, x=np.random.default_rng(1).standard_normal(SAMPLES))
    calls = {
        "ours": lambda: read_record(path, ["x=x"]),
        "numpy": lambda: by_numpy(path),
    }
    wall = interleave(calls, ROUNDS)
    work = interleave(calls, WORKS, clock=time.process_time)
    ratio = wall.ratio("ours", "numpy")
    return Row(
        part=PART,
        what=f"NPZ of 10^7 times and numbers, {name}",
        ours=duration(wall.median("ours")),
        against=f"numpy.load: {duration(wall.median('numpy'))}",
        figure=ratio.median,
        best=ratio.best,
        target=MOST,
        note=f"{duration(work.best('ours'))} of work, {duration(_digested(path))} of it the "
        "SHA-256 of the file, which numpy does not compute",
        why="the digest is half of the work, and one processor has to make all of it",
    )


def main() -> None:
    """Print the table."""
    show(rows(), Console(width=None if sys.stdout.isatty() else 160))


def _digested(path: Path) -> float:
    """The work of the SHA-256, which numpy does not compute, s."""
    calls = {"digest": lambda: file_digest(path)}
    return interleave(calls, WORKS, clock=time.process_time).best("digest")


if __name__ == "__main__":
    main()
