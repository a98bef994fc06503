"""tuner compare: runs against their paper, or fits against each other, side by side."""

import csv as csv_
import json as json_
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeAlias

from tuner.cli.fit_comparison import comparison_table
from tuner.cli.tables import number_text, show_grid
from tuner.export.cells import inert
from tuner.run.comparison import Comparison
from tuner.run.result import Result, read_result

_Read: TypeAlias = tuple[str, Result, list[Comparison]]


def show(runs: list[Path], tol: str | None, *, json: bool, md: bool, csv: bool) -> int:
    """Print the comparison rows of runs, and what fits are worth.

    Returns:
        1 if a number lies outside its tolerance, otherwise 0.

    Raises:
        ValueError: for a run without a result, or a tolerance that is none.
    """
    tolerance = None if tol is None else parse_tolerance(tol)
    results = [read_result(run) for run in runs]
    tables = [result.comparisons for result in results]
    names = [run.name or str(run) for run in runs]
    rows = [row for table in tables for row in table]
    if json:
        pairs = zip(names, results, tables, strict=True)
        print(json_.dumps(_document(list(pairs), tolerance), indent=1))
    else:
        fitted = [(n, r) for n, r in zip(names, results, strict=True) if r.fit is not None]
        if rows or not fitted:
            _print("Comparison", _grid(names, tables, tolerance), md=md, csv=csv)
        if fitted:
            _print("Fits", comparison_table(*zip(*fitted, strict=True)), md=md, csv=csv)
        if len({result.log.sha256 for _, result in fitted}) > 1:
            print(
                "tuner: these fits are of different recordings; compare their tests, not errors",
                file=sys.stderr,
            )
    return 0 if all(row.within(tolerance) for row in rows) else 1


def parse_tolerance(text: str) -> float:
    """A tolerance such as ``5%`` or ``0.05``.

    Raises:
        ValueError: for anything else, and for negative numbers.
    """
    try:
        value = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        value = -1.0
    if not 0 <= value < math.inf:
        raise ValueError(f"--tol {text} is no tolerance; write 5% or 0.05")
    return value


def _document(runs: Sequence[_Read], tolerance: float | None) -> dict[str, Any]:
    return {
        "schema": "tuner.compare/1",
        "runs": [
            {
                "run": name,
                "study": result.study,
                "fit": None if result.fit is None else result.fit.model_dump(mode="json"),
                "rows": [
                    asdict(row) | {"verdict": row.verdict.value, "within": row.within(tolerance)}
                    for row in table
                ],
            }
            for name, result, table in runs
        ],
    }


def _grid(
    names: list[str], tables: list[list[Comparison]], tolerance: float | None
) -> list[list[str]]:
    """A header and a line per quantity: the paper's number, then each run's and its verdict."""
    quantities = list(dict.fromkeys(row.quantity for table in tables for row in table))
    lines = [["quantity", "where", "unit", "paper"]]
    for name in names:
        lines[0] += [name, "verdict"] if len(names) > 1 else ["ours", "verdict", "note"]
    for quantity in quantities:
        found = [next((r for r in table if r.quantity == quantity), None) for table in tables]
        first = next(row for row in found if row is not None)
        line = [quantity, first.where, first.unit, number_text(first.paper)]
        for row in found:
            verdict = "" if row is None else _verdict(row, tolerance)
            line += [number_text(row.ours if row else None), verdict]
            line += [row.note] if row is not None and len(names) == 1 else []
        lines.append(line)
    return lines


def _verdict(row: Comparison, tolerance: float | None) -> str:
    if tolerance is None or row.tolerance is None or row.deviation is None:
        return row.verdict.value
    return "match" if row.within(tolerance) else "differs"


def _print(title: str, lines: list[list[str]], *, md: bool, csv: bool) -> None:
    if csv:
        csv_.writer(sys.stdout, lineterminator="\n").writerows(
            [[inert(cell) for cell in line] for line in lines]
        )
    elif md:
        body = [[cell.replace("|", "\\|") for cell in line] for line in lines]
        body.insert(1, ["---"] * len(lines[0]))
        print("\n".join(f"| {' | '.join(line)} |" for line in body))
    else:
        show_grid(title, lines)
