"""The C header, compiled: its numbers to the bit, and its filters against those of JAX."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import given, settings

from tests.tuner.export_cases import gyroscope, nasty, tuned, tuned_filters
from tuner.export import Quantity, dump

WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Werror")
LANGUAGES = {"c": ("gcc", "-std=c99"), "c++": ("g++", "-std=c++17")}


@pytest.fixture(params=LANGUAGES)
def language(request):
    if shutil.which(LANGUAGES[request.param][0]) is None:
        pytest.skip(f"there is no {LANGUAGES[request.param][0]} to compile with")
    return request.param


def ran(folder, language, tuned, main, *options, given=b""):
    """What a program prints that has the header and this body of main."""
    compiler, standard = LANGUAGES[language]
    (folder / "tuned.h").write_bytes(dump(tuned, "c"))
    lines = ("#include <stdio.h>", '#include "tuned.h"', '#include "tuned.h"')
    body = ("int main(void)", "{", *main, "return 0;", "}")
    (folder / "main.txt").write_text("\n".join([*lines, *body, ""]))
    command = [compiler, standard, *WARNINGS, *options, "-x", language, "main.txt", "-o", "main"]
    compiled = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert compiled.returncode == 0, compiled.stderr
    return subprocess.run(["./main"], cwd=folder, input=given, stdout=-1, check=True).stdout


def printing(tuned):
    """The lines of main that print every macro: first those for double, then those for float."""
    prefix = tuned.name.upper()
    values = {"DT": np.array(tuned.dt)} | {q.name.upper(): q.value for q in tuned.quantities}
    for suffix, number, digits in (("", "double", "%.17g"), ("_F", "float", "%.9g")):
        for name, value in values.items():
            macro = f"{prefix}_{name}{suffix}"
            rows, columns = f"[{prefix}_{name}_ROWS]", f"[{prefix}_{name}_COLS]"
            size = (rows + columns)[: [0, len(rows), None][value.ndim]]
            items = ["x" + "".join(f"[{i}]" for i in index) for index in np.ndindex(value.shape)]
            yield f"#ifdef {macro}"
            yield f"{{ const {number} x{size} = {macro};"
            yield from (f'printf("{digits}\\n", (double){item});' for item in items)
            yield "}\n#else"
            yield from ['puts("none");'] * value.size
            yield "#endif"


def check_numbers(folder, language, tuned):
    printed = ran(folder, language, tuned, printing(tuned)).decode().split()
    values = [np.array(tuned.dt), *(quantity.value for quantity in tuned.quantities)]
    doubles = np.concatenate([value.ravel() for value in values])
    assert np.array(printed[: doubles.size], float).tobytes() == doubles.tobytes()
    floats = np.concatenate([nearest(value).ravel() for value in values])
    found = [np.nan if text == "none" else float(text) for text in printed[doubles.size :]]
    assert np.array(found, np.float32).tobytes() == floats.tobytes()


def nearest(value):
    """The nearest floats; NaN where one of them is not a normal number."""
    with np.errstate(all="ignore"):
        narrow = value.astype(np.float32)
    limits = np.finfo(np.float32)
    bad = ~np.isfinite(narrow) | ((np.abs(narrow) < limits.tiny) & (value != 0))
    return np.full_like(narrow, np.nan) if bad.any() else narrow


@pytest.mark.parametrize("case", [nasty, gyroscope])
def test_every_macro_is_its_number_to_the_bit(tmp_path, language, case):
    check_numbers(tmp_path, language, case())


@settings(max_examples=10)
@given(tuned=tuned_filters())
def test_any_filter_compiles(tmp_path_factory, tuned):
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc to compile with")
    check_numbers(tmp_path_factory.mktemp("header"), "c", tuned)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.9148e-10, "1.9148e-10f"),
        (1 / 3, "0.33333334f"),
        (-0.0, "(-0.0f)"),
        (16777217.0, "1.6777216e+07f"),
        (3.4028234663852886e38, "3.4028235e+38f"),
        (3.4028235677973366e38, None),
        (1.1754943508222875e-38, "1.1754944e-38f"),
        (1.17549425e-38, None),
        (1e-50, None),
    ],
)
def test_floats_have_the_fewest_digits(value, text):
    header = dump(tuned(Quantity("x", np.array(value), "")), "c").decode()
    found = re.search(r"^#define GYRO_X_F (.*)$", header, re.MULTILINE)
    assert (found and found[1]) == text
    assert ("/* GYRO_X_F is left out" in header) == (text is None)


def test_states_and_sizes(tmp_path, language):
    names = ["STATES", "STATE_OMEGA", "STATE_EPSILON", "P0_ROWS", "P0_COLS"]
    main = [f'printf("%d ", GYRO_{name});' for name in names]
    assert ran(tmp_path, language, gyroscope(), main) == b"2 0 1 2 2 "


@pytest.mark.parametrize("options", [(), ("-O2",)])
def test_nothing_in_it_needs_to_be_used(tmp_path, language, options):
    assert ran(tmp_path, language, gyroscope(), [], *options) == b""


def test_text_stays_in_its_comment():
    header = dump(nasty(), "c").decode("ascii")
    assert header.count("*/") == header.count("/*")
    assert "??" not in header
    assert all(line.isprintable() for line in header.splitlines())
