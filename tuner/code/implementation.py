"""The code of one form of a filter: its declarations, its definitions, and its cost."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tuner.code.fields import Field
from tuner.code.literal import Precision, literal, type_of
from tuner.code.names import in_comment


@dataclass(frozen=True)
class Implementation:
    """A form of a filter in C.

    Attributes:
        stem: prefix of its types and functions.
        precision: of its real numbers.
        state, inputs, outputs, params: its fields; no params where they are numbers.
        declarations: lines of the header.
        definitions: lines of the source.
        operations: of a step.
    """

    stem: str
    precision: Precision
    state: list[Field]
    inputs: list[Field]
    outputs: list[Field]
    params: list[Field]
    declarations: list[str]
    definitions: list[str]
    operations: int


def declarations(
    stem: str,
    precision: Precision,
    parts: Iterable[tuple[str, str, Sequence[Field]]],
    tables: str | None,
) -> Iterator[str]:
    """The types and functions of a form.

    Args:
        stem: prefix of the names.
        precision: of real numbers.
        parts: the structs: their names, meanings, and fields.
        tables: the member for values derived from parameters; None without parameters.
    """
    for name, meaning, fields in parts:
        yield f"/* {meaning} */"
        yield "typedef struct {"
        yield from _members(fields, precision)
        yield f"}} {stem}_{name};"
        yield ""
    if tables is None:
        yield from ("/* Begin anew. */", f"void {stem}_init({stem}_state *state);", "")
    else:
        yield "/* Values that follow from the parameters, computed by set. */"
        yield "typedef struct {"
        yield f"    {tables}"
        yield f"}} {stem}_tables;"
        yield ""
        yield "/* The parameters as they were tuned. */"
        yield f"void {stem}_defaults({stem}_params *params);"
        yield ""
        yield "/* Take parameters over: call it first, and after a change. */"
        yield f"void {stem}_set({stem}_tables *tables, const {stem}_params *params);"
        yield ""
        yield "/* Begin anew. */"
        yield f"void {stem}_init({stem}_state *state, const {stem}_params *params);"
        yield ""
    yield "/* Take one sample. */"
    yield f"{step(stem, tables is not None)};"


def _members(fields: Sequence[Field], precision: Precision) -> Iterator[str]:
    if not fields:
        yield "    char none; /* nothing: C has no empty structs */"
    for field in fields:
        size = f"[{field.size}]" if field.shape else ""
        shape = " x ".join(map(str, field.shape)) if len(field.shape) > 1 else ""
        kept = f"upper half of {shape}, rows first" if field.half else f"{shape}, rows first"
        meaning = in_comment(field.meaning, 200).rstrip(".")
        words = "; ".join(w for w in (meaning, kept if shape else "") if w)
        note = f" /* {words} */" if words else ""
        yield f"    {type_of(field.kind, precision)} {field.name}{size};{note}"


def unused(lines: Sequence[str], names: Iterable[str]) -> Iterator[str]:
    """Statements for unused parameters of a function."""
    text = "\n".join(lines)
    for name in names:
        if f"{name}->" not in text:
            yield f"    (void){name};"


def step(stem: str, tunable: bool) -> str:
    """The declaration of the step function."""
    more = f", const {stem}_tables *tables" if tunable else ""
    return (
        f"void {stem}_step({stem}_state *state,\n"
        f"    const {stem}_input *in, {stem}_output *out{more})"
    )


def defaults(
    stem: str, precision: Precision, params: Sequence[Field], values: Sequence[np.ndarray]
) -> Iterator[str]:
    """The function that sets parameters to their tuned values."""
    yield f"void {stem}_defaults({stem}_params *params)"
    yield "{"
    for field, value in zip(params, values, strict=True):
        for index in field.entries():
            number = literal(value[index], field.kind, precision)
            yield f"    params->{field.place(index)} = {number};"
    yield from ("}", "")
