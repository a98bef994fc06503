"""The C that copies one half of a symmetric matrix to the other."""

import ctypes

import numpy as np
import pytest

from tuner.compiler import NoCodeError, compiler, library
from tuner.native.filled import address
from tuner.native.mirrored import mirrors

CALL = "void call(double *m, int row, int size) { mirror(m, row, size); }\n"
WITHOUT = "#undef __has_builtin\n#define __has_builtin(x) 0\n"
"""As by a compiler that has no function for entries of vectors."""


@pytest.fixture(params=["", WITHOUT], ids=["by vectors", "entry by entry"])
def mirror(request, tmp_path):
    try:
        compiler()
    except NoCodeError as error:
        pytest.skip(str(error))
    (function,) = mirrors([CALL])
    head = "#include <stdbool.h>\n"
    found = library(head + request.param + function + CALL, tmp_path / "code").call
    found.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_int]
    found.restype = None
    return found


@pytest.mark.parametrize("size", [1, 3, 4, 5, 8, 11, 12, 17])
@pytest.mark.parametrize("beyond", [0, 3])
def test_what_is_above_the_diagonal_becomes_what_is_below(mirror, size, beyond):
    memory = np.random.default_rng(size).normal(size=(size + 1, size + beyond))
    before, square = memory.copy(), memory[:size, :size]
    mirror(address(memory), size + beyond, size)
    lower = np.tril(before[:size, :size])
    assert np.array_equal(square, lower + np.tril(lower, -1).T)
    assert np.array_equal(memory[:size, size:], before[:size, size:])
    assert np.array_equal(memory[size], before[size])
