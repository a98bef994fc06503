"""Time for an NPZ log of 10^7 times and numbers, beside numpy: python -m benchmarks.array_logs."""

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.timing import interleave
from tuner.data.reading import read_record
from tuner.data.source import file_digest

SAMPLES, ROUNDS = 10_000_000, 9
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


def main() -> None:
    """Print the best of all rounds: what runs beside it takes one of the two processors."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "log.npz")
        for name, times in clocks():
            np.savez(path, t=times, x=np.random.default_rng(1).standard_normal(SAMPLES))
            calls = {
                "ours": lambda: read_record(path, ["x=x"]),
                "numpy": lambda: by_numpy(path),
            }
            wall = interleave(calls, ROUNDS)
            work = interleave(calls, ROUNDS, clock=time.process_time)
            ratio, own = wall.ratio("ours", "numpy").best, work.best("ours")
            print(
                f"{name}: {wall.best('ours'):.3f} s at best, {ratio:.2f} x numpy's, not above "
                f"{MOST:g}; {own:.3f} s of work, {_digested(path):.3f} s of it the digest"
            )


def _digested(path: Path) -> float:
    """The work of the SHA-256, which numpy does not compute, s."""
    return interleave({"digest": lambda: file_digest(path)}, 3, clock=time.process_time).best(
        "digest"
    )


if __name__ == "__main__":
    main()
