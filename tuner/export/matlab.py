"""A script for MATLAB and Octave: a struct of the numbers, and the steady loop if there is one."""

import json
import re
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from tuner.export.arrays import labelled
from tuner.export.document import flat, head, label, nested, tuned_from
from tuner.export.tuned import Quantity, Tuned

_LINE = re.compile(r"^% ([\w.]+): (.+)$", re.MULTILINE)
_QUANTITY = re.compile(r"^% quantity: (.+)\n\w+\.\w+ = ([^\[;]+|\[[^\]]*\]);$", re.MULTILINE)
# The transition of the state, where a quantity's meaning shows that it is the model of K: a
# parameter may have the same name.
_MODEL = {"F": ("F", "x' = F x"), "A": ("K", "L = A K")}
_OWN = {"dt", "convention", "states", "predict", "update"}
# Reserved in MATLAB or Octave: no field or variable may have such a name.
_KEYWORD = re.compile(
    r"""break|case|catch|classdef|continue|do|else|elseif|enumeration|events|for|function|global|if
    |methods|otherwise|parfor|persistent|properties|return|spmd|switch|try|until|while
    |unwind_protect(_cleanup)?
    |arguments|end(_try_catch|_unwind_protect|arguments|classdef|enumeration|events|for|function|if|methods|parfor
    |properties|spmd|switch|while)?""",
    re.VERBOSE,
)


def dump(tuned: Tuned) -> bytes:
    """Lines of ASCII; running the script makes a struct of the filter's name."""
    return "\n".join([*_lines(tuned), ""]).encode("ascii")


def _lines(tuned: Tuned) -> Iterator[str]:
    own = _identifier(tuned.name, set())
    yield "% A tuned filter, written by filter-tuner for MATLAB and Octave; do not edit it, export"
    yield f"% it again. The script makes the struct {own}; vectors are columns, and time is in s."
    yield "%"
    for key, value in flat(head(tuned)).items():
        yield f"% {key}: {json.dumps(value)}"
    yield from ("", f"{own} = struct();", f"{own}.dt = {tuned.dt!r};")
    yield f"{own}.convention = '{tuned.convention}';"
    states = ", ".join(f"'{state}'" for state in tuned.states)
    yield f"{own}.states = {{{states}}};"
    for quantity in tuned.quantities:
        yield from ("", f"% quantity: {json.dumps(label(quantity))}")
        yield f"{own}.{_identifier(quantity.name, _OWN)} = {_literal(quantity.value)};"
    yield from _loop(tuned, own)
    yield from ("", _end(tuned.name))


def _loop(tuned: Tuned, own: str) -> Iterator[str]:
    """The filter with its steady gain, where the model is among the numbers."""
    named = {q.name: q for q in tuned.quantities}
    move = next(
        (m for m, (name, meaning) in _MODEL.items() if meaning in _meaning(named, name)), ""
    )
    F, C, K = ((*named[n].value.shape, 1, 1)[:2] if n in named else () for n in (move, "C", "K"))
    if not (F and K and C == K[::-1] == (C[0], F[0]) and tuned.dt > 0):
        return
    yield ""
    yield "% With the steady gain, a sample of z, NaN where it is missing, after the other:"
    yield f"%     x = zeros({F[0]}, 1);"
    yield "%     for k = 1:size(z, 2)"
    yield f"%         x = {own}.update({own}.predict(x), z(:, k));"
    yield "%     end"
    yield f"{own}.predict = @(x) {own}.{move} * x;"
    seen = "~isnan(z)"
    gain, rest = f"{own}.K(:, {seen})", f"z({seen}, 1) - {own}.C({seen}, :) * x"
    yield f"{own}.update = @(x, z) x + {gain} * ({rest});"


def _meaning(named: Mapping[str, Quantity], name: str) -> str:
    return named[name].meaning if name in named else ""


def load(data: bytes) -> Tuned:
    """The tuned filter that :func:`dump` wrote, from comments and numbers; nothing is run."""
    text = data.decode("ascii").replace("\r\n", "\n")
    above = {key: json.loads(value) for key, value in _LINE.findall(text.partition("\n\n")[0])}
    if not isinstance(above.get("name"), str) or not text.rstrip().endswith(_end(above["name"])):
        raise ValueError("it names no tuned filter, or is cut short")
    found = [(json.loads(line), numbers) for line, numbers in _QUANTITY.findall(text)]
    if len(found) != text.count("\n% quantity: "):
        raise ValueError("it has a quantity without numbers")
    arrays = {entry["name"]: _value(numbers) for entry, numbers in found}
    return tuned_from(nested(above), [labelled(entry, arrays) for entry, _ in found])


def _end(name: str) -> str:
    return f"% end of {name}"


def _identifier(name: str, taken: set[str]) -> str:
    return f"{name}_" if name in taken or _KEYWORD.fullmatch(name) else name


def _literal(value: NDArray[np.float64]) -> str:
    """A number, or rows in brackets."""
    if value.ndim == 0:
        return repr(float(value))
    rows = value[:, None] if value.ndim == 1 else value
    return f"[{'; '.join(', '.join(repr(float(x)) for x in row) for row in rows)}]"


def _value(text: str) -> NDArray[np.float64]:
    if not text.startswith("["):
        return np.array(float(text))
    return np.array([[float(x) for x in row.split(",")] for row in text[1:-1].split(";")])
