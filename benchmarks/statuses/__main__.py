"""``python -m benchmarks.statuses``: solve all, judge all, print the table."""

import argparse
import json
import multiprocessing
import sys
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict

from rich.console import Console
from rich.table import Table

from benchmarks.statuses.battery import SLOW, Part, solved
from benchmarks.statuses.judge import Verdict

COLUMNS: dict[str, Callable[[Verdict], bool]] = {
    "wrong": lambda v: v.wrong and not v.agreed,
    "wrong, agreed": lambda v: v.wrong and v.agreed,
    "lower near by": lambda v: v.near,
    "alarm": lambda v: v.alarm and not v.differs,
    "starts differ": lambda v: v.differs,
    "false flat": lambda v: v.lies > 0,
    "flat unsaid": lambda v: v.silent,
    "error": lambda v: v.raised,
}
GOALS = {"wrong": 0.01, "lower near by": 0.01, "alarm": 0.03, "false flat": 0.01}


def main(arguments: list[str] | None = None) -> int:
    """Run the battery; 1 where a goal is missed."""
    asked = _parser().parse_args(arguments)
    begun = time.perf_counter()
    parts = [
        Part(asked.seed, asked.share, asked.slow, asked.family, i, asked.jobs)
        for i in range(asked.jobs)
    ]
    found = [verdict for each in _apart(parts) for verdict in each]
    if asked.json:
        print(json.dumps([asdict(verdict) for verdict in found], indent=1))
    else:
        said = Console(width=None if sys.stdout.isatty() else 150)
        _show(found, said, examples=asked.examples)
        said.print(f"{len({v.case for v in found})} problems, {time.perf_counter() - begun:.0f} s")
    return int(any(_share(found, name) > goal for name, goal in GOALS.items()))


def _apart(parts: list[Part]) -> list[list[Verdict]]:
    if len(parts) == 1:
        return [solved(parts[0])]
    # Spawned, as JAX does not survive a fork.
    with ProcessPoolExecutor(len(parts), multiprocessing.get_context("spawn")) as pool:
        return list(pool.map(solved, parts))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.statuses", description=__doc__)
    parser.add_argument("--seed", type=int, default=0, help="of the problems")
    parser.add_argument("--share", type=float, default=1.0, help="of every kind's problems")
    parser.add_argument("--family", help="one family alone")
    parser.add_argument("--slow", type=int, default=SLOW, help="slow solvers take every n-th")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--examples", type=int, default=3, help="named of every fault")
    parser.add_argument("--json", action="store_true", help="print all verdicts as JSON")
    return parser


def _share(found: list[Verdict], column: str) -> float:
    return sum(map(COLUMNS[column], found)) / max(len(found), 1)


def _show(found: list[Verdict], said: Console, *, examples: int) -> None:
    table = Table("family", "solver", "ends", *COLUMNS)
    groups: dict[tuple[str, str], list[Verdict]] = {}
    for verdict in found:
        for key in ((verdict.family, verdict.solver), ("in all", verdict.solver), ("in all", "")):
            groups.setdefault(key, []).append(verdict)
    for (family, solver), ends in sorted(groups.items()):
        counts = [str(sum(map(has, ends)) or "") for has in COLUMNS.values()]
        table.add_row(family, solver, str(len(ends)), *counts)
    said.print(table)
    statuses = Counter(verdict.status for verdict in found).most_common()
    said.print("; ".join(f"{count} {status}" for status, count in statuses))
    for name, has in COLUMNS.items():
        goal = f" (goal {GOALS[name]:.0%})" if name in GOALS else ""
        faulty = [v for v in found if has(v)]
        named = "; ".join(
            f"{v.case} {v.solver}: {v.status}, gap {v.gap:.2g}" for v in faulty[:examples]
        )
        said.print(f"{name}: {_share(found, name):.1%}{goal}  {named}", highlight=False)


if __name__ == "__main__":
    sys.exit(main())
