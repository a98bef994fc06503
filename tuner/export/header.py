"""The C header: constants for double and for float, and lines of code."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tuner.export.arrays import labelled
from tuner.export.document import flat, head, label, nested, tuned_from
from tuner.export.literals import double, single, value_of
from tuner.export.tuned import Tuned

_LINE = re.compile(r"^ \* ([\w.]+): (.+)$", re.MULTILINE)
_QUANTITY = re.compile(r"^/\* quantity: (.+) \*/$", re.MULTILINE)
_DEFINE = re.compile(r"^#define (\w+) (.+)$", re.MULTILINE)
# These would end or begin a comment, or be a trigraph; JSON has a second way to write each.
_UNSAFE = re.compile(r"(?<=\*)/|/(?=\*)|(?<=\?)\?")


def dump(tuned: Tuned) -> bytes:
    """A header in ASCII for C99 and C++17: the numbers alone; it includes nothing."""
    return header(tuned, ()).encode("ascii")


def header(tuned: Tuned, code: Sequence[str]) -> str:
    """The header with lines of code, ASCII too, after its numbers."""
    guard = f"{tuned.name.upper()}_HEADER_INCLUDED"
    lines = [*_numbers(tuned, guard), *(["", *code] if code else []), "", f"#endif /* {guard} */"]
    return "\n".join([*lines, ""])


def _numbers(tuned: Tuned, guard: str) -> Iterator[str]:
    prefix = tuned.name.upper()
    yield "/*"
    yield " * A tuned filter, written by filter-tuner; do not edit it, export it again."
    yield " *"
    for key, value in flat(head(tuned)).items():
        yield f" * {key}: {_comment(value)}"
    yield " *"
    yield " * Each number is a macro for double, and one for float whose name ends in _F."
    yield " * Vectors and matrices are initialisers, rows first. Units stand above; time is in s."
    yield " */"
    yield from (f"#ifndef {guard}", f"#define {guard}", "")
    yield "/* The sample time, s. */"
    yield from _macros(f"{prefix}_DT", np.array(tuned.dt))
    yield from ("", "/* The states and their places. */")
    yield f"#define {prefix}_STATES {len(tuned.states)}"
    for place, state in enumerate(tuned.states):
        yield f"#define {prefix}_STATE_{state.upper()} {place}"
    for quantity in tuned.quantities:
        yield from ("", f"/* quantity: {_comment(label(quantity))} */")
        yield from _macros(f"{prefix}_{quantity.name.upper()}", quantity.value)


def load(data: bytes) -> Tuned:
    """The tuned filter that :func:`dump` wrote, from its macros for double and its comments."""
    text = data.decode("ascii").replace("\r\n", "\n").replace("\\\n", "")
    if "_HEADER_INCLUDED */" not in text:
        raise ValueError("it is cut short")
    above = {key: json.loads(value) for key, value in _LINE.findall(text.partition("*/")[0])}
    if "name" not in above:
        raise ValueError("its first comment does not name a tuned filter")
    macros = dict(_DEFINE.findall(text))
    labels = [json.loads(line) for line in _QUANTITY.findall(text)]
    arrays = {entry["name"]: _value(macros, above["name"], entry["name"]) for entry in labels}
    above["dt"] = float(_value(macros, above["name"], "dt"))
    return tuned_from(nested(above), [labelled(entry, arrays) for entry in labels])


def _value(macros: Mapping[str, str], *parts: str) -> NDArray[np.float64]:
    """The numbers of a macro."""
    name = "_".join(parts).upper()
    if name not in macros:
        raise ValueError(f"it does not define {name}")
    return value_of(macros[name])


def _comment(value: Any) -> str:
    """JSON that stays on its line and inside its comment, whatever its text."""
    return _UNSAFE.sub(lambda found: f"\\u{ord(found[0]):04x}", json.dumps(value))


def _macros(name: str, value: NDArray[np.float64]) -> Iterator[str]:
    """The lines that define one value."""
    if value.shape:
        rows, columns = (*value.shape, 1)[:2]
        yield f"#define {name}_ROWS {rows}"
        yield f"#define {name}_COLS {columns}"
    yield f"#define {name} {double(value)}"
    narrow = single(value)
    if narrow is None:
        yield f"/* {name}_F is left out: float cannot hold it in full precision. */"
    else:
        yield f"#define {name}_F {narrow}"
