"""``python -m benchmarks.selftests [NAME...]``: does the self-test of C see a wrong constant?

Each number in the C of every filter of the conformance battery is changed by a thousandth, in
double and in float, and the self-test is run. One compilation serves all numbers of a filter: they
stand in memory, where the test's own program changes one after another. What the numbers do that no
test sees is found out one by one (:mod:`benchmarks.effects`), and printed with names given.
"""

import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import jax
import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.effects import Effect, Kind, effects
from benchmarks.numbers_in_c import Changed, changeable
from tests.filters.battery import CASES
from tests.tuner.export_cases import tuned
from tuner.code.array_step import Step
from tuner.code.document import files
from tuner.code.form import ready
from tuner.code.literal import Precision
from tuner.code.refused import NoCounterpartError

_KINDS: tuple[Kind, ...] = get_args(Kind)
_DRIVER = """
#include "{stem}_selftest.c"
#include <stdio.h>
{real} *place(int k);
int main(void)
{{
    printf("%d %d\\n", {stem}_run_selftest(), {stem}_selftest());
    for (int k = 0; place(k) != 0; k++) {{
        const {real} before = *place(k);
        *place(k) = before * ({real})1.001;
        printf("%d %d\\n", {stem}_run_selftest(), {stem}_selftest());
        *place(k) = before;
    }}
    return 0;
}}
"""


@dataclass(frozen=True)
class Seen:
    """What a self-test sees.

    Attributes:
        name, precision: of the filter.
        constants: numbers in its C.
        by_samples: those that its samples in a row show.
        seen: those that it shows.
        formulas: constants in the formulas of a step, each where it is used; 0: not searched.
        shown: those that its single steps show.
        effects: of the numbers in its C that it does not show.
        seconds: of the processor, taken to write it.
    """

    name: str
    precision: Precision
    constants: int
    by_samples: int
    seen: int
    formulas: int
    shown: int
    effects: list[Effect]
    seconds: float


def judged(case: Any, precision: Precision) -> Seen:
    """What the self-test of a case of the battery sees."""
    stem = re.sub(r"\W+", "_", case.name).strip("_").lower()[:25].strip("_")
    record = jax.tree.map(np.asarray, case.inputs(case.measured))
    begun = time.process_time()
    found = ready(case.filter, case.build(case.point), record, precision)
    form = found.form(stem)
    taken = time.process_time() - begun
    text = files(tuned(name=stem), f"{stem}.h", [form])
    source, lines = changeable(text.source, precision)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        implemented = (form.implementation, text.header, source, folder)
        (folder / f"{stem}.h").write_text(text.header)
        (folder / f"{stem}.c").write_text(source)
        (folder / f"{stem}_selftest.c").write_text(text.selftest)
        (folder / "main.c").write_text(_DRIVER.format(stem=stem, real=precision))
        command = ["cc", "-std=c99", "-O1", "-w", f"{stem}.c", "main.c", "-o", "main", "-lm"]
        subprocess.run(command, cwd=folder, check=True)
        told = subprocess.run(["./main"], cwd=folder, check=True, capture_output=True, text=True)
        rows = [tuple(map(int, line.split())) for line in told.stdout.splitlines()]
        if rows[0] != (0, 0) or len(rows) != 1 + len(lines):
            raise AssertionError(
                f"{case.name}, {precision}: {rows[0]}, {len(rows) - 1} of {len(lines)}"
            )
        steps = form.reference.steps
        hidden = {k: line for k, line in enumerate(lines) if rows[1 + k][1] == 0}
        rest: list[Effect] = []
        if hidden and steps and found.program is not None:
            plain, wide = Changed(*implemented), Changed(*implemented, wide=True)
            step = Step(found.program)
            rest = list(effects(step, steps.around, steps.undetected, plain, wide, hidden))
    return Seen(
        case.name,
        precision,
        len(lines),
        sum(samples != 0 for samples, _ in rows[1:]),
        sum(both != 0 for _, both in rows[1:]),
        steps.constants if steps else 0,
        steps.detected if steps else 0,
        rest,
        taken,
    )


def all_judged(names: list[str]) -> Iterator[Seen]:
    """Every case of the battery that has C."""
    for case in CASES:
        if names and case.name not in names:
            continue
        for precision in ("double", "float"):
            try:
                yield judged(case, precision)
            except NoCounterpartError:
                continue


def main(names: list[str]) -> None:
    """Print what is seen and what is not."""
    console = Console(width=140)
    table = Table("filter", "in", "numbers", "by samples", "seen", *_KINDS, "CPU s")
    rows = []
    for row in all_judged(names):
        rows.append(row)
        counts = (row.constants, row.by_samples, row.seen, *_counted(row))
        table.add_row(row.name, row.precision, *map(str, counts), f"{row.seconds:.1f}")
        if names:
            for one in row.effects:
                text = f"{one.kind}, {one.multiple:.2g} x tolerance: {one.line}"
                console.print(text, markup=False, highlight=False)
    console.print(table)
    for precision in ("double", "float"):
        own = [row for row in rows if row.precision == precision]
        total, before, seen, formulas, shown = (
            sum(getattr(row, part) for row in own)
            for part in ("constants", "by_samples", "seen", "formulas", "shown")
        )
        kinds = np.sum([_counted(row) for row in own], axis=0)
        rest = ", ".join(f"{count} {kind}" for count, kind in zip(kinds, _KINDS, strict=True))
        console.print(
            f"{precision}: {seen} of {total} numbers in C are seen, {before} by samples in a row; "
            f"of the rest: {rest}; {shown} of {formulas} constants in formulas show in single "
            f"steps; {max(row.seconds for row in own):.1f} s of a processor at most"
        )


def _counted(row: Seen) -> list[int]:
    return [sum(one.kind == kind for one in row.effects) for kind in _KINDS]


if __name__ == "__main__":
    main(sys.argv[1:])
