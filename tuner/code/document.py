"""A filter as C files: header with its parameters, source, and self-test."""

from collections.abc import Sequence

from tuner.code.fields import Field
from tuner.code.files import Files
from tuner.code.form import Form
from tuner.code.implementation import Implementation
from tuner.code.selftest import selftest
from tuner.export.header import header as header_of
from tuner.export.tuned import Tuned

_USE = """
/*
 * Call init once, and step with every sample, in order. NaN is a missing measurement, so options
 * like -ffast-math, which take NaN away, are refused. Nothing is allocated, there are no globals,
 * and every step takes the same operations, whatever its sample is. Of MISRA C:2012 there are two
 * deviations, both advisory: 2.5, macros of numbers that not everybody needs, and 8.9, constant
 * tables that stand above the functions.
 */
"""
_FINITE = """
#if defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0)
#error "NaN is a missing sample: compile without -ffast-math and -ffinite-math-only."
#endif
"""


def files(tuned: Tuned, include: str, forms: Sequence[Form]) -> Files:
    """The files of a tuned filter.

    Args:
        tuned: its numbers.
        include: name of the header's file.
        forms: each form with its test samples, the main one first.
    """
    header, source = sources(tuned, include, [form.implementation for form in forms])
    return Files(header, source, selftest(include, forms))


def sources(tuned: Tuned, include: str, forms: Sequence[Implementation]) -> tuple[str, str]:
    """Header and source of a tuned filter.

    Args:
        tuned: its numbers.
        include: name of the header's file.
        forms: the main one first.
    """
    lines = _USE.strip().split("\n")
    if any(field.kind == "truth" for form in forms for field in _fields(form)):
        lines += ["#include <stdbool.h>", ""]
    lines += ["#ifdef __cplusplus", 'extern "C" {', "#endif"]
    for form in forms:
        lines += ["", *form.declarations]
    lines += ["", "/* 0, or the number of the first sample that is off; in a file of its own. */"]
    lines += [f"int {forms[0].stem}_selftest(void);", "", "#ifdef __cplusplus", "}", "#endif"]
    text = "\n".join(line for form in forms for line in ["", *form.definitions])
    head = ["/* Implementation by filter-tuner; do not edit it, export it again. */"]
    head += [f'#include "{include}"', "", "#include <math.h>"]
    if "bool " in text:
        head.append("#include <stdbool.h>")
    return header_of(tuned, lines), "\n".join([*head, _FINITE.rstrip(), text, ""])


def _fields(form: Implementation) -> list[Field]:
    return [*form.state, *form.inputs, *form.outputs, *form.params]
