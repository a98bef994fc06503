"""Every filter of the conformance battery in C, against JAX."""

import re
from functools import cache, partial

import jax
import numpy as np
import pytest

from filters import run
from tests.filters.battery import CASES
from tests.tuner.code.compiled import COMPILERS, Library, compile_in, needed
from tests.tuner.export_cases import tuned
from tuner.code.document import sources
from tuner.code.form import write_form
from tuner.code.refused import NoCounterpartError

LENGTH = 2000
REFUSED = {"covariance, continuous": "custom_linear_solve"}
"""Cases that have no C, with the operation that says why."""
FLOAT = ("gyroscope", "extended, two rates", "Madgwick, field", "constant velocity, two axes")
quickly = partial(jax.jit, compiler_options={"xla_backend_optimization_level": 0})


def stem_of(case):
    return re.sub(r"\W+", "_", case.name).strip("_").lower()[:25].strip("_")


def record(case):
    """Samples of a case again and again, a little different each time, with other holes."""
    draw = np.random.default_rng(3)
    parts = []
    for _ in range(4):
        measured = np.array(case.measured)
        if case.holes:
            measured[draw.random(len(measured)) < 0.1] = np.nan
        parts.append(jax.tree.map(np.asarray, case.inputs(measured)))
    turns = -(-LENGTH // (len(case.measured) * len(parts)))

    def repeated(*leaves):
        whole = np.concatenate(leaves * turns)[:LENGTH]
        if whole.dtype.kind == "f":
            whole = whole * (1 + 1e-3 * draw.standard_normal(whole.shape))
        return whole

    return jax.tree.map(repeated, *parts)


@cache
def expected(name, dtype=np.float64):
    case = next(case for case in CASES if case.name == name)

    def cast(tree):
        leaves = jax.tree.map(np.asarray, tree)
        return jax.tree.map(lambda a: a.astype(dtype) if a.dtype.kind == "f" else a, leaves)

    ran = quickly(partial(run, case.filter))
    _, outputs = ran(cast(case.build(case.point)), cast(record(case)))
    return [np.asarray(leaf, float) for leaf in jax.tree.leaves(outputs)]


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """All that can be written, in a single library; float has names of its own."""
    needed("gcc")
    folder, forms = tmp_path_factory.mktemp("battery"), {}
    for case in CASES:
        if case.name in REFUSED:
            continue
        for precision in ("double", "float") if case.name in FLOAT else ("double",):
            stem = stem_of(case) + ("_f" if precision == "float" else "")
            sample = jax.tree.map(lambda leaf: np.asarray(leaf)[0], case.inputs(case.measured))
            params = case.build(case.point)
            code = write_form(stem, case.filter, params, sample, precision, keep=None)
            forms[stem] = code
            header, source = sources(tuned(name=stem), f"{stem}.h", [code])
            (folder / f"{stem}.h").write_text(header)
            (folder / f"{stem}.c").write_text(source)
    return Library(folder, forms)


def largest(found, right):
    """How far each output is off, over its largest number; what is missing is missing in both."""
    for one, other in zip(found, right, strict=True):
        assert one.shape == other.shape
        assert np.array_equal(np.isnan(one), np.isnan(other))
        yield np.nanmax(np.abs(one - other), initial=0) / (np.nanmax(np.abs(other), initial=0) or 1)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_c_does_what_jax_does(library, case):
    if case.name in REFUSED:
        sample = jax.tree.map(lambda leaf: np.asarray(leaf)[0], case.inputs(case.measured))
        with pytest.raises(NoCounterpartError, match=REFUSED[case.name]):
            write_form("x", case.filter, case.build(case.point), sample, "double", keep=None)
        return
    found = library.run(stem_of(case), record(case))
    assert max(largest(found, expected(case.name))) <= 1e-12


@pytest.mark.parametrize("name", FLOAT)
def test_float_strays_as_far_as_jax_does(library, name):
    case = next(case for case in CASES if case.name == name)
    right = expected(name)
    ours = largest(library.run(f"{stem_of(case)}_f", record(case)), right)
    of_jax = largest(expected(name, np.float32), right)
    for one, other in zip(ours, of_jax, strict=True):
        assert one <= 2 * other + 1e-6


@pytest.mark.parametrize("compiler", ["g++", "clang"])
def test_no_compiler_warns(library, compiler):
    """Of all of them at once: a compiler takes longer for math.h than for a filter."""
    needed(compiler)
    lines = "".join(f'#include "{stem}.c"\n' for stem in library.forms)
    (library.folder / "every.c").write_text(lines)
    compile_in(library.folder, compiler, "-fsyntax-only", "every.c")
    assert "gcc" in COMPILERS  # which the library itself is compiled with, file by file
