"""A record at rest of 10^6 samples and six axes from the command line, in a fresh process.

``python -m benchmarks.rest_record`` prints the row alone.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console

from benchmarks.first_fit import TUNER
from benchmarks.table import Row, markdown, show

PART = "A record at rest"
SAMPLES, RATE_HZ, RUNS = 1_000_000, 200.0, 3
MOST = 20.0
"""Seconds of a whole run, with its report, pictures and exports."""
SENSORS = {"gyr": ("rad/s", 1e-4, 1e-5), "acc": ("m/s^2", 1e-3, 1e-4)}
"""Unit, white noise per root hertz, and random walk per root second."""


def rows() -> list[Row]:
    """The whole run, after one that compiles."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _record(folder / "rest.npz")
        found = [_run(folder) for _ in range(1 + RUNS)][1:]
    wall, work = zip(*found, strict=True)
    return [
        Row(
            part=PART,
            what="10^6 samples, 6 axes, whole run",
            figure=float(np.median(wall)),
            best=min(wall),
            unit="s",
            target=MOST,
            note=f"{min(work):.1f} s of processor time; warm cache",
        )
    ]


def _record(path: Path) -> None:
    draw = np.random.default_rng(1)

    def axis(white: float, walk: float) -> np.ndarray:
        noise = draw.standard_normal((2, SAMPLES))
        return white * np.sqrt(RATE_HZ) * noise[0] + walk / np.sqrt(RATE_HZ) * np.cumsum(noise[1])

    arrays = {
        name: np.stack([axis(white * (1 + k / 5), walk) for k in range(3)], axis=1)
        for name, (_, white, walk) in SENSORS.items()
    }
    arrays["acc"][:, 2] += 9.81
    np.savez(path, t=np.arange(SAMPLES) / RATE_HZ, **arrays)


def _run(folder: Path) -> tuple[float, float]:
    """Seconds of a run by the clock, and of the processors."""
    maps = [word for name in SENSORS for word in ("--map", f"{name}={name}:{SENSORS[name][0]}")]
    log = ("--log", str(folder / "rest.npz"), "--out", str(folder / "run"), "--force")
    before, begun = _processors(), time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-P", "-c", TUNER, "run", "rest", *maps, *log],
        env=os.environ | {"TUNER_CACHE": str(folder / "cache"), "TUNER_NATIVE": "auto"},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(done.stderr[-1000:])
    return time.perf_counter() - begun, _processors() - before


def _processors() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> int:
    """Print the table."""
    found = rows()
    show(found, Console(width=None if sys.stdout.isatty() else 160))
    print(markdown(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
