"""A filter as files of C: the header with its numbers, the source, the self-test."""

from collections.abc import Sequence
from dataclasses import dataclass

from tuner.code.selftest import selftest
from tuner.code.tried import Tried
from tuner.code.written import Written
from tuner.export.header import header
from tuner.export.tuned import Tuned

_USE = """
/*
 * Call init once, and step with every sample, in order. NaN is a missing measurement, so options
 * like -ffast-math, which take NaN away, are refused. Nothing is allocated, there are no globals,
 * and every step takes the same operations, whatever its sample is.
 */
"""
_FINITE = """
#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0)
#error "NaN is a missing sample: compile without -ffast-math and -ffinite-math-only."
#endif
"""


@dataclass(frozen=True)
class Files:
    """Text of C.

    Attributes:
        header: numbers, types and functions.
        source: the functions.
        selftest: what tries them.
    """

    header: str
    source: str
    selftest: str


def files(tuned: Tuned, name: str, forms: Sequence[tuple[Written, Tried]]) -> Files:
    """The files of a tuned filter.

    Args:
        tuned: its numbers.
        name: of the files, without a suffix.
        forms: each form with what it is tried on, the main one first.
    """
    stem = forms[0][0].stem
    lines = [*_USE.strip().split("\n")]
    if any(field.kind == "truth" for w, _ in forms for field in _fields(w)):
        lines += ["#include <stdbool.h>", ""]
    lines += ["#ifdef __cplusplus", 'extern "C" {', "#endif"]
    for written, _ in forms:
        lines += ["", *written.declarations]
    lines += ["", f"/* 0, or the number of the first sample that is off; in {name}_selftest.c. */"]
    lines += [f"int {stem}_selftest(void);", "", "#ifdef __cplusplus", "}", "#endif"]
    body = [f"/* Written by filter-tuner; do not edit it, export it again. */", f'#include "{name}.h"']
    body += ["", "#include <math.h>"]
    text = "\n".join(line for written, _ in forms for line in ["", *written.definitions])
    if "bool " in text:
        body.append("#include <stdbool.h>")
    return Files(
        header(tuned, lines),
        "\n".join([*body, _FINITE.rstrip(), text, ""]),
        selftest(name, forms),
    )


def _fields(written: Written):  # type: ignore[no-untyped-def]
    return [*written.state, *written.inputs, *written.outputs, *written.params]
