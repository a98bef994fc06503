"""C whose numbers stand in memory, where they are changed one at a time."""

import ctypes
import re
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tuner.code.fields import Field
from tuner.code.implementation import Implementation
from tuner.code.literal import Precision
from tuner.code.operations import Kind
from tuner.code.selftest_tables import stored
from tuner.code.states import Arrays

NUMBER = r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)f?\b"
"""A number that is not whole in C."""
_COMPARISON = r"(?<!-)[<>]|==|!="
_FUNCTIONS = re.findall(
    r"\w+",
    "fabs rint fmod sqrt cbrt sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp exp2 "
    "expm1 log log1p floor ceil erf erfc lgamma pow atan2",
)
_BEGINNING = """
static const signed char *forced;
static int *taken_so;
static int decided(int k, int as_it_is)
{
    taken_so[k] += as_it_is;
    return (forced == 0 || forced[k] == 0) ? as_it_is : (forced[k] > 0);
}
"""
_DRIVER = """
#include <stddef.h>
#include <string.h>
static void taken(const double *given, {real} *found)
{{
    {stem}_state state;
    {stem}_input input;
    {stem}_output output;
    memset(&output, 0, sizeof output);
{placed}
    {stem}_step(&state, &input, &output);
{found}
}}

void changed(int k, double by, size_t n, const double *given, const signed char *forces,
    const signed char *others, int *turned, double *right, double *apart)
{{
    {real} one[{results}], other[{results}];
    int outcomes[{decisions} + 1];
    const {real} before = *place(k);
    for (size_t i = 0; i < n; i++) {{
        taken_so = outcomes;
        memset(outcomes, 0, sizeof outcomes);
        forced = (forces != 0) ? forces + i * {decisions} : 0;
        *place(k) = before;
        taken(given + i * {width}, one);
        taken_so = turned + i * {decisions};
        forced = (others != 0) ? others + i * {decisions} : 0;
        *place(k) = before * ({real})by;
        taken(given + i * {width}, other);
        for (size_t d = 0; d < {decisions}; d++) {{
            turned[i * {decisions} + d] -= outcomes[d];
        }}
        for (size_t j = 0; j < {results}; j++) {{
            const int missing = isnan(one[j]), same = missing == isnan(other[j]);
            right[i * {results} + j] = (double)one[j];
            apart[i * {results} + j] = !same ? (double)INFINITY
                : (missing || one[j] == other[j]) ? 0.0 : (double)(other[j] - one[j]);
        }}
    }}
    *place(k) = before;
}}
"""


def changeable(source: str, real: Precision) -> tuple[str, list[str]]:
    """The same C with its numbers in memory, and the line of each of them.

    >>> text, lines = changeable("double twice(double x) { return 2.0 * x; }", "double")
    >>> text.splitlines()[1:3]
    ['double twice(double x) { return numbers[0] * x; }', 'double *place(int k)']
    """
    source = re.sub(r"/\*.*?\*/", "", source, flags=re.DOTALL)
    source = re.sub(rf"static const {real} (\w+)\[", rf"static {real} \1[", source)
    numbers: list[str] = []
    places: list[str] = []
    lines: list[str] = []

    def line_of(found: re.Match[str]) -> str:
        text = found.string
        return text[text.rfind("\n", 0, found.start()) + 1 : text.find("\n", found.end())].strip()

    def in_memory(found: re.Match[str]) -> str:
        if float(found[1]) == 0:
            return found[0]
        places.append(f"&numbers[{len(numbers)}]")
        numbers.append(found[0])
        lines.append(line_of(found))
        return f"numbers[{len(numbers) - 1}]"

    tables = re.compile(rf"static {real} (\w+)\[\d+\] = {{(.*?)}};", re.DOTALL)
    parts, end = [], 0
    for table in tables.finditer(source):
        parts += [re.sub(NUMBER, in_memory, source[end : table.start()]), table[0]]
        end = table.end()
        for k, entry in enumerate(table[2].split(",")):
            value = re.search(NUMBER, entry)
            if value and float(value[1]) != 0:
                places.append(f"&{table[1]}[{k}]")
                lines.append(f"{table[1]}[{k}] = {value[0]}")
    parts.append(re.sub(NUMBER, in_memory, source[end:]))
    head = f"static {real} numbers[] = {{{', '.join(numbers) or '0'}}};"
    ends = [f"{real} *place(int k)", "{"]
    ends += [f"    static {real} *const places[] = {{{', '.join([*places, '0'])}}};"]
    return "\n".join([head, "".join(parts), *ends, "    return places[k];", "}", ""]), lines


def undecided(source: str) -> tuple[str, int]:
    """The same C whose comparisons may be decided otherwise, and their number.

    Whether a number is missing is left as it is: some of what follows from it is told by that.

    >>> undecided("const bool much = x > 3.0; y = much ? x : ((x < 1.0) ? 1.0 : z);")
    ('const bool much = decided(0, x > 3.0); y = much ? x : (decided(1, (x < 1.0)) ? 1.0 : z);', 2)
    """
    found: list[str] = []

    def number(text: str) -> int:
        found.append(text)
        return len(found) - 1

    def decided(one: re.Match[str]) -> str:
        if not re.search(_COMPARISON, one[2]):
            return one[0]
        return f"{one[1]}decided({number(one[2])}, {one[2]});"

    source = re.sub(r"(const bool \w+ = )(.*?);", decided, source, flags=re.DOTALL)
    at = source.find(") ?")
    while at >= 0:
        depth, begin = 1, at
        while depth:
            begin -= 1
            depth += {")": 1, "(": -1}.get(source[begin], 0)
        while re.match(r"[\w!]", source[begin - 1]):
            begin -= 1
        condition = source[begin : at + 1]
        if re.search(_COMPARISON, condition):
            new = f"decided({number(condition)}, {condition})"
            source = source[:begin] + new + source[at + 1 :]
            at += len(new) - len(condition)
        at = source.find(") ?", at + 1)
    return source, len(found)


