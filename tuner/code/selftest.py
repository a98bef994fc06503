"""The self-test: a C function that compares outputs with expected ones."""

from collections.abc import Iterator, Sequence

import numpy as np

from tuner.code.fields import Field
from tuner.code.flat import wrapped
from tuner.code.form import Form
from tuner.code.literal import Precision, literal
from tuner.code.steps import Steps
from tuner.code.tried import Tried
from tuner.code.written import Written


def selftest(include: str, forms: Sequence[Form]) -> str:
    """A source file with a function that returns 0 if all forms pass.

    Args:
        include: name of the header's file.
        forms: the written code, and its test samples.
    """
    stem, file = forms[0].written.stem, include.rpartition(".")[0] or include
    lines = [
        "/*",
        " * Samples, and what filter-tuner's own filter makes of them; written by filter-tuner.",
        f" * {stem}_selftest() is 0, or the number of the first sample that is off. Alone:",
        f" * cc -DSELFTEST_MAIN {file}.c {file}_selftest.c -lm && ./a.out",
        " */",
        f'#include "{include}"',
        "",
        "#include <math.h>",
        "#ifdef SELFTEST_MAIN",
        "#include <stdio.h>",
        "#endif",
        "",
    ]
    for written, tried in forms:
        lines += _form(written, tried)
    calls = []
    for written, tried in forms:
        calls.append(f"{written.stem}_run_selftest()")
        if tried.steps is not None:
            calls.append(f"{written.stem}_step_selftest()")
    lines += [f"int {stem}_selftest(void)", "{", f"    int off = {calls[0]};"]
    for call in calls[1:]:
        lines += ["    if (off == 0) {", f"        off = {call};", "    }"]
    lines += ["    return off;", "}", "", "#ifdef SELFTEST_MAIN", *_MAIN.format(stem).splitlines()]
    return "\n".join([*lines, "#endif", ""])


_MAIN = """
int main(void)
{{
    const int off = {0}_selftest();
    if (off == 0) {{
        (void)puts("the filter does what it should");
    }} else {{
        (void)printf("sample %d is off\\n", off);
    }}
    return (off == 0) ? 0 : 1;
}}"""


def _form(written: Written, tried: Tried) -> Iterator[str]:
    stem, real = written.stem, written.precision
    begun = f"{stem}_init(&state{', &params' if written.params else ''});"
    yield from _off(stem, real)
    yield f"static int {stem}_run_selftest(void)"
    yield "{"
    yield from _table("samples", real, np.hstack(_flat(written.inputs, tried.samples)))
    for name, outputs in (("expected", tried.expected), ("allowed", tried.allowed)):
        yield from _table(name, real, np.hstack(_flat(written.outputs, outputs)))
    for name, state in (
        ("start", tried.start),
        ("allowed_start", tried.allowed_start),
        ("after", tried.after),
        ("allowed_after", tried.allowed_after),
    ):
        alone = [np.asarray(one)[None] for one in state]
        yield from _table(name, real, np.hstack([x[0] for x in _flat(written.state, alone)]))
    yield from _locals(written)
    yield "    int first = 1;"
    yield f"    {begun}"
    yield from _compared("state", written.state, stem, real, "start", "allowed_start", "    ")
    yield f"    for (int k = 0; (k < {len(tried.samples[0])}) && (off == 0); k++) {{"
    yield from _placed("input", written.inputs, "samples", real)
    yield from _stepped(written)
    yield from _compared(
        "output", written.outputs, stem, real, "expected[k]", "allowed[k]", "        "
    )
    yield "        first = k + 1;"
    yield "    }"
    yield from _compared("state", written.state, stem, real, "after", "allowed_after", "    ")
    yield "    return (off != 0) ? first : 0;"
    yield from ("}", "")
    if tried.steps is not None:
        yield from _steps(written, tried.steps, len(tried.samples[0]))


def _steps(written: Written, steps: Steps, before: int) -> Iterator[str]:
    """The function of single steps from given states, which are numbered on."""
    stem, real, count = (
        written.stem,
        written.precision,
        len(steps.states[0] if steps.states else steps.samples[0]),
    )
    yield from _told(steps)
    yield f"static int {stem}_step_selftest(void)"
    yield "{"
    for name, fields, arrays in (
        ("given", written.state, steps.states),
        ("samples", written.inputs, steps.samples),
        ("expected", written.outputs, steps.expected),
        ("allowed", written.outputs, steps.allowed),
        ("after", written.state, steps.after),
        ("allowed_after", written.state, steps.allowed_after),
    ):
        yield from _table(name, real, np.hstack(_flat(fields, arrays)))
    yield from _locals(written)
    yield "    int first = 0;"
    yield f"    for (int k = 0; (k < {count}) && (off == 0); k++) {{"
    yield from _placed("state", written.state, "given", real)
    yield from _placed("input", written.inputs, "samples", real)
    yield from _stepped(written)
    for part, fields, right, most in (
        ("output", written.outputs, "expected[k]", "allowed[k]"),
        ("state", written.state, "after[k]", "allowed_after[k]"),
    ):
        yield from _compared(part, fields, stem, real, right, most, "        ")
    yield f"        first = {before + 1} + k;"
    yield "    }"
    yield "    return (off != 0) ? first : 0;"
    yield from ("}", "")


