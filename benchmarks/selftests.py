"""``python -m benchmarks.selftests [NAME...]``: does the self-test of C see a wrong constant?

Each number in the C of every filter of the conformance battery is changed by a thousandth, in
double and in float, and the self-test is run. One compilation serves all numbers of a filter: they
stand in memory, where the test's own program changes one after another.
"""

import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.without_effect import without_effect
from tests.filters.battery import CASES
from tests.tuner.export_cases import tuned
from tuner.code.array_step import Step
from tuner.code.document import files
from tuner.code.form import ready
from tuner.code.literal import Precision
from tuner.code.refused import NoCounterpartError

_NUMBER = r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)f?\b"
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
        proven: those of the rest that no result depends on.
        idle: number of those that had no effect in any step that was looked at, not even doubled.
        hidden: lines of C with numbers that it does not show.
        seconds: of the processor, taken to write it.
    """

    name: str
    precision: Precision
    constants: int
    by_samples: int
    seen: int
    formulas: int
    shown: int
    proven: int
    idle: int
    hidden: list[str]
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
    step = Step(found.program) if found.program is not None else None
    proven = without_effect(step, steps.undetected) if step and steps else set()
    return Seen(
        case.name,
        precision,
        len(lines),
        sum(samples != 0 for samples, _ in rows[1:]),
        sum(both != 0 for _, both in rows[1:]),
        steps.constants if steps else 0,
        steps.detected if steps else 0,
        len(proven),
        steps.idle if steps else 0,
        [line for line, (_, both) in zip(lines, rows[1:], strict=True) if both == 0],
        taken,
    )


def changeable(source: str, real: Precision) -> tuple[str, list[str]]:
    """The same C with its numbers in memory, and the line of each of them.

    >>> text, lines = changeable("double twice(double x) { return 2.0 * x; }", "double")
    >>> text.splitlines()[1:3]
    ['double twice(double x) { return numbers[0] * x; }', 'double *place(int k)']
    """
    source = re.sub(r"/\*.*?\*/", "", source, flags=re.DOTALL)
    source = re.sub(rf"static const {real} (\w+)\[", rf"static {real} \1[", source)
    numbers: list[str] = []
    places: list[str] = []
    lines: list[str] = []

    def line_of(found: re.Match[str]) -> str:
        text = found.string
        return text[text.rfind("\n", 0, found.start()) + 1 : text.find("\n", found.end())].strip()

    def in_memory(found: re.Match[str]) -> str:
        if float(found[1]) == 0:
            return found[0]
        places.append(f"&numbers[{len(numbers)}]")
        numbers.append(found[0])
        lines.append(line_of(found))
        return f"numbers[{len(numbers) - 1}]"

    tables = re.compile(rf"static {real} (\w+)\[\d+\] = {{(.*?)}};", re.DOTALL)
    parts, end = [], 0
    for table in tables.finditer(source):
        parts += [re.sub(_NUMBER, in_memory, source[end : table.start()]), table[0]]
        end = table.end()
        for k, entry in enumerate(table[2].split(",")):
            value = re.search(_NUMBER, entry)
            if value and float(value[1]) != 0:
                places.append(f"&{table[1]}[{k}]")
                lines.append(f"{table[1]}[{k}] = {value[0]}")
    parts.append(re.sub(_NUMBER, in_memory, source[end:]))
    head = f"static {real} numbers[] = {{{', '.join(numbers) or '0'}}};"
    ends = [f"{real} *place(int k)", "{"]
    ends += [f"    static {real} *const places[] = {{{', '.join([*places, '0'])}}};"]
    return "\n".join([head, "".join(parts), *ends, "    return places[k];", "}", ""]), lines


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
    table = Table(
        *("filter", "in", "numbers", "by samples", "seen", "formulas", "shown", "proven"),
        *("idle", "CPU s"),
    )
    rows = []
    for row in all_judged(names):
        rows.append(row)
        of = (row.constants, row.by_samples, row.seen, row.formulas, row.shown, row.proven)
        table.add_row(row.name, row.precision, *map(str, of), str(row.idle), f"{row.seconds:.1f}")
        if names:
            console.print(*row.hidden, sep="\n", markup=False, highlight=False)
    console.print(table)
    for precision in ("double", "float"):
        own = [row for row in rows if row.precision == precision]
        total, before, seen, formulas, shown, proven, idle = (
            sum(getattr(row, part) for row in own)
            for part in ("constants", "by_samples", "seen", "formulas", "shown", "proven", "idle")
        )
        console.print(
            f"{precision}: {seen} of {total} numbers in C are seen, {before} by samples in a row; "
            f"{shown} of {formulas} constants in formulas show in single steps, {proven} have no "
            f"effect by proof, {idle} had none in any step looked at; "
            f"{max(row.seconds for row in own):.1f} s of a processor at most"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
