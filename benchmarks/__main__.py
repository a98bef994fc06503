"""``python -m benchmarks``: measure everything and print the table."""

import argparse
import json
import multiprocessing
import os
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from benchmarks import (
    accuracy,
    array_logs,
    batch,
    cliff,
    equations,
    extended,
    first_fit,
    gradients,
    long_records,
    native,
    others,
    peers_by_size,
    recordings,
    rest_record,
    single,
    starts,
    startup,
    tanaka,
    text_logs,
    unscented,
)
from benchmarks.baseline import Baseline, NoCompilerError, baseline
from benchmarks.by_c import native as c_is
from benchmarks.machine import machine
from benchmarks.page import page
from benchmarks.single import passes
from benchmarks.table import Row, as_json, show
from benchmarks.timing import interleave
from benchmarks.work import Q, R, Work

FULL, QUICK = Work(100_000, 15), Work(20_000, 5)


def main(arguments: list[str] | None = None) -> int:
    """Measure, print the table, and write the requested files."""
    asked = _parser().parse_args(arguments)
    os.environ["TUNER_NATIVE"] = "off"  # but for the part about it
    work, said = QUICK if asked.quick else FULL, Console(stderr=True)
    limit = _limit(said)
    before = _noise(work, limit)
    rows = _measure(work, limit, said)
    noise = max(before, _noise(work, limit))
    here = machine(limit)
    if asked.json:
        summary = {"schema": "benchmarks/1", "samples": work.samples, "noise": noise}
        print(json.dumps(summary | {"machine": asdict(here), "rows": as_json(rows)}, indent=2))
    else:
        show(rows, Console(width=None if sys.stdout.isatty() else 160))
        print(f"{here.words}; the time of one pass varied by {noise:.0%}")
    if asked.write:
        asked.write.write_text(page(rows, here, work.samples, noise), encoding="utf-8")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a fifth of the record, fewer rounds")
    parser.add_argument("--json", action="store_true", help="print JSON instead of the table")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the page in Markdown")
    return parser


def _limit(said: Console) -> Baseline | None:
    try:
        return baseline()
    except NoCompilerError as error:
        said.print(f"{error}; so ratios are to a NumPy loop", markup=False)
        return None


def _measure(work: Work, limit: Baseline | None, said: Console) -> list[Row]:
    sections: dict[str, Callable[[], list[Row]]] = {
        "passes, costs and gradients": lambda: single.rows(work, limit),
        "batches": lambda: batch.rows(work, limit),
        "accuracy": lambda: accuracy.rows(work, limit),
        "compilation and start": lambda: startup.rows(work),
        "a first fit": first_fit.rows,
        "a record at rest": rest_record.rows,
        "a long text log": _as_users_do(_afresh(text_logs.rows)),
        "long logs of arrays": _as_users_do(_afresh(array_logs.rows)),
        "the extended filter": lambda: extended.rows(limit),
        "compiled C": native.rows,
        "gradients by size": lambda: gradients.rows(limit),
        "long records": long_records.rows,
        "many recordings": _as_users_do(recordings.rows),
        "four starts": _as_users_do(_afresh(starts.rows)),
        "the unscented filter": unscented.rows,
        "equations": equations.rows,
        "Tanaka's regression": tanaka.rows,
        "the loop option": lambda: cliff.rows(work),
        "other libraries": lambda: others.rows(work, limit),
        "other libraries by size": peers_by_size.rows,
    }
    rows: list[Row] = []
    for name, section in sections.items():
        said.print(f"measuring {name} ...", highlight=False)
        rows += section()
    return rows


def _as_users_do(rows: Callable[[], list[Row]]) -> Callable[[], list[Row]]:
    """Rows with compiled C where that pays."""

    def measured() -> list[Row]:
        with c_is("auto"):
            return rows()

    return measured


def _afresh(rows: Callable[[], list[Row]]) -> Callable[[], list[Row]]:
    """Rows of a process of its own, as a search has, in place of one that has measured for long."""

    def measured() -> list[Row]:
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
            return pool.submit(rows).result()

    return measured


def _noise(work: Work, limit: Baseline | None) -> float:
    calls = passes(work)
    if limit is not None:
        calls["C"] = lambda: limit.forward(work.signal, R, Q)
    times = interleave(calls, 25)
    return max(map(times.noise, calls))


if __name__ == "__main__":
    sys.exit(main())