def _told(steps: Steps) -> Iterator[str]:
    """What the single steps show, as a comment."""
    yield "/*"
    yield " * Single steps from given states."
    if steps.constants:
        yield f" * Of {steps.constants} constants in its formulas {steps.shown} show in them:"
        yield " * changed by a thousandth, each of these moves a result further than is allowed."
    if steps.shown < steps.constants:
        yield f" * The other {steps.constants - steps.shown} move none beyond rounding,"
        idle = f"; {steps.idle} not even when doubled" if steps.idle else ""
        yield f" * in {steps.looked_at} steps from states near and far{idle}."
    yield " */"


def _off(stem: str, real: Precision) -> Iterator[str]:
    """The function that compares two numbers."""
    fabs = "fabs" if real == "double" else "fabsf"
    yield f"static int {stem}_off(const {real} found, const {real} right, const {real} allowed)"
    yield "{"
    yield "    int off = 1;"
    yield f"    if ({fabs}(found - right) <= allowed) {{"
    yield from ("        off = 0;", "    }")
    yield "    if ((isnan(right) != 0) && (isnan(found) != 0)) {"
    yield from ("        off = 0;", "    }", "    return off;")
    yield from ("}", "")


def _locals(written: Written) -> Iterator[str]:
    stem = written.stem
    for name in ("state", "input", "output"):
        yield f"    {stem}_{name} {name};"
    yield "    int off = 0;"
    if written.params:
        yield from (f"    {stem}_params params;", f"    {stem}_tables tables;")
        yield f"    {stem}_defaults(&params);"
        yield f"    {stem}_set(&tables, &params);"


def _placed(part: str, fields: Sequence[Field], table: str, real: Precision) -> Iterator[str]:
    for at, (place, field) in enumerate(_places(part, fields)):
        yield f"        {place} = {_given(f'{table}[k][{at}]', field, real)};"


def _stepped(written: Written) -> Iterator[str]:
    tables = ", &tables" if written.params else ""
    yield f"        {written.stem}_step(&state, &input, &output{tables});"


def _compared(
    part: str,
    fields: Sequence[Field],
    stem: str,
    real: Precision,
    right: str,
    allowed: str,
    pad: str,
) -> Iterator[str]:
    at = 0
    for field in fields:
        place = "i" if at == 0 else f"{at} + i"
        if not field.shape:
            found = _found(f"{part}.{field.name}", field, real)
            ends = f"{right}[{at}], {allowed}[{at}]"
            yield wrapped(f"{pad}off |= {stem}_off({found}, {ends});")
        else:
            found = _found(f"{part}.{field.name}[i]", field, real)
            ends = f"{right}[{place}], {allowed}[{place}]"
            yield f"{pad}for (int i = 0; i < {field.size}; i++) {{"
            yield f"{pad}    off |= {stem}_off({found}, {ends});"
            yield f"{pad}}}"
        at += field.size


def _found(place: str, field: Field, real: Precision) -> str:
    if field.kind == "truth":
        return f"{place} ? {literal(1, 'real', real)} : {literal(0, 'real', real)}"
    return place if field.kind == "real" else f"({real}){place}"


def _given(text: str, field: Field, real: Precision) -> str:
    if field.kind == "truth":
        return f"{text} > {literal(0.5, 'real', real)}"
    return text if field.kind == "real" else f"(int){text}"


def _places(part: str, fields: Sequence[Field]) -> Iterator[tuple[str, Field]]:
    for field in fields:
        for index in field.entries():
            yield f"{part}.{field.place(index)}", field


def _flat(fields: Sequence[Field], arrays: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The stored entries of each field, ``(N, size)``."""
    found = []
    for field, array in zip(fields, arrays, strict=True):
        rows = np.asarray(array).reshape(len(array), -1)
        where = [int(np.ravel_multi_index(i, field.shape)) if i else 0 for i in field.entries()]
        entries = [rows[:, k] for k in where]
        found.append(np.stack(entries, axis=1) if entries else np.zeros((len(array), 0)))
    return found or [np.zeros((1, 0))]


def _table(name: str, real: Precision, values: np.ndarray) -> Iterator[str]:
    """A constant array of one or two axes, never empty, as C requires."""
    if not values.size:
        values = np.zeros((*values.shape[:-1], 1))
    sizes = "".join(f"[{n}]" for n in values.shape)
    yield f"    static const {real} {name}{sizes} = {{"
    rows = values if values.ndim == 2 else values[None]
    for k, row in enumerate(rows):
        text = ", ".join(literal(x, "real", real) for x in row)
        end = "," if k + 1 < len(rows) else ""
        yield _row(f"{{{text}}}{end}" if values.ndim == 2 else text)
    yield "    };"


def _row(text: str) -> str:
    """A row of numbers in short lines."""
    lines, line = [], "       "
    for part in text.split(" "):
        if len(line) + len(part) + 1 > 100:
            lines.append(line)
            line = "           "
        line += f" {part}"
    return "\n".join([*lines, line])
