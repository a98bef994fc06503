"""Files of C: what they test of themselves, how large they are, that they are always the same."""

import ctypes
import hashlib
import os
import re
import subprocess
import sys
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import run
from tests.tuner.code.compiled import compile_in, needed, ran
from tests.tuner.code.made import FILTERS, KEPT
from tests.tuner.export_cases import nasty, tuned
from tuner.code.document import files, sources
from tuner.code.form import Form, ready, write_form
from tuner.code.reference import reference
from tuner.code.size import size
from tuner.code.trace import traced
from tuner.export.header import load

M4 = ["-std=c99", "-Os", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]


def first(record):
    return jax.tree.map(lambda leaf: np.asarray(leaf)[0], record)


@cache
def traced_once(name, precision):
    return ready(*FILTERS[name], precision)


@cache
def made(name, precision="double", tunable=False):
    if name not in KEPT:
        return traced_once(name, precision).form(name, tunable=tunable)
    filter, params, record = FILTERS[name]
    sample, keep = first(record), KEPT[name]
    code = write_form(name, filter, params, sample, precision, keep=keep, tunable=tunable)
    kept = traced(filter, params, sample, precision, keep).kept
    return Form(code, reference(filter, params, record, kept, precision))


def put(folder, name, found, text=None):
    """The three files in a folder."""
    text = text or files(tuned(name=name), f"{name}.h", [found])
    for end, part in ((".h", text.header), (".c", text.source), ("_selftest.c", text.selftest)):
        (folder / f"{name}{end}").write_text(part, "ascii")
    return text


def selftest_of(folder, name, *options):
    """What the self-test says of itself."""
    needed("gcc")
    sources = (f"{name}.c", f"{name}_selftest.c")
    compile_in(folder, "gcc", "-DSELFTEST_MAIN", *options, *sources, "-o", "alone", "-lm")
    return ran(folder, "./alone")


@pytest.mark.parametrize("tunable", [False, True], ids=["fixed", "tunable"])
@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", ["gyroscope", "extended5", "gravity"])
def test_the_selftest_passes_without_undefined_behaviour(tmp_path, name, precision, tunable):
    put(tmp_path, name, made(name, precision, tunable))
    done = selftest_of(
        tmp_path, name, "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover"
    )
    assert (done.returncode, done.stdout) == (0, "the filter does what it should\n"), done.stderr


@pytest.mark.parametrize(("name", "parameter"), [("gyroscope", "R"), ("gravity", "gyroscope")])
@pytest.mark.parametrize("precision", ["double", "float"])
def test_a_constant_that_is_off_by_a_thousandth_fails(tmp_path, name, precision, parameter):
    filter, params, record = FILTERS[name]
    found = made(name, precision)
    other = params._replace(**{parameter: 1.001 * getattr(params, parameter)})
    keep = [field.name for field in found.implementation.outputs]
    wrong = write_form(name, filter, other, first(record), precision, keep=keep)
    put(tmp_path, name, Form(wrong, found.reference))
    done = selftest_of(tmp_path, name)
    assert done.returncode == 1
    assert re.fullmatch(r"sample \d+ is off\n", done.stdout)


@pytest.mark.parametrize("name", ["gyroscope", "gravity"])
def test_most_branches_are_taken(tmp_path, name):
    needed("gcov")
    put(tmp_path, name, made(name, "float"))
    assert selftest_of(tmp_path, name, "-O0", "--coverage").returncode == 0
    (notes,) = (file.name for file in tmp_path.glob(f"*{name}.gcda"))
    told = ran(tmp_path, "gcov", "-b", f"{name}.c", "-o", notes).stdout
    own = told.partition(f"File '{name}.c'")[2]
    assert float(re.search(r"Taken at least once:([\d.]+)%", own)[1]) >= 75


def test_it_refuses_options_that_take_nan_away(tmp_path):
    needed("gcc")
    put(tmp_path, "gyroscope", made("gyroscope"))
    done = ran(tmp_path, "gcc", "-std=c99", "-ffast-math", "-c", "gyroscope.c")
    assert done.returncode == 1
    assert "NaN is a missing sample: compile without -ffast-math" in done.stderr


