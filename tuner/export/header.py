"""The C header: constants for double and for float, and the filters that are known in C."""

import json
import re
from collections.abc import Iterator, Mapping
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tuner.export.arrays import labelled
from tuner.export.document import flat, head, label, nested, tuned_from
from tuner.export.literals import double, single, value_of
from tuner.export.tuned import Tuned

_NOISE = {"R": (), "Q": (), "P0": (2, 2)}
_NEEDS: dict[str, dict[str, tuple[int, ...]]] = {
    "AccelerometerFilter": _NOISE,
    "GyroscopeFilter": _NOISE,
    "FixedGainFilter": {"K1": (), "K2": ()},
}
_LINE = re.compile(r"^ \* ([\w.]+): (.+)$", re.MULTILINE)
_QUANTITY = re.compile(r"^/\* quantity: (.+) \*/$", re.MULTILINE)
_DEFINE = re.compile(r"^#define (\w+) (.+)$", re.MULTILINE)
# What would end a comment, begin another, or be a trigraph; JSON has a second way to write each.
_UNSAFE = re.compile(r"(?<=\*)/|/(?=\*)|(?<=\?)\?")


def dump(tuned: Tuned) -> bytes:
    """A header in ASCII for C99 and C++17; it includes nothing and allocates nothing.

    The filters of :mod:`filters.kownacki` come with functions that run them, if all their
    numbers are there, of the discrete model; a filter with K1 and K2 also in its fixed form.
    """
    from jinja2 import Environment, StrictUndefined

    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters["comment"] = _comment
    template = environment.from_string(
        files(__package__).joinpath("header.h.j2").read_text("utf-8")
    )
    prefix = tuned.name.upper()
    text = template.render(
        prefix=prefix,
        head=flat(head(tuned)),
        dt=list(_macros(f"{prefix}_DT", np.array(tuned.dt))),
        states=[state.upper() for state in tuned.states],
        quantities=[
            (label(quantity), list(_macros(f"{prefix}_{quantity.name.upper()}", quantity.value)))
            for quantity in tuned.quantities
        ],
        functions=_functions(tuned),
    )
    return f"{text}\n".encode("ascii")


def load(data: bytes) -> Tuned:
    """What :func:`dump` wrote, from its macros for double and its comments."""
    text = data.decode("ascii").replace("\r\n", "\n").replace("\\\n", "")
    if not text.rstrip().endswith("_HEADER_INCLUDED */"):
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
    """The numbers that a macro stands for."""
    name = "_".join(parts).upper()
    if name not in macros:
        raise ValueError(f"it does not define {name}")
    return value_of(macros[name])


def _comment(value: Any) -> str:
    """JSON that stays inside its comment, on its line, whatever the text in it."""
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


def _functions(tuned: Tuned) -> list[tuple[str, str]]:
    """The filters to write in C, and the beginnings of their functions' names."""
    if tuned.convention != "discrete":
        return []  # these filters take the numbers of the discrete model
    stem = tuned.name.lower()
    wanted = {stem: tuned.filter}
    if tuned.filter in ("AccelerometerFilter", "GyroscopeFilter"):
        wanted[f"{stem}_fixed"] = "FixedGainFilter"
    shapes = {quantity.name: quantity.value.shape for quantity in tuned.quantities}
    return [
        (kind, stem)
        for stem, kind in wanted.items()
        if kind in _NEEDS and _NEEDS[kind].items() <= shapes.items()
    ]
