"""``python -m benchmarks.coverage``: fit every record, count what the intervals contain."""

import argparse
import json
import multiprocessing
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.coverage.counting import HIGH, LOW, Covered, counted, nile, off_profile
from benchmarks.coverage.settings import SETTINGS

HEADER = (
    *("record", "number", "truth", "interval holds", "robust holds", "oracle"),
    *("none", "one-sided", "kinds"),
)


def main(arguments: list[str] | None = None) -> int:
    """Count, print; 1 where an interval that should cover does not."""
    asked = _parser().parse_args(arguments)
    begun = time.perf_counter()
    chosen = [i for i, setting in enumerate(SETTINGS) if asked.only in setting.name]
    work = [(i, asked.seed, asked.records) for i in chosen]
    # Spawned, as JAX does not survive a fork.
    with ProcessPoolExecutor(asked.jobs, multiprocessing.get_context("spawn")) as pool:
        rows = [row for part in pool.map(counted, work) for row in part]
    profiles = off_profile(asked.seed, asked.profiles)
    flow = nile()
    if asked.json:
        print(json.dumps([asdict(row) for row in rows], indent=1))
        return int(not all(row.holds for row in rows))
    said = Console(width=None if sys.stdout.isatty() else 130)
    _show(rows, said)
    said.print(
        f"local level: limits of {asked.profiles} records off their profile's by at most "
        f"{profiles:.2%}; Nile: {flow.words}, off by {flow.off:.2%}"
    )
    said.print(f"{time.perf_counter() - begun:.0f} s", highlight=False)
    good = all(row.holds for row in rows) and max(profiles, flow.off) < 0.05
    return int(not good)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.coverage", description=__doc__)
    parser.add_argument("--seed", type=int, default=0, help="of the records")
    parser.add_argument("--records", type=int, default=500, help="of every setting")
    parser.add_argument("--profiles", type=int, default=10, help="records held against a profile")
    parser.add_argument("--only", default="", help="settings whose name holds this")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--json", action="store_true", help="print the rows as JSON")
    return parser


def _show(rows: list[Covered], said: Console) -> None:
    table = Table(*HEADER)
    for row in rows:
        mark = "" if row.holds else " !"
        table.add_row(
            row.setting,
            row.parameter,
            f"{row.truth:.4g}",
            f"{row.interval:.1%}",
            f"{row.robust:.1%}{mark}",
            "" if row.oracle is None else "{:.1%}, {:.1%}".format(*row.oracle),
            str(row.missing or ""),
            str(row.one_sided or ""),
            row.kinds,
        )
    said.print(table)
    said.print(
        f"goal: {LOW:.0%} to {HIGH:.0%}, of the interval where the noise is white, of the robust "
        f"one always; {np.sum([not row.holds for row in rows])} of {len(rows)} miss it"
    )


if __name__ == "__main__":
    sys.exit(main())