class Moved(NamedTuple):
    """The effect of a change.

    Attributes:
        right: the results without it, ``(B, results)``.
        apart: by how much they move.
        turned: whether a decision would be taken otherwise, ``(B, decisions)``.
    """

    right: np.ndarray
    apart: np.ndarray
    turned: np.ndarray


@dataclass(frozen=True, eq=False)
class Changed:
    """A filter's step in C, one number of which is changed.

    Attributes:
        code: the filter.
        header: its text.
        source: with its numbers in memory.
        folder: where it is compiled.
        wide: whether it computes with 113 bits, in which rounding hides no effect.
    """

    code: Implementation
    header: str
    source: str
    folder: Path
    wide: bool = False

    def moved(
        self,
        number: int,
        change: float,
        states: Arrays,
        samples: Arrays,
        forces: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> "Moved":
        """What becomes of the stored entries of the next state and of the outputs.

        Args:
            number: which one is changed.
            change: by which share of it.
            states: a field each, ``(B, ...)``.
            samples: a field each.
            forces: 1 or -1 for decisions that are forced to be true or false, before the change
                and after it, ``(B, decisions)``.
        """
        fields = [*stored(self.code.state, states), *stored(self.code.inputs, samples)]
        given = np.ascontiguousarray(np.hstack([x for x in fields if x.size]), float)
        right, apart = np.zeros((2, len(given), self._results))
        turned = np.zeros((len(given), self.decisions), np.int32)
        both = [np.ascontiguousarray(one, np.int8) for one in forces or ()]
        places: list[int | None] = [*(one.ctypes.data for one in both)] or [None, None]
        ends = turned.ctypes.data, right, apart
        self._function(number, 1 + change, len(given), given, *places, *ends)
        return Moved(right, apart, turned != 0)

    def value(self, number: int) -> float:
        """The number itself."""
        place = self._library.place
        kind = ctypes.c_float if self.code.precision == "float" else ctypes.c_double
        place.argtypes, place.restype = [ctypes.c_int], ctypes.POINTER(kind)
        return float(place(number)[0])

    @cached_property
    def decisions(self) -> int:
        """Number of decisions that can be forced."""
        return undecided(self.source)[1]

    @property
    def _results(self) -> int:
        return sum(field.size for field in (*self.code.state, *self.code.outputs))

    @cached_property
    def _library(self) -> ctypes.CDLL:
        real, stem = self.code.precision, self.code.stem
        name, libraries = "plain", ["-lm"]
        texts = [self.header, undecided(self.source)[0]]
        if self.wide:
            name, libraries = "wide", ["-lquadmath", "-lm"]
            texts = [re.sub(rf"\b{real}\b", "__float128", x) for x in texts]
        header, source = texts
        (self.folder / f"{name}.h").write_text(header)
        source = source.replace(f'#include "{stem}.h"', f'#include "{name}.h"')
        if self.wide:
            source = source.replace("#include <math.h>", _wide_functions(real))
        text = _BEGINNING + source + self._driver("__float128" if self.wide else real)
        (self.folder / f"{name}.c").write_text(text)
        command = ["gcc", "-std=gnu99", "-O1", "-w", "-shared", "-fPIC", f"{name}.c"]
        command += ["-o", f"{name}.so", *libraries]
        subprocess.run(command, cwd=self.folder, check=True)
        return ctypes.CDLL(str(self.folder / f"{name}.so"))

    @cached_property
    def _function(self) -> Any:
        function = self._library.changed
        doubles = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
        function.argtypes = [ctypes.c_int, ctypes.c_double, ctypes.c_size_t, doubles]
        function.argtypes += [*[ctypes.c_void_p] * 3, doubles, doubles]
        function.restype = None
        return function

    def _driver(self, real: str) -> str:
        code, cast = self.code, {"real": f"({real})", "truth": "0.5 < ", "whole": "(int)"}
        given = [*_places("state", code.state), *_places("input", code.inputs)]
        found = [*_places("state", code.state), *_places("output", code.outputs)]
        return _DRIVER.format(
            stem=code.stem,
            real=real,
            width=len(given),
            results=len(found),
            decisions=self.decisions,
            placed="\n".join(
                f"    {place} = {cast[kind]}given[{at}];" for at, (place, kind) in enumerate(given)
            ),
            found="\n".join(
                f"    found[{at}] = ({real}){place};" for at, (place, _) in enumerate(found)
            ),
        )


def _places(part: str, fields: Sequence[Field]) -> Iterator[tuple[str, Kind]]:
    for field in fields:
        for index in field.entries():
            yield f"{part}.{field.place(index)}", field.kind


def _wide_functions(real: Precision) -> str:
    """The functions of math.h with 113 bits, under their usual names."""
    end = "f" if real == "float" else ""
    lines = [f"#define {name}{end} {name}q" for name in _FUNCTIONS]
    return "\n".join(["#include <math.h>", "#include <quadmath.h>", *lines])
