"""Sines of C that is compiled for a gradient, against the library's."""

import ctypes
import math

import numpy as np

from tests.tuner.code.compiled import needed
from tuner.compiler import library
from tuner.native.sines import sines

CALLED = """
double sine_of(double x) { return circular(x).sine; }
double cosine_of(double x) { return circular(x).cosine; }
"""


def test_sines_equal_the_library_s(tmp_path):
    needed("cc")
    code = library(f"#include <math.h>\n{sines()}{CALLED}", tmp_path)
    draw = np.random.default_rng(0)
    angles = [*draw.uniform(-7, 7, 2000), *draw.uniform(-9e4, 9e4, 2000)]
    angles += [k * math.pi / 4 for k in range(-40, 41)] + [1e-300, 0.0, 1e22, -3e7]
    for function, right in ((code.sine_of, math.sin), (code.cosine_of, math.cos)):
        function.argtypes, function.restype = [ctypes.c_double], ctypes.c_double
        for x in angles:
            # Two units in the last place; near its zeros an angle is reduced to 1e-27.
            assert abs(function(x) - right(x)) <= 5e-16 * abs(right(x)) + 1e-27
        assert all(math.isnan(function(x)) for x in (math.nan, math.inf, -math.inf))
