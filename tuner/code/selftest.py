"""The self-test: a C function that compares outputs with expected ones."""

from collections.abc import Iterator, Sequence

import numpy as np

from tuner.code.form import Form
from tuner.code.implementation import Implementation
from tuner.code.reference import Reference
from tuner.code.selftest_tables import (
    compared,
    comparison,
    filled,
    stepped,
    stored,
    table,
    variables,
)
from tuner.code.steps import Steps


def selftest(include: str, forms: Sequence[Form]) -> str:
    """A source file with a function that returns 0 if all forms pass.

    Args:
        include: name of the header's file.
        forms: the written code, and its test samples.
    """
    stem, file = forms[0].implementation.stem, include.rpartition(".")[0] or include
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
    for code, data in forms:
        lines += _form(code, data)
    calls = []
    for code, data in forms:
        calls.append(f"{code.stem}_run_selftest()")
        if data.steps is not None:
            calls.append(f"{code.stem}_step_selftest()")
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


def _form(code: Implementation, data: Reference) -> Iterator[str]:
    stem, real = code.stem, code.precision
    begun = f"{stem}_init(&state{', &params' if code.params else ''});"
    yield from comparison(stem, real)
    yield f"static int {stem}_run_selftest(void)"
    yield "{"
    yield from table("samples", real, np.hstack(stored(code.inputs, data.samples)))
    for name, outputs in (("expected", data.expected), ("allowed", data.allowed)):
        yield from table(name, real, np.hstack(stored(code.outputs, outputs)))
    for name, state in (
        ("start", data.start),
        ("allowed_start", data.allowed_start),
        ("after", data.after),
        ("allowed_after", data.allowed_after),
    ):
        alone = [np.asarray(one)[None] for one in state]
        yield from table(name, real, np.hstack([x[0] for x in stored(code.state, alone)]))
    yield from variables(code)
    yield "    int first = 1;"
    yield f"    {begun}"
    yield from compared("state", code.state, stem, real, "start", "allowed_start", "    ")
    yield f"    for (int k = 0; (k < {len(data.samples[0])}) && (off == 0); k++) {{"
    yield from filled("input", code.inputs, "samples", real)
    yield from stepped(code)
    yield from compared("output", code.outputs, stem, real, "expected[k]", "allowed[k]", "        ")
    yield "        first = k + 1;"
    yield "    }"
    yield from compared("state", code.state, stem, real, "after", "allowed_after", "    ")
    yield "    return (off != 0) ? first : 0;"
    yield from ("}", "")
    if data.steps is not None:
        yield from _steps(code, data.steps, len(data.samples[0]))


def _steps(code: Implementation, steps: Steps, before: int) -> Iterator[str]:
    """The function of single steps from given states, which are numbered on."""
    stem, real, count = (
        code.stem,
        code.precision,
        len(steps.states[0] if steps.states else steps.samples[0]),
    )
    yield from _comment(steps)
    yield f"static int {stem}_step_selftest(void)"
    yield "{"
    for name, fields, arrays in (
        ("given", code.state, steps.states),
        ("samples", code.inputs, steps.samples),
        ("expected", code.outputs, steps.expected),
        ("allowed", code.outputs, steps.allowed),
        ("after", code.state, steps.after),
        ("allowed_after", code.state, steps.allowed_after),
    ):
        yield from table(name, real, np.hstack(stored(fields, arrays)))
    yield from variables(code)
    yield "    int first = 0;"
    yield f"    for (int k = 0; (k < {count}) && (off == 0); k++) {{"
    yield from filled("state", code.state, "given", real)
    yield from filled("input", code.inputs, "samples", real)
    yield from stepped(code)
    for part, fields, right, most in (
        ("output", code.outputs, "expected[k]", "allowed[k]"),
        ("state", code.state, "after[k]", "allowed_after[k]"),
    ):
        yield from compared(part, fields, stem, real, right, most, "        ")
    yield f"        first = {before + 1} + k;"
    yield "    }"
    yield "    return (off != 0) ? first : 0;"
    yield from ("}", "")


def _comment(steps: Steps) -> Iterator[str]:
    """A comment on the single steps and the constants that show in them."""
    yield "/*"
    yield " * Single steps from given states."
    if steps.constants:
        yield f" * Of {steps.constants} constants in its formulas {steps.detected} show in them:"
        yield " * changed by a thousandth, each of these moves a result further than is allowed."
    if steps.detected < steps.constants:
        yield f" * The other {steps.constants - steps.detected} move none beyond rounding,"
        idle = f"; {len(steps.idle)} have no effect there" if steps.idle else ""
        yield f" * in {steps.looked_at} steps from states near and far{idle}."
    yield " */"