SIZES = {
    "gyroscope": (240, 512),
    "linear4": (1000, 512),
    "extended5": (2100, 512),
    "gravity": (5632, 512),
    "euler7": (5500, 2000),
    "room21": (14_000, 6000),
}
"""Bytes of code, and of stack, on a Cortex-M4F."""
SHOWN = {
    "gyroscope": None,
    "linear4": ("x",),
    "extended5": ("x",),
    "gravity": ("att", "b"),
    "euler7": ("x", "angles"),
    "room21": ("att", "rest"),
}


@pytest.mark.parametrize("name", SIZES)
def test_it_is_small_on_a_controller(tmp_path, name):
    needed("arm-none-eabi-gcc")
    filter, params, record = FILTERS[name]
    code = write_form(name, filter, params, first(record), "float", keep=SHOWN[name])
    header, source = sources(tuned(name=name), f"{name}.h", [code])
    (tmp_path / f"{name}.h").write_text(header)
    (tmp_path / f"{name}.c").write_text(source)
    done = ran(tmp_path, "arm-none-eabi-gcc", *M4, "-fstack-usage", "-c", f"{name}.c", "-o", "a.o")
    assert done.returncode == 0, done.stderr
    told = ran(tmp_path, "arm-none-eabi-size", "a.o").stdout.splitlines()[1].split()[0]
    stacks = re.findall(r"\t(\d+)\t", (tmp_path / "a.su").read_text())
    code, stack = SIZES[name]
    assert int(told) <= code
    assert max(map(int, stacks)) <= stack


def test_what_the_compiler_of_this_machine_makes_of_it_is_measured():
    needed("cc")
    needed("size")
    text = files(tuned(name="gyroscope"), "gyroscope.h", [made("gyroscope")])
    found = size(text.header, text.source, "gyroscope.h")
    assert 200 < found.code < 4000
    assert 0 < found.stack < 1000
    assert size(text.header, "no C", "gyroscope.h") is None


AGAIN = """
import hashlib, sys
from tests.tuner.code.test_c_files import made
from tests.tuner.export_cases import tuned
from tuner.code.document import files, sources
found = [files(tuned(name=n), f"{n}.h", [made(n, "float")]) for n in sys.argv[1:]]
texts = [text for one in found for text in (one.header, one.source, one.selftest)]
print(*(hashlib.sha256(text.encode()).hexdigest() for text in texts))
"""


def test_the_text_is_the_same_in_every_run():
    """Whatever was traced before, and whatever order sets have."""
    names = ["extended5", "gyroscope", "euler7"]
    here = [files(tuned(name=n), f"{n}.h", [made(n, "float")]) for n in reversed(names)][::-1]
    texts = [text for one in here for text in (one.header, one.source, one.selftest)]
    environment = os.environ | {"PYTHONHASHSEED": "7", "PYTHONPATH": os.pathsep.join(sys.path)}
    there = subprocess.run(
        [sys.executable, "-c", AGAIN, *names], env=environment, capture_output=True, check=True
    )
    assert there.stdout.decode().split() == [hashlib.sha256(t.encode()).hexdigest() for t in texts]


def test_the_header_holds_the_numbers_whatever_they_are_called(tmp_path):
    needed("gcc")
    text = files(nasty(), "gyro.h", [made("gyroscope")])
    assert load(text.header.encode()) == nasty()
    assert load(text.whole.encode()) == nasty()
    put(tmp_path, "gyro", None, text)
    compile_in(tmp_path, "gcc", "-c", "gyro.c", "gyro_selftest.c")
    (tmp_path / "whole.c").write_text(text.whole)
    compile_in(tmp_path, "gcc", "-c", "whole.c")


def library(folder, name):
    compile_in(folder, "gcc", "-shared", "-fPIC", f"{name}.c", "-o", f"{name}.so", "-lm")
    return ctypes.CDLL(str(folder / f"{name}.so"))


