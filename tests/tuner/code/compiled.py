"""C that was generated, compiled into one library, and called with arrays."""

import ctypes
import shutil
import subprocess
from dataclasses import dataclass
from functools import cached_property

import jax
import numpy as np
import pytest

WARNINGS = (
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wshadow",
    "-Wsign-conversion",
    "-Werror",
)
COMPILERS = {
    "gcc": ("gcc", "-std=c99", "-Wstrict-prototypes", "-Wmissing-prototypes"),
    "g++": ("g++", "-std=c++17", "-x", "c++"),
    "clang": ("clang", "-std=c99", "-Wstrict-prototypes", "-Wmissing-prototypes"),
}


def needed(program):
    """Skip where a compiler is missing."""
    if shutil.which(program) is None:
        pytest.skip(f"there is no {program}")


def compile_in(folder, compiler, *arguments):
    """What a compiler says of files in a folder, with all warnings as errors."""
    command = [*COMPILERS[compiler], *WARNINGS, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:4000]
    return done


def ran(folder, *command):
    """What a program prints."""
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


@dataclass(frozen=True)
class Library:
    """Generated filters, each with a function that runs it over samples of doubles.

    Attributes:
        folder: where the files are.
        forms: what was written, by stem.
    """

    folder: object
    forms: dict

    def drivers(self):
        """The text of the functions that run the filters."""
        return "\n".join(["#include <stddef.h>", *(_driver(form) for form in self.forms.values())])

    @cached_property
    def loaded(self):
        (self.folder / "drivers.c").write_text(self.drivers())
        sources = [f"{stem}.c" for stem in self.forms]
        compile_in(self.folder, "gcc", "-O0", "-fPIC", "-c", *sources)
        objects = [f"{stem}.o" for stem in self.forms]
        command = ["gcc", "-std=c99", "-shared", "-fPIC", "-o", "all.so", "drivers.c", *objects]
        subprocess.run([*command, "-lm"], cwd=self.folder, check=True)
        return ctypes.CDLL(str(self.folder / "all.so"))

    def run(self, stem, inputs):
        """The outputs over a record, a field each, time first."""
        code = self.forms[stem]
        columns = [np.asarray(a, float).reshape(len(a), -1) for a in jax.tree.leaves(inputs)]
        z = np.ascontiguousarray(np.hstack(columns))
        y = np.zeros((len(z), sum(field.size for field in code.outputs)))
        doubles = np.ctypeslib.ndpointer(np.float64, flags="C_CONTIGUOUS")
        function = getattr(self.loaded, f"run_{stem}")
        function.argtypes, function.restype = [ctypes.c_size_t, doubles, doubles], None
        function(len(z), z, y)
        return _unpacked(code.outputs, y)


def _driver(code):
    stem = code.stem
    cast = {"real": f"({code.precision})", "truth": "0.0 != ", "whole": "(int)"}
    lines = [f'#include "{stem}.h"', f"void run_{stem}(size_t n, const double *z, double *y);"]
    lines += [f"void run_{stem}(size_t n, const double *z, double *y)", "{"]
    lines += [f"{stem}_state s;", f"{stem}_input in;", f"{stem}_output out;"]
    tables = ""
    if code.params:
        lines += [f"{stem}_params p;", f"{stem}_tables t;", f"{stem}_defaults(&p);"]
        lines += [f"{stem}_set(&t, &p);"]
        tables = ", &t"
    lines += [f"{stem}_init(&s{', &p' if tables else ''});", "for (size_t k = 0; k < n; k++) {"]
    places = [(f, i) for f in code.inputs for i in f.entries()]
    for at, (field, index) in enumerate(places):
        lines.append(f"in.{field.place(index)} = {cast[field.kind]}z[{at}];")
    lines += [f"z += {len(places)};", f"{stem}_step(&s, &in, &out{tables});"]
    places = [(f, i) for f in code.outputs for i in f.entries()]
    for at, (field, index) in enumerate(places):
        lines.append(f"y[{at}] = (double)out.{field.place(index)};")
    return "\n".join([*lines, f"y += {len(places)};", "}", "}"])


def _unpacked(fields, y):
    found, at = [], 0
    for field in fields:
        array = np.empty((len(y), *field.shape))
        for k, index in enumerate(field.entries()):
            array[(slice(None), *index)] = y[:, at + k]
            if field.half:
                array[(slice(None), *index[::-1])] = y[:, at + k]
        found.append(array)
        at += field.size
    return found
