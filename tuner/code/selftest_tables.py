"""C of a self-test that fills structs from tables, and compares them with tables."""

from collections.abc import Iterator, Sequence

import numpy as np

from tuner.code.fields import Field
from tuner.code.flat import wrapped
from tuner.code.implementation import Implementation
from tuner.code.literal import Precision, literal


def comparison(stem: str, real: Precision) -> Iterator[str]:
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


def variables(code: Implementation) -> Iterator[str]:
    """The declarations of a function that runs the filter."""
    stem = code.stem
    for name in ("state", "input", "output"):
        yield f"    {stem}_{name} {name};"
    yield "    int off = 0;"
    if code.params:
        yield from (f"    {stem}_params params;", f"    {stem}_tables tables;")
        yield f"    {stem}_defaults(&params);"
        yield f"    {stem}_set(&tables, &params);"


def filled(part: str, fields: Sequence[Field], table: str, real: Precision) -> Iterator[str]:
    """A struct that is filled from row k of a table."""
    for at, (place, field) in enumerate(_places(part, fields)):
        yield f"        {place} = {_given(f'{table}[k][{at}]', field, real)};"


def stepped(code: Implementation) -> Iterator[str]:
    """A sample that is taken."""
    tables = ", &tables" if code.params else ""
    yield f"        {code.stem}_step(&state, &input, &output{tables});"


def compared(
    part: str,
    fields: Sequence[Field],
    stem: str,
    real: Precision,
    right: str,
    allowed: str,
    pad: str,
) -> Iterator[str]:
    """A struct that is compared with expected numbers, each within its tolerance."""
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


def stored(fields: Sequence[Field], arrays: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The stored entries of each field, ``(N, size)``."""
    found = []
    for field, array in zip(fields, arrays, strict=True):
        rows = np.asarray(array).reshape(len(array), -1)
        where = [int(np.ravel_multi_index(i, field.shape)) if i else 0 for i in field.entries()]
        entries = [rows[:, k] for k in where]
        found.append(np.stack(entries, axis=1) if entries else np.zeros((len(array), 0)))
    return found or [np.zeros((1, 0))]


def table(name: str, real: Precision, values: np.ndarray) -> Iterator[str]:
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