def test_parameters_can_be_set_as_it_runs(tmp_path):
    """With other parameters a tunable filter is that of these parameters."""
    needed("gcc")
    filter, params, record = FILTERS["gyroscope"]
    put(tmp_path, "gyroscope", made("gyroscope", tunable=True))
    lib = library(tmp_path, "gyroscope")
    given = (ctypes.c_double * 6)()
    lib.gyroscope_defaults(given)
    assert list(given)[:2] == [0.3, 2.0]
    given[0] = 0.7
    tables, state = (ctypes.c_double * 8)(), (ctypes.c_double * 6)()
    lib.gyroscope_set(tables, given)
    lib.gyroscope_init(state, given)
    out, found = ctypes.c_double(), []
    for z in record[:100]:
        lib.gyroscope_step(state, ctypes.byref(ctypes.c_double(z)), ctypes.byref(out), tables)
        found.append(out.value)
    _, right = run(filter, params._replace(R=jnp.asarray(0.7)), jnp.asarray(record[:100]))
    np.testing.assert_allclose(found, right, rtol=1e-12)


def test_misra_finds_what_the_header_names(tmp_path):
    needed("cppcheck")
    put(tmp_path, "extended5", made("extended5", "float"))
    command = ("cppcheck", "--addon=misra", "--std=c99", "--enable=style,warning", "extended5.c")
    found = ran(tmp_path, *command).stderr
    if "Did not find addon" in found:
        pytest.skip("cppcheck has no MISRA addon here")
    assert set(re.findall(r"\[(\S+)\]$", found, re.MULTILINE)) <= {"misra-c2012-2.5"}


BARE = r"""
#include <stdint.h>
int main_selftest(void);
extern char top[];
void reset(void);
static void leave(int code)
{
    uint32_t block[2] = {0x20026u, (uint32_t)code};
    register uint32_t what __asm__("r0") = 0x20u;
    register uint32_t *where __asm__("r1") = block;
    __asm__ volatile("bkpt 0xab" : : "r"(what), "r"(where) : "memory");
}
void reset(void)
{
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* the floating-point unit */
    __asm__ volatile("dsb\n isb");
    leave(main_selftest());
    for (;;) { }
}
__attribute__((section(".vectors"), used)) void *const vectors[2] = {top, (void *)reset};
"""
LAYOUT = """
MEMORY { rom : ORIGIN = 0, LENGTH = 4M  ram : ORIGIN = 0x20000000, LENGTH = 4M }
SECTIONS
{
    .text : { KEEP(*(.vectors)) *(.text*) *(.rodata*) } > rom
    .ARM.exidx : { *(.ARM.exidx*) } > rom
    .data : { *(.data*) *(.bss*) *(COMMON) } > ram
    top = ORIGIN(ram) + LENGTH(ram);
}
"""


@pytest.mark.parametrize("name", ["extended5", "gravity"])
def test_the_selftest_passes_on_an_emulated_controller(tmp_path, name):
    """With the controller's own fused products and its own library of functions."""
    needed("arm-none-eabi-gcc")
    needed("qemu-system-arm")
    put(tmp_path, name, made(name, "float"))
    (tmp_path / "bare.c").write_text(BARE.replace("main_selftest", f"{name}_selftest"))
    (tmp_path / "layout.ld").write_text(LAYOUT)
    flags = (*(f for f in M4 if f != "-std=c99"), "-O2", "-nostartfiles", "-T", "layout.ld")
    sources = ("bare.c", f"{name}.c", f"{name}_selftest.c")
    built = ran(tmp_path, "arm-none-eabi-gcc", *flags, *sources, "-o", "a.elf", "-lm")
    assert built.returncode == 0, built.stderr
    machine = "-M mps2-an386 -nographic -monitor none -semihosting-config enable=on,target=native"
    command = ("timeout", "60", "qemu-system-arm", *machine.split(), "-kernel", "a.elf")
    assert ran(tmp_path, *command).returncode == 0
