"""A filter as files of C: the header with its numbers, the source, the self-test."""

from collections.abc import Sequence
from dataclasses import dataclass

from tuner.code.fields import Field
from tuner.code.form import Form
from tuner.code.selftest import selftest
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

    @property
    def whole(self) -> str:
        """Header and source as one text."""
        lines = self.source.splitlines(keepends=True)
        return self.header + "".join(line for line in lines if not line.startswith('#include "'))


def files(tuned: Tuned, include: str, forms: Sequence[Form]) -> Files:
    """The files of a tuned filter.

    Args:
        tuned: its numbers.
        include: name of the header's file.
        forms: each form with what it is tried on, the main one first.
    """
    name = include.rpartition(".")[0] or include
    stem = forms[0][0].stem
    lines = [*_USE.strip().split("\n")]
    if any(field.kind == "truth" for w, _ in forms for field in _fields(w)):
        lines += ["#include <stdbool.h>", ""]
    lines += ["#ifdef __cplusplus", 'extern "C" {', "#endif"]
    for written, _ in forms:
        lines += ["", *written.declarations]
    lines += ["", f"/* 0, or the number of the first sample that is off; in {name}_selftest.c. */"]
    lines += [f"int {stem}_selftest(void);", "", "#ifdef __cplusplus", "}", "#endif"]
    body = [
        "/* Written by filter-tuner; do not edit it, export it again. */",
        f'#include "{include}"',
    ]
    body += ["", "#include <math.h>"]
    text = "\n".join(line for written, _ in forms for line in ["", *written.definitions])
    if "bool " in text:
        body.append("#include <stdbool.h>")
    return Files(
        header(tuned, lines),
        "\n".join([*body, _FINITE.rstrip(), text, ""]),
        selftest(include, name, forms),
    )


def _fields(written: Written) -> list[Field]:
    return [*written.state, *written.inputs, *written.outputs, *written.params]
